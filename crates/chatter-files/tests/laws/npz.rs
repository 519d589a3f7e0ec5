//! A file of any bytes is read as an NPZ archive or refused with a message, in memory of the order of its size.

use chatter_files::tables::{Kind, NpzReader};
use std::path::Path;

/// Writes the bytes to `path` and reads whatever is in there.
pub fn law(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let Ok(reader) = NpzReader::open(path) else {
        return;
    };
    let names: Vec<String> = reader.arrays().map(|array| array.name.clone()).collect();
    for name in names {
        let info = reader.info(&name).unwrap().clone();
        // An array is no larger than what can be compressed into its file, whatever its header claims.
        let most = 1032 * bytes.len().max(1);
        assert!(info.kind.size().saturating_mul(info.len()) <= most);
        match info.kind {
            Kind::Text { .. } => {
                if let Ok(texts) = reader.texts(&name) {
                    assert_eq!(texts.len(), info.len());
                    assert!(texts.len() <= most);
                }
                let _ = reader.text(&name);
                assert!(reader.floats(&name).is_err());
            }
            _ => {
                if let Ok(numbers) = reader.floats(&name) {
                    assert_eq!(numbers.len(), info.len());
                }
                let column = reader.column(&name);
                assert!(column.is_err() || column.unwrap().values.len() == info.len());
            }
        }
    }
}
