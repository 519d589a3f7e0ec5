//! Border orbits: complete chatter that ends exactly at release, and the one-dimensional map around them (MATH.md 4).
//!
//! ```text
//! spec         the question
//! release      the point h = v = a = 0, j > 0
//! releases     all of them at a parameter value
//! branches     all of them over the parameter
//! forcing      states known up to whole periods: time, angles
//! sequence     the impacts that follow it, and the verdict complete / incomplete
//! coordinate   X and N: limits along the sequence, with derivatives
//! samples      the verdict at many parameter values
//! closing_in   from a change of the verdict to the root between
//! search       all of them, or the nearest first
//! range        all borders of a range, stretch by stretch
//! breaks       what ends complete chatter where no border is
//! root         the smooth equation X(p) = 0
//! exact        (M5): K, M and what they are made of
//! leading_order   the paper's A to F
//! rounded      the same in another number type
//! prediction   the one-dimensional map: impacts per passage, states after the first impact
//! windows      fold, period doubling and graze of the n-impact orbit, predicted
//! simulated    passages of the flow itself
//! return_map   its return map and the fixed points
//! window_curve the windows of these
//! located      predicted windows and those beside each other
//! ```

mod branches;
mod breaks;
mod closing_in;
mod coordinate;
mod error;
mod exact;
mod extrapolate;
mod forcing;
mod leading_order;
mod local;
mod located;
mod orbit;
mod prediction;
mod problem;
mod range;
mod release;
mod releases;
mod return_map;
mod root;
mod rounded;
mod samples;
mod search;
mod section;
mod sequence;
mod simulated;
mod spec;
mod window_curve;
mod windows;

pub use coordinate::Extrapolation;
pub use error::{BorderError, Break, BreakCause};
pub use exact::Exact;
pub use extrapolate::Estimate;
pub use forcing::Turn;
pub use leading_order::{LeadingOrder, ReleaseSection};
pub use local::LocalCoordinate;
pub use located::{Discrepancy, WindowComparison};
pub use orbit::{Border, FirstImpact, border_near, leading_order_at, search_near, verdicts_in};
pub use prediction::{AffineStates, ImpactCounts, PredictedPassage, Prediction, Settled};
pub use range::{Borders, SearchProgress, borders_in, search_range};
pub use release::ReleasePoint;
pub use section::section_states;
pub use sequence::Verdict;
pub use simulated::{Passage, Simulated, Simulator};
pub use spec::BorderSpec;
pub use window_curve::LocatedWindow;
pub use windows::{PredictedPoint, PredictedWindow};
