//! How the universal map is told: as text, as a JSON document, as a table, as a picture.

mod account;
mod document;
mod job;
pub mod picture;
mod windows;

pub use account::account;
pub use document::document;
pub use job::UniversalJob;
pub use windows::{Window, window_list, window_rows, window_table};

use crate::numbers::Digits;
use chatter::analysis::diagram::{Row, Sweep};
use chatter::analysis::universal::{Evaluation, Universal};

/// What was found.
pub struct Findings<'a, R> {
    /// The universal function.
    pub universal: &'a Universal<R>,
    /// The slope K of the map.
    pub slope: R,
    /// Upsilon where it was asked for.
    pub values: Option<Vec<(R, Evaluation<R>)>>,
    /// The windows asked for.
    pub windows: Option<Vec<Window<R>>>,
    /// The orbit diagram.
    pub diagram: Option<(&'a Sweep, &'a [Row])>,
    /// How many digits the user wants.
    pub digits: Digits,
}
