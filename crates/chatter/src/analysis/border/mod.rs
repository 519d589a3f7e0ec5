//! Border orbits: complete chatter that ends exactly at release, and the one-dimensional map around them (docs/border.md).
//! [`border_search`](super::border_search) finds them.
//!
//! ```text
//! spec           the question
//! problem        a model and its parameter, compiled for it; and at a value of that, which most questions are asked at
//! release/       where contact ends
//!   equations    the point h = v = a = 0, j > 0
//!   forcing      states known up to whole periods: time, angles
//! coordinate/    X, whose root is the border
//!   local        u and nu after an impact, with derivatives from impact to impact
//!   sequence     the impacts that follow release, and the verdict complete / incomplete
//!   limits       X and N: limits along the sequence, with derivatives
//!   root         the smooth equation X(p) = 0
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
mod spec;

pub use crate::numerics::Estimate;
pub use coordinate::limits::Extrapolation;
pub use coordinate::local::LocalCoordinate;
pub use coordinate::sequence::Verdict;
pub(crate) use error::ParameterValue;
pub use error::{BorderError, Break, BreakCause, Lack, Named};
pub use normal_form::exact::{Exact, Memory};
pub use normal_form::leading_order::{LeadingOrder, ReleaseSection};
pub use normal_form::section::section_states;
pub use orbit::{Border, FirstImpact};
pub use prediction::located::{Discrepancy, LocatedWindow, WindowComparison, WindowEnds};
pub use prediction::map::{AffineStates, PredictedPassage, Prediction};
pub use prediction::simulated::{Passage, Simulated, Simulator};
pub use prediction::windows::{PredictedPoint, PredictedWindow};
pub use release::equations::ReleasePoint;
pub use release::forcing::Turn;
pub use spec::BorderSpec;

pub(super) use coordinate::root::{Root, regular};
pub(super) use coordinate::sequence::{
    GRAZE, Impact, NO_HORIZON, SHORTEST, Sequence, Until, until_release,
};
pub(super) use normal_form::leading_order::leading_order;
pub(super) use orbit::complete;
pub(super) use problem::{Here, Problem};
pub(super) use release::equations::Place;
