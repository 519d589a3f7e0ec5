//! What the one-dimensional map says about the system, beside the system itself.

mod located;
mod map;
mod return_map;
mod simulated;
mod window_curve;
mod windows;

pub use located::{Discrepancy, WindowComparison};
pub use map::{AffineStates, PredictedPassage, Prediction};
pub use simulated::{Passage, Simulated, Simulator};
pub use window_curve::{LocatedWindow, WindowEnds};
pub use windows::{PredictedPoint, PredictedWindow};
