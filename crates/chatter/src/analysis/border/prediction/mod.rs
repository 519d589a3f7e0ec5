//! What the one-dimensional map says about the system, beside the system itself.

mod located;
mod map;
mod simulated;
mod windows;

pub use located::{Discrepancy, LocatedWindow, WindowComparison, WindowEnds};
pub use map::{AffineStates, PredictedPassage, Prediction};
pub use simulated::{Passage, Simulated, Simulator};
pub use windows::{PredictedPoint, PredictedWindow};
