//! Border orbits: complete chatter that ends exactly at release, and the one-dimensional map around them (docs/border.md).
//!
//! ```text
//! spec           the question
//! problem        a model and its parameter, compiled for it; and at a value of that, which most questions are asked at
//! release/       where contact ends
//!   equations    the point h = v = a = 0, j > 0
//!   all          all of them at a parameter value
//!   orbits       with more than three states: those that an orbit returns to
//!   forcing      states known up to whole periods: time, angles
//! coordinate/    X, whose root is the border
//!   local        u and nu after an impact, with derivatives from impact to impact
//!   sequence     the impacts that follow release, and the verdict complete / incomplete
//!   limits       X and N: limits along the sequence, with derivatives
//!   root         the smooth equation X(p) = 0
//! search/        borders of a parameter
//!   sample       the verdict at a parameter value
//!   branches     that of each release point over the parameter
//!   closing_in   from a change of the verdict to the root between
//!   borders      stretch by stretch: all of a range, or outwards to the nearest to a value
//!   breaks       what ends complete chatter where no border is
//! orbit          a border orbit with its normal form
//! normal_form/   K, M and what they are made of
//!   exact        (M5)
//!   leading_order   the paper's A to F
//!   section      states on a section of the model, and where one is crossed
//! prediction/
//!   map          the one-dimensional map: impacts per passage, states after the first impact
//!   windows      fold, period doubling and graze of the n-impact orbit, predicted
//!   simulated    passages of the flow itself
//!   located      predicted windows beside those of its periodic orbits
//! ```

mod coordinate;
mod error;
mod normal_form;
mod orbit;
mod prediction;
mod problem;
mod release;
mod search;
mod spec;

pub use crate::numerics::Estimate;
pub use coordinate::limits::Extrapolation;
pub use coordinate::local::LocalCoordinate;
pub use coordinate::sequence::Verdict;
pub use error::{BorderError, Break, BreakCause, Lack, Named};
pub use normal_form::exact::{Exact, Memory};
pub use normal_form::leading_order::{LeadingOrder, ReleaseSection, leading_order_at};
pub use normal_form::section::section_states;
pub use orbit::{Border, FirstImpact};
pub use prediction::located::{Discrepancy, LocatedWindow, WindowComparison, WindowEnds};
pub use prediction::map::{AffineStates, PredictedPassage, Prediction};
pub use prediction::simulated::{Passage, Simulated, Simulator};
pub use prediction::windows::{PredictedPoint, PredictedWindow};
pub use release::equations::ReleasePoint;
pub use release::forcing::Turn;
pub use search::borders::{Borders, SearchObserver, SearchProgress};
pub use search::borders::{border_near, borders_in, search_near, search_range, verdicts_in};
pub use spec::BorderSpec;
