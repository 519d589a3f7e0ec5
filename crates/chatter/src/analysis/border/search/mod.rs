//! Where the verdict over a parameter changes, and which of these places are borders.

mod borders;
pub(in crate::analysis::border) mod breaks;
mod closing_in;
pub(in crate::analysis::border) mod sample;

pub use borders::{
    Borders, SearchObserver, SearchProgress, border_near, borders_in, search_near, search_range,
    verdicts_in,
};
