//! Files that appear whole or not at all: written beside the target under a temporary name, then renamed.
//!
//! A temporary name is drawn at random and its file created exclusively, so that nobody can have put a link there. The
//! target keeps its permissions; where it is a symbolic link, the file that it leads to is replaced, not the link.
//!
//! Whoever writes a temporary file holds a lock on it. One that nobody holds was left behind by a process that was
//! killed: it is removed when its target is written next.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File, Permissions, TryLockError};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use crate::error::{FileAction, FileError};

/// End of temporary names.
const SUFFIX: &str = ".tmp";

/// Letters and digits drawn for a temporary name.
const DRAWN: usize = 6;

/// Symbolic links that lead on to each other; the limit of Linux.
const MOST_LINKS: usize = 40;

/// Times that a temporary file may be taken for one left behind before it is locked.
const MOST_ATTEMPTS: usize = 16;

/// Temporary files that this process has open.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes every file that this process has not finished: for a process that is about to end in the middle of writing.
pub fn discard_unfinished() {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in core::mem::take(&mut *unfinished) {
        let _ = fs::remove_file(path);
    }
}

fn unfinished(change: impl FnOnce(&mut BTreeSet<PathBuf>)) {
    change(&mut UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner));
}

/// A file under construction. Nothing is visible under the target's name before [`AtomicFile::commit`]; dropping it
/// without that removes the temporary file and leaves an older target as it was.
#[derive(Debug)]
pub struct AtomicFile {
    /// As the caller named it.
    target: PathBuf,
    /// Where the links end.
    place: PathBuf,
    permissions: Option<Permissions>,
    /// Present until commit or drop: the open file, and its temporary name, which is removed with it.
    open: Option<(BufWriter<File>, TempPath)>,
}

impl AtomicFile {
    /// Starts a file that will be put at `target`, whose folder must exist.
    pub fn create(target: impl AsRef<Path>) -> Result<Self, FileError> {
        let target = target.as_ref();
        let fail = |source| FileError::new(target, FileAction::Create, source);
        let place = place_of(target).map_err(fail)?;
        let permissions = fs::metadata(&place).ok().map(|found| found.permissions());
        let (file, temporary) = temporary_for(&place).map_err(fail)?.into_parts();
        unfinished(|paths| _ = paths.insert(temporary.to_path_buf()));
        Ok(AtomicFile {
            target: target.to_path_buf(),
            place,
            permissions,
            open: Some((BufWriter::with_capacity(1 << 16, file), temporary)),
        })
    }

    /// The path the file will have.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Finishes the file and puts it in its place. The data reach the disk before the name does.
    pub fn commit(mut self) -> Result<(), FileError> {
        let (writer, temporary) = self.open.take().expect("present until commit or drop");
        let fail = |action| {
            let target = self.target.clone();
            move |error| FileError::new(target, action, error)
        };
        let file = writer
            .into_inner()
            .map_err(|error| fail(FileAction::Write)(error.into_error()))?;
        if let Some(permissions) = self.permissions.take() {
            file.set_permissions(permissions)
                .map_err(fail(FileAction::Write))?;
        }
        file.sync_all().map_err(fail(FileAction::Write))?;
        unfinished(|paths| _ = paths.remove(&temporary.to_path_buf()));
        // The file stays open, and thereby locked, until it has its name.
        temporary
            .persist(&self.place)
            .map_err(|error| fail(FileAction::Rename)(error.error))?;
        sync_folder(&self.place).map_err(fail(FileAction::Rename))
    }

    /// Turns an error of writing into one that names the target.
    pub fn write_error(&self, source: io::Error) -> FileError {
        FileError::new(&self.target, FileAction::Write, source)
    }

    fn inner(&mut self) -> &mut BufWriter<File> {
        let (writer, _) = self.open.as_mut().expect("present until commit or drop");
        writer
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some((writer, temporary)) = self.open.take() {
            unfinished(|paths| _ = paths.remove(&temporary.to_path_buf()));
            // The buffered rest is of no use to anyone: discard it rather than flush it.
            drop(writer.into_parts());
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.inner().write(bytes)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner().write_all(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner().flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.inner().seek(position)
    }
}

impl Read for AtomicFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let writer = self.inner();
        writer.flush()?;
        writer.get_mut().read(buffer)
    }
}

