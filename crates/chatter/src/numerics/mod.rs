//! Numbers, truncated series and polynomials. Knows nothing of models.

mod double_double;
mod lanes;
pub mod polynomial;
pub mod roots;
mod scalar;

pub use double_double::DoubleDouble;
pub use lanes::{LaneMask, Lanes};
pub use scalar::{Mask, Real, Scalar};
