//! A file of any bytes is refused, or is a journal: its records stay, what is damaged is cut off, and more can follow.

use chatter_files::journal::Unread;
use std::path::Path;

/// Most bytes of a record that is read.
const LONGEST: u64 = 1 << 16;

/// Writes the bytes to `path` and opens them as a journal, twice.
pub fn law(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let Ok(found) = Unread::open(path) else {
        assert_eq!(std::fs::read(path).unwrap(), bytes, "refused and changed");
        return;
    };
    let unread = found.expect("it was written");
    let header = unread.header().to_vec();
    let mut records = Vec::new();
    let mut places = Vec::new();
    let read = unread.read(LONGEST, |place, record| {
        places.push(place);
        records.push(record.to_vec());
    });
    let mut journal = read.unwrap();
    let mut again = Vec::new();
    for (place, record) in places.iter().zip(&records) {
        journal.read(*place, &mut again).unwrap();
        assert_eq!(&again, record);
    }
    records.push(b"one more".to_vec());
    journal.append(b"one more").unwrap();
    drop(journal);
    assert!(std::fs::read(path).unwrap().starts_with(&bytes[..16]));
    let unread = Unread::open(path).unwrap().unwrap();
    assert_eq!(unread.header(), header);
    let mut found = Vec::new();
    unread
        .read(LONGEST, |_, record| found.push(record.to_vec()))
        .unwrap();
    assert_eq!(found, records);
}
