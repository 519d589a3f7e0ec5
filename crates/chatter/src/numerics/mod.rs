//! Numbers, truncated series and polynomials. Knows nothing of models.

pub(crate) mod complementarity;
pub mod dispatch;
mod double_double;
mod eigenvalues;
mod lanes;
pub mod linear;
mod matrix;
pub mod polynomial;
pub mod roots;
mod scalar;
mod stored;
mod with_terms;

pub(crate) use double_double::two_sum;
pub use double_double::{DoubleDouble, NotANumber};
pub use eigenvalues::{Complex, eigenvalues};
pub use lanes::{LaneMask, Lanes};
pub use matrix::{Factored, Matrix, dot, pairs};
pub use scalar::{Mask, Real, Scalar};
pub(crate) use with_terms::WithTerms;