/// Writes `bytes` as the whole content of `target`.
pub fn write_atomically(target: impl AsRef<Path>, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = AtomicFile::create(target)?;
    file.write_all(bytes).map_err(|e| file.write_error(e))?;
    file.commit()
}

/// Whether a file can be put at `target` as a whole: so far as this can be told without writing anything.
///
/// # Errors
/// Its folder is missing, or it is a folder, a pipe or a device.
pub fn check_target(target: impl AsRef<Path>) -> Result<(), FileError> {
    let target = target.as_ref();
    let fail = |source| FileError::new(target, FileAction::Create, source);
    let place = place_of(target).map_err(fail)?;
    match folder_of(&place).is_dir() {
        true => Ok(()),
        false => Err(fail(io::ErrorKind::NotFound.into())),
    }
}

/// Bytes that may still be written in the folder of `target`, where the system says.
pub fn free_space(target: impl AsRef<Path>) -> Option<u64> {
    #[cfg(unix)]
    {
        let found = rustix::fs::statvfs(folder_of(target.as_ref())).ok()?;
        Some(found.f_bavail.saturating_mul(found.f_frsize))
    }
    #[cfg(not(unix))]
    {
        let _ = target;
        None
    }
}

/// The file that `target` leads to, over symbolic links; it need not be there yet.
fn place_of(target: &Path) -> io::Result<PathBuf> {
    let refused = |why: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    if let Ok(found) = fs::metadata(target) {
        if found.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "it is a folder",
            ));
        }
        if !found.is_file() {
            return refused("it is a pipe or a device, and a file is put in its place as a whole");
        }
    }
    let mut place = target.to_path_buf();
    for _ in 0..MOST_LINKS {
        if place.file_name().is_none() {
            return refused("the path names no file");
        }
        match fs::read_link(&place) {
            Ok(to) => place = folder_of(&place).join(to),
            Err(_) => return Ok(place),
        }
    }
    refused("its symbolic links lead round in a circle")
}

/// A new temporary file beside `place`, locked. Those that killed processes have left there are removed.
pub(crate) fn temporary_for(place: &Path) -> io::Result<NamedTempFile> {
    remove_litter(place);
    let mut builder = tempfile::Builder::new();
    let prefix = prefix_for(place);
    builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(DRAWN);
    // As any new file: what the user's mask leaves of it.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    for _ in 0..MOST_ATTEMPTS {
        let file = builder.tempfile_in(folder_of(place)).map_err(bare)?;
        let taken = matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock));
        // Another process may have come before the lock.
        if !taken && file.path().exists() {
            return Ok(file);
        }
    }
    Err(io::Error::other(
        "its temporary file is removed again and again",
    ))
}

/// How the names of temporary files of `place` begin.
fn prefix_for(place: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(place.file_name().unwrap_or_default());
    prefix.push(".");
    prefix
}

/// Removes temporary files of `place` that no process is writing.
fn remove_litter(place: &Path) {
    let prefix = prefix_for(place);
    let Ok(entries) = fs::read_dir(folder_of(place)) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let drawn = (name.as_encoded_bytes())
            .strip_prefix(prefix.as_encoded_bytes())
            .and_then(|rest| rest.strip_suffix(SUFFIX.as_bytes()));
        let ours = drawn.is_some_and(|drawn| {
            drawn.len() == DRAWN && drawn.iter().all(u8::is_ascii_alphanumeric)
        });
        if ours
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The system's number for an error of the disk itself.
const DISK_ERROR: i32 = 5;

/// Makes what was renamed within the folder of `place` outlast a power cut.
pub(crate) fn sync_folder(place: &Path) -> io::Result<()> {
    // Where folders cannot be opened or synchronised, the system has its own ways.
    let Ok(folder) = File::open(folder_of(place)) else {
        return Ok(());
    };
    match folder.sync_all() {
        Err(error) if error.raw_os_error() == Some(DISK_ERROR) => Err(error),
        _ => Ok(()),
    }
}

/// The system's reason, without the temporary name that means nothing to the user.
fn bare(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|inner| inner.source());
    match inner.map(ToString::to_string) {
        Some(reason) => io::Error::new(error.kind(), reason),
        None => error,
    }
}

