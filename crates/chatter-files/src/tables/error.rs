//! What can be wrong with a table or a table file.

use std::fmt;
use std::path::PathBuf;

use super::npy::Kind;

/// A table is not what it must be, or a table file is not what it claims to be.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// The columns of one table differ in length.
    UnequalLengths {
        /// The table's name.
        table: String,
        /// First column and its length.
        first: (String, usize),
        /// The column that differs and its length.
        other: (String, usize),
    },
    /// Two arrays of one file have the same name.
    DuplicateName {
        /// The name given twice.
        name: String,
    },
    /// A name is empty or holds a character that a file name cannot hold.
    BadName {
        /// The name.
        name: String,
    },
    /// An array was begun and not finished.
    Unfinished {
        /// The array's name.
        name: String,
    },
    /// An array was given more or fewer values than its header says.
    OtherCount {
        /// The array's name.
        name: String,
        /// How many were told of.
        expected: u64,
        /// How many came.
        count: u64,
    },
    /// The file has no such array.
    NoSuchArray {
        /// The file.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// An array holds another kind of value than was asked for.
    WrongKind {
        /// The file.
        path: PathBuf,
        /// The array.
        name: String,
        /// What it holds.
        found: Kind,
        /// What was asked for.
        expected: Kind,
    },
    /// The file is not a readable NPZ file.
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::UnequalLengths {
                table,
                first,
                other,
            } => write!(
                f,
                "table `{table}`: column `{}` has {} values, but column `{}` has {}",
                other.0, other.1, first.0, first.1
            ),
            TableError::DuplicateName { name } => {
                write!(f, "two arrays of one file are named `{name}`")
            }
            TableError::BadName { name } => {
                write!(
                    f,
                    "`{name}` cannot name an array: empty, or with a `/`, `\\` or control character"
                )
            }
            TableError::Unfinished { name } => {
                write!(f, "array `{name}` was begun and not finished")
            }
            TableError::OtherCount {
                name,
                expected,
                count,
            } => write!(
                f,
                "array `{name}` was given {count} values, where {expected} were told of"
            ),
            TableError::NoSuchArray { path, name, known } => write!(
                f,
                "`{}` has no array `{name}`; it has {}",
                path.display(),
                if known.is_empty() {
                    "none".to_string()
                } else {
                    known.join(", ")
                }
            ),
            TableError::WrongKind {
                path,
                name,
                found,
                expected,
            } => write!(
                f,
                "`{}`: array `{name}` holds {found}, where {expected} was expected",
                path.display()
            ),
            TableError::Malformed { path, what } => {
                write!(f, "`{}` is not a readable NPZ file: {what}", path.display())
            }
        }
    }
}

impl std::error::Error for TableError {}
