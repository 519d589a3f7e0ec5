//! Files that appear whole or not at all: written beside the target under a temporary name, then renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{FileAction, FileError};

/// Tells apart the temporary files of one process.
static SERIAL: AtomicU64 = AtomicU64::new(0);

/// A file under construction. Nothing is visible under the target's name before [`AtomicFile::commit`]; dropping it
/// without that removes the temporary file and leaves an older target as it was.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    temporary: PathBuf,
    file: Option<BufWriter<File>>,
}

impl AtomicFile {
    /// Starts a file that will be put at `target`, whose folder must exist.
    pub fn create(target: impl AsRef<Path>) -> Result<Self, FileError> {
        let target = target.as_ref();
        let fail = |source| FileError::new(target, FileAction::Create, source);
        let name = target.file_name().ok_or_else(|| {
            fail(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the path names no file",
            ))
        })?;
        if target.is_dir() {
            return Err(fail(io::Error::new(
                io::ErrorKind::IsADirectory,
                "it is a folder",
            )));
        }
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let mut temporary_name = std::ffi::OsString::from(".");
        temporary_name.push(name);
        temporary_name.push(format!(".{}-{serial}.tmp", std::process::id()));
        let temporary = folder_of(target).join(temporary_name);
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&temporary)
            .map_err(fail)?;
        Ok(AtomicFile {
            target: target.to_path_buf(),
            temporary,
            file: Some(BufWriter::with_capacity(1 << 16, file)),
        })
    }

    /// The path the file will have.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Finishes the file and puts it in its place. The data reach the disk before the name does.
    pub fn commit(mut self) -> Result<(), FileError> {
        let writer = self.file.take().expect("present until commit or drop");
        let written = writer
            .into_inner()
            .map_err(|e| e.into_error())
            .and_then(|file| file.sync_all());
        let outcome = match written {
            Err(e) => Err(FileError::new(&self.target, FileAction::Write, e)),
            Ok(()) => fs::rename(&self.temporary, &self.target)
                .map_err(|e| FileError::new(&self.target, FileAction::Rename, e)),
        };
        if outcome.is_err() {
            let _ = fs::remove_file(&self.temporary);
        }
        outcome
    }

    /// Turns an error of writing into one that names the target.
    pub fn write_error(&self, source: io::Error) -> FileError {
        FileError::new(&self.target, FileAction::Write, source)
    }

    fn inner(&mut self) -> &mut BufWriter<File> {
        self.file.as_mut().expect("present until commit or drop")
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(writer) = self.file.take() {
            // The buffered rest is of no use to anyone: discard it rather than flush it.
            drop(writer.into_parts());
            let _ = fs::remove_file(&self.temporary);
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

/// The folder that holds `path`; the current one for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    #[test]
    fn an_abandoned_file_leaves_the_old_one_and_no_litter() {
        let folder = Scratch::new();
        let path = folder.path("a.txt");
        write_atomically(&path, b"old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.root()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_atomically("no/such/folder/a.csv", b"").unwrap_err();
        assert_eq!(
            error.to_string(),
            "cannot write `no/such/folder/a.csv`: the folder `no/such/folder` does not exist"
        );
    }

    #[test]
    fn a_folder_is_no_target() {
        let folder = Scratch::new();
        let error = write_atomically(folder.root(), b"").unwrap_err();
        assert_eq!(error.action, FileAction::Create);
        assert!(error.to_string().ends_with("it is a folder"), "{error}");
    }
}
