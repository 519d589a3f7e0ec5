//! What can go wrong, typed: with figures, reports and the files that they are written to.

use std::fmt;

use crate::figure_error::FigureError;
use crate::reports::ReportError;
use chatter_files::{FileError, FormatError};

/// Any error of this crate.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be written.
    File(FileError),
    /// The extension of a file names no format of figures.
    Format(FormatError),
    /// A figure cannot be drawn.
    Figure(FigureError),
    /// A report cannot be put together.
    Report(ReportError),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::File(e) => e.fmt(f),
            Error::Format(e) => e.fmt(f),
            Error::Figure(e) => e.fmt(f),
            Error::Report(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::File(e) => e.source(),
            Error::Format(_) | Error::Figure(_) | Error::Report(_) => None,
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

impl From<FigureError> for Error {
    fn from(e: FigureError) -> Self {
        Error::Figure(e)
    }
}

impl From<ReportError> for Error {
    fn from(e: ReportError) -> Self {
        Error::Report(e)
    }
}
