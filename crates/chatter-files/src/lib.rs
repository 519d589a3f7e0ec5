//! Tables as plain values and their writers, journals of long computations, files that appear whole or not at all. Knows
//! nothing of analyses.
//!
//! # Tables
//!
//! A [`tables::Dataset`] holds tables of named columns and text about them, and is written as CSV or NPZ, whichever the
//! extension says. [`tables::NpzWriter`] writes arrays of any length in flat memory, [`tables::NpzReader`] reads them.
//!
//! ```
//! use chatter_files::tables::{Dataset, NpzReader, Table};
//! # let folder = std::env::temp_dir().join(format!("chatter-files-doc-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//!
//! let data = Dataset::new()
//!     .table(
//!         Table::new("columns")
//!             .column("q", vec![0.0203, 0.0204])
//!             .column("period", vec![1i64, 2])
//!             .column("outcome", vec!["periodic", "periodic"]),
//!     )
//!     .table(Table::new("samples").column("y2", vec![0.1, 0.2, 0.3]))
//!     .text("model", "title = \"Pressure relief valve\"");
//! data.write(folder.join("fig5.npz"))?;
//!
//! let file = NpzReader::open(folder.join("fig5.npz"))?;
//! assert_eq!(file.floats("y2")?, [0.1, 0.2, 0.3]);
//! assert_eq!(file.text("model")?, "title = \"Pressure relief valve\"");
//! # std::fs::remove_dir_all(folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Files
//!
//! A long computation keeps its results in a [`journal`], which survives being killed.
//!
//! Every other file is written beside its place under a temporary name and then renamed ([`atomic_file`]): it appears whole or
//! not at all. Errors ([`Error`]) name the path and the reason.

pub mod atomic_file;
mod error;
mod format;
pub mod journal;
pub mod record_log;
pub mod tables;

#[cfg(test)]
mod scratch;

pub use error::{Error, FileAction, FileError};
pub use format::{Content, Format, FormatError};
