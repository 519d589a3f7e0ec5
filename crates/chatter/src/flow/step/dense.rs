//! Dense output: the latest step as polynomials.

use super::Workspace;
use crate::numerics::Real;
use crate::numerics::polynomial::horner;

impl<R: Real> Workspace<R> {
    /// Order of the latest expansion.
    pub fn order(&self) -> usize {
        self.expansion.order()
    }

    /// The latest step as polynomials: for each state its coefficients in powers of the scaled time, and the scaled and
    /// true length of the step.
    pub fn dense(&self) -> Dense<'_, R> {
        Dense { work: self }
    }
}

/// Dense output of the latest step: the expansion itself.
pub struct Dense<'w, R: Real> {
    work: &'w Workspace<R>,
}

impl<R: Real> Dense<'_, R> {
    /// Length of the step; zero if the latest call moved nowhere.
    pub fn step(&self) -> R {
        self.work.step
    }

    /// Value of a state after a part of the step, `fraction` in [0, 1], before any impact at its end.
    pub fn state(&self, index: usize, fraction: R) -> R {
        let s = self.work.scaled_step * fraction;
        horner(self.work.expansion.series(index), s)
    }
}
