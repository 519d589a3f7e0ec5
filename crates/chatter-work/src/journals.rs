//! Journals beside the files that long computations write.

use crate::refusal::Refusal;
use chatter::analysis::diagram::Share;
use chatter_files::atomic_file::folder_of;
use chatter_files::journal::Unread;
use std::path::{Path, PathBuf};

/// The journal beside a file that is to be written.
pub fn journal_of(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_os_string();
    name.push(".journal");
    output.with_file_name(name)
}

/// The journal of a share of the work whose result is to be written to `output`.
pub fn shard_journal(output: &Path, share: Share) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let digits = share.of().to_string().len();
    let name = format!(
        "{stem}.{:0digits$}-of-{}.journal",
        share.number(),
        share.of()
    );
    output.with_file_name(name)
}

/// The journals of shares that lie beside `output`, of whatever number.
pub fn shards_beside(output: &Path) -> Vec<PathBuf> {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let is_whole = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_share = |name: &str| {
        let share = (name.strip_prefix(&*stem))
            .and_then(|rest| rest.strip_prefix('.')?.strip_suffix(".journal"));
        share
            .and_then(|share| share.split_once("-of-"))
            .is_some_and(|(number, of)| is_whole(number) && is_whole(of))
    };
    let Ok(entries) = std::fs::read_dir(folder_of(output)) else {
        return Vec::new();
    };
    let names = entries.flatten().map(|entry| entry.file_name());
    let mut shards: Vec<PathBuf> = names
        .filter(|name| is_share(&name.to_string_lossy()))
        .map(|name| output.with_file_name(name))
        .collect();
    shards.sort();
    shards
}

/// Opens the journals that are to be merged into `own`.
///
/// # Errors
/// There is none, one is given twice, or one cannot be opened.
pub(crate) fn parts<T>(
    journals: &[PathBuf],
    own: &Path,
    open: impl Fn(&Path) -> Result<Option<T>, Refusal>,
) -> Result<Vec<T>, Refusal> {
    // A pattern of names may take in the journal of a merge that was broken off, which is read anyway.
    let is_own = |path: &Path| match (path.canonicalize(), own.canonicalize()) {
        (Ok(path), Ok(own)) => path == own,
        _ => false,
    };
    let mut parts = Vec::new();
    let mut seen: Vec<PathBuf> = Vec::new();
    for path in journals.iter().filter(|path| !is_own(path)) {
        // A journal that is open cannot be opened again.
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        if seen.contains(&place) {
            return Err(Refusal::input(format!(
                "`{}` is given twice",
                path.display()
            )));
        }
        seen.push(place);
        let missing = || Refusal::input(format!("there is no file `{}`", path.display()));
        parts.push(open(path)?.ok_or_else(missing)?);
    }
    match parts.is_empty() {
        true => Err(Refusal::input("there is no journal to be merged")),
        false => Ok(parts),
    }
}

/// Whether the first of these journals that can be read is one of branches.
pub fn is_of_branches(journals: &[PathBuf]) -> bool {
    let first = journals.iter().find_map(|path| Unread::open(path).ok()?);
    let header =
        first.and_then(|unread| serde_json::from_slice::<serde_json::Value>(unread.header()).ok());
    header.is_some_and(|header| header.get("branches").is_some())
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
