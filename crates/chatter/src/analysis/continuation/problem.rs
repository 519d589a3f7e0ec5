//! What a curve is a solution of.

use crate::numerics::Real;
use core::fmt;

pub use crate::numerics::Linearised;

/// A system of equations with more unknowns than equations, the free parameters last among the unknowns.
pub trait Problem<R: Real> {
    /// Number of unknowns, free parameters included.
    fn unknowns(&self) -> usize;

    /// Number of free parameters.
    fn parameters(&self) -> usize;

    /// The size of each unknown: what a change is small or large against.
    fn scales(&self) -> &[f64];

    /// Residual and Jacobian at a point: one equation for each unknown that is no parameter.
    ///
    /// # Errors
    /// The equations have no meaning there.
    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left>;

    /// A function of the unknowns and its gradient, by number: what a curve in more parameters may hold at zero.
    ///
    /// # Errors
    /// It has no value there, or there is no such function.
    fn monitor(&mut self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let _ = at;
        Err(Left::because(format_args!("there is no function {index}")))
    }

    /// Which entries of the Jacobian close the cycle, where the equations are those of one.
    fn wrap(&self) -> Wrap {
        Wrap::default()
    }
}

/// The identity by which a cycle's last image is compared with its first point: for each such equation its row and column. With
/// the other sign the equations are those of a solution that turns over from one cycle to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wrap {
    /// Row and column of each entry.
    pub entries: Vec<(usize, usize, f64)>,
}

/// Why equations have no meaning at a point: what was left, and where, in words of the problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Left {
    /// The margin that was crossed, or what failed.
    pub what: String,
}

impl Left {
    /// Because of this.
    pub fn because(what: impl fmt::Display) -> Self {
        Self {
            what: what.to_string(),
        }
    }
}

impl fmt::Display for Left {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.what)
    }
}

impl core::error::Error for Left {}
