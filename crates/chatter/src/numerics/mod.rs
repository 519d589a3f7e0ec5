//! Numbers, truncated series and polynomials. Knows nothing of models.

pub mod dispatch;
mod double_double;
mod lanes;
pub mod linear;
pub mod polynomial;
pub mod roots;
mod scalar;
mod stored;

pub(crate) use double_double::two_sum;
pub use double_double::{DoubleDouble, NotANumber};
pub use lanes::{LaneMask, Lanes};
pub use scalar::{Mask, Real, Scalar};
