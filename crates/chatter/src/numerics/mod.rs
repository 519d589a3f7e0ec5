//! Numbers, truncated series and polynomials. Knows nothing of models.

mod bracket;
pub(crate) mod complementarity;
pub mod dispatch;
mod double_double;
mod eigenvalues;
mod extrapolation;
mod lanes;
pub mod linear;
mod matrix;
mod newton;
pub mod polynomial;
#[cfg(target_arch = "x86_64")]
mod registers;
pub mod roots;
mod rounded;
mod scalar;
pub(crate) mod stored;
mod with_terms;

pub(crate) use bracket::last_where;
pub use bracket::{Bracket, root_between};
pub(crate) use double_double::two_sum;
pub use double_double::{DoubleDouble, NotANumber};
pub use eigenvalues::{Complex, balance, eigenvalues};
pub use extrapolation::{Estimate, Plan, limit, ratios};
pub use lanes::{LaneMask, LaneSet, Lanes};
pub(crate) use lanes::{Wide, WideMask};
pub use matrix::{Factored, Matrix, dot, moved, pairs, unit};
pub use newton::{Equations, Linearised, Newton, NewtonError, Solution};
#[cfg(target_arch = "x86_64")]
pub(crate) use registers::Registers;
pub(crate) use rounded::{Rounded, unchanged, with_rounding};
pub(crate) use scalar::index_of;
pub use scalar::{Mask, Real, Scalar};
pub(crate) use with_terms::WithTerms;
