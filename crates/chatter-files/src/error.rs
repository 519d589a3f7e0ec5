//! What can go wrong, typed: with files, formats and tables.

use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::format::FormatError;
use crate::tables::TableError;

/// Any error of this crate.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    File(FileError),
    /// The extension of a file names no format that can be written there.
    Format(FormatError),
    /// A table is not what it must be, or a table file is not what it claims to be.
    Table(TableError),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::File(e) => e.fmt(f),
            Error::Format(e) => e.fmt(f),
            Error::Table(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::File(e) => e.source(),
            Error::Format(_) | Error::Table(_) => None,
        }
    }
}

impl From<FileError> for Error {
    fn from(e: FileError) -> Self {
        Error::File(e)
    }
}

impl From<FormatError> for Error {
    fn from(e: FormatError) -> Self {
        Error::Format(e)
    }
}

impl From<TableError> for Error {
    fn from(e: TableError) -> Self {
        Error::Table(e)
    }
}

/// What was being done with a file when it failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileAction {
    /// Opening an existing file.
    Open,
    /// Reading from an open file.
    Read,
    /// Creating the temporary file beside the target.
    Create,
    /// Writing to the temporary file.
    Write,
    /// Putting the finished temporary file in the target's place.
    Rename,
}

/// A file could not be read or written; names the path the user gave and the system's reason.
#[derive(Debug)]
pub struct FileError {
    /// The path as the caller gave it.
    pub path: PathBuf,
    /// What was being done.
    pub action: FileAction,
    /// The system's reason.
    pub source: io::Error,
}

impl FileError {
    /// An error on `path` during `action`.
    pub fn new(path: impl Into<PathBuf>, action: FileAction, source: io::Error) -> Self {
        FileError {
            path: path.into(),
            action,
            source,
        }
    }

    /// Whether the folder that should hold the file does not exist.
    fn folder_missing(&self) -> bool {
        self.action == FileAction::Create
            && self.source.kind() == io::ErrorKind::NotFound
            && !crate::atomic_file::folder_of(&self.path).is_dir()
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        if self.folder_missing() {
            let folder = crate::atomic_file::folder_of(&self.path);
            return write!(
                f,
                "cannot write `{path}`: the folder `{}` does not exist",
                folder.display()
            );
        }
        let verb = match self.action {
            FileAction::Open => "open",
            FileAction::Read => "read",
            FileAction::Create | FileAction::Write | FileAction::Rename => "write",
        };
        write!(f, "cannot {verb} `{path}`: {}", self.source)
    }
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}
