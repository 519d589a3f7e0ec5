//! Where the verdict over a parameter changes, and which of these places are borders.

pub(in crate::analysis::border) mod breaks;
pub(in crate::analysis::border) mod changes;
pub(in crate::analysis::border) mod closing_in;
mod near;
mod range;
pub(in crate::analysis::border) mod samples;

pub use near::{border_near, search_near, verdicts_in};
pub use range::{Borders, SearchProgress, borders_in, search_range};