/// The folder that holds `path`; the current one for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    fn names(folder: &Scratch) -> Vec<String> {
        let entries = fs::read_dir(folder.root()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn an_abandoned_file_leaves_the_old_one_and_no_litter() {
        let folder = Scratch::new();
        let path = folder.path("a.txt");
        write_atomically(&path, b"old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(&folder), ["a.txt"]);
    }

    #[test]
    fn what_a_killed_process_left_is_removed_and_what_is_being_written_is_not() {
        let folder = Scratch::new();
        let path = folder.path("a.txt");
        // Nobody holds a lock on these.
        fs::write(folder.path(".a.txt.x7Yz01.tmp"), "left behind").unwrap();
        let others = [
            ".a.txt.backups.tmp",
            ".a.txt.x7Yz0é.tmp",
            ".b.txt.x7Yz01.tmp",
        ];
        for other in others {
            fs::write(folder.path(other), "another's").unwrap();
        }
        let mut first = AtomicFile::create(&path).unwrap();
        let second = AtomicFile::create(&path).unwrap();
        first.write_all(b"whole").unwrap();
        drop(second);
        first.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        let mut expected: Vec<&str> = others.to_vec();
        expected.push("a.txt");
        expected.sort_unstable();
        assert_eq!(names(&folder), expected);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_kept_and_new_files_have_the_usual_ones() {
        use std::os::unix::fs::PermissionsExt;
        let folder = Scratch::new();
        let mode = |name: &str| fs::metadata(folder.path(name)).unwrap().mode() & 0o7777;
        use std::os::unix::fs::MetadataExt;
        for kept in [0o600, 0o640, 0o666, 0o755] {
            let path = folder.path("kept");
            fs::write(&path, "").unwrap();
            fs::set_permissions(&path, Permissions::from_mode(kept)).unwrap();
            write_atomically(&path, b"new").unwrap();
            assert_eq!(mode("kept"), kept);
        }
        fs::write(folder.path("usual"), "").unwrap();
        write_atomically(folder.path("new"), b"").unwrap();
        assert_eq!(mode("new"), mode("usual"));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_written_through_and_pipes_refused() {
        use std::os::unix::fs::symlink;
        let folder = Scratch::new();
        fs::create_dir(folder.path("sub")).unwrap();
        // One link to another, to a file that is not there yet; then to one that is.
        symlink("sub/far", folder.path("near")).unwrap();
        symlink("real", folder.path("sub/far")).unwrap();
        for content in [&b"first"[..], b"second"] {
            write_atomically(folder.path("near"), content).unwrap();
            assert_eq!(fs::read(folder.path("sub/real")).unwrap(), content);
        }
        assert!(folder.path("near").is_symlink() && folder.path("sub/far").is_symlink());
        symlink("round", folder.path("round")).unwrap();
        let error = write_atomically(folder.path("round"), b"").unwrap_err();
        assert!(error.to_string().contains("in a circle"), "{error}");
        let pipe = folder.path("pipe.csv");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        for error in [
            write_atomically(&pipe, b"").unwrap_err(),
            check_target(&pipe).unwrap_err(),
        ] {
            assert!(error.to_string().contains("it is a pipe"), "{error}");
        }
        assert!(!fs::metadata(&pipe).unwrap().is_file());
    }

    #[test]
    fn a_missing_folder_is_named() {
        for error in [
            write_atomically("no/such/folder/a.csv", b"").unwrap_err(),
            check_target("no/such/folder/a.csv").unwrap_err(),
        ] {
            assert_eq!(
                error.to_string(),
                "cannot write `no/such/folder/a.csv`: the folder `no/such/folder` does not exist"
            );
        }
    }

    #[test]
    fn a_folder_is_no_target() {
        let folder = Scratch::new();
        let error = write_atomically(folder.root(), b"").unwrap_err();
        assert_eq!(error.action, FileAction::Create);
        assert!(error.to_string().ends_with("it is a folder"), "{error}");
    }
}
