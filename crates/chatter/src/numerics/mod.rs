//! Numbers, truncated series and polynomials. Knows nothing of models.

mod bracket;
pub(crate) mod complementarity;
mod eigenvalues;
mod extrapolation;
mod factored;
pub mod linear;
mod matrix;
mod newton;
mod numbers;
pub mod polynomial;
pub mod roots;

pub(crate) use bracket::last_where;
pub use bracket::{Bracket, root_between};
pub use eigenvalues::{Complex, balance, eigenvalues};
pub use extrapolation::{Estimate, Plan, limit, ratios};
pub use factored::Factored;
pub use matrix::{Matrix, dot, moved, pairs, unit};
pub use newton::{Equations, Linearised, Newton, NewtonError, Solution};
pub use numbers::dispatch;
pub(crate) use numbers::double_double::two_sum;
pub use numbers::double_double::{DoubleDouble, NotANumber};
pub use numbers::lanes::{LaneMask, LaneSet, Lanes};
pub(crate) use numbers::lanes::{Wide, WideMask};
#[cfg(target_arch = "x86_64")]
pub(crate) use numbers::registers::Registers;
pub(crate) use numbers::rounded::{Rounded, unchanged, with_rounding};
pub(crate) use numbers::scalar::index_of;
pub use numbers::scalar::{Mask, Real, Scalar};
pub(crate) use numbers::stored;
pub(crate) use numbers::with_terms::WithTerms;
