//! Borders of a parameter: where complete chatter begins or ends over it, and which of these places are borders (docs/border.md).
//!
//! Everything here is computed in `f64` and guessed from verdicts; what is told of a border comes from [`border`](super::border).
//!
//! ```text
//! release_points  all of them at a parameter value
//! returning       with more than three states: those that an orbit returns to
//! verdict         the impacts that follow one, up to complete or incomplete
//! sample          what is known at a parameter value
//! branches        that of each release point over the parameter
//! closing_in      from a change of the verdict to the root between
//! borders         stretch by stretch: all of a range, or outwards to the nearest to a value
//! breaks          what ends complete chatter where no border is
//! unfollowed      values at which the motion ends
//! at_value        the paper's coefficients at a value near a border
//! ```

mod at_value;
mod borders;
mod branches;
mod breaks;
mod closing_in;
mod release_points;
mod returning;
mod sample;
mod unfollowed;
mod verdict;

pub use at_value::leading_order_at;
pub use borders::{Borders, SearchObserver, SearchProgress};
pub use borders::{border_near, borders_in, search_near, search_range, verdicts_in};
pub use unfollowed::Unfollowed;
