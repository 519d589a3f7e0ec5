//! What can be wrong with a report.

use crate::{FigureError, LabelError};
use std::fmt;

/// Which part of a report is wrong: its place among the blocks, counted from 0, or none for title, summary and colophon.
pub type ReportPart = Option<usize>;

/// Why a report cannot be written.
#[derive(Debug, Clone, PartialEq)]
pub enum ReportError {
    /// Text with wrong markup.
    Text {
        /// Where.
        part: ReportPart,
        /// What is wrong.
        error: LabelError,
    },
    /// A figure that cannot be drawn.
    Figure {
        /// Where.
        part: ReportPart,
        /// What is wrong.
        error: FigureError,
    },
    /// A row with more or fewer cells than its table has columns.
    Cells {
        /// Where.
        part: ReportPart,
        /// Which row, counted from 0.
        row: usize,
        /// How many cells it has.
        cells: usize,
        /// How many columns there are.
        columns: usize,
    },
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = match self {
            Self::Text { part, .. } | Self::Figure { part, .. } | Self::Cells { part, .. } => part,
        };
        match part {
            Some(block) => write!(f, "report, block {block}: ")?,
            None => write!(f, "report: ")?,
        }
        match self {
            Self::Text { error, .. } => error.fmt(f),
            Self::Figure { error, .. } => error.fmt(f),
            Self::Cells {
                row,
                cells,
                columns,
                ..
            } => write!(
                f,
                "row {row} of the table has {cells} cells for {columns} columns"
            ),
        }
    }
}

impl std::error::Error for ReportError {}
