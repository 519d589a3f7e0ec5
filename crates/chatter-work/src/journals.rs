//! Journals beside the files that long computations write.

use crate::refusal::Refusal;
use std::path::{Path, PathBuf};

/// The journal beside a file that is to be written.
pub fn journal_of(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_os_string();
    name.push(".journal");
    output.with_file_name(name)
}

/// Whether this version began a journal: another's results may differ in their last digits.
///
/// # Errors
/// Another did.
pub(crate) fn of_this_version(journal: &Path, began: &str) -> Result<(), Refusal> {
    let version = env!("CARGO_PKG_VERSION");
    if began == version {
        return Ok(());
    }
    let journal = journal.display();
    Err(Refusal::input(format!(
        "`{journal}` was begun by chatter {began}; this is chatter {version}, whose results may differ in their last digits",
    ))
    .help(format!(
        "go on with the version that began it, or delete `{journal}` and compute it anew",
    )))
}
