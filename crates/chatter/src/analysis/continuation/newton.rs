//! Newton's method on a problem that is bordered by linear conditions.

use super::problem::{Left, Problem};
use crate::numerics::{Factored, Matrix, Real, dot};
use core::fmt;

/// A linear condition beside the equations: row . u = value. As many are needed as there are free parameters.
#[derive(Clone, Debug)]
pub struct Condition<R> {
    /// One number for each unknown.
    pub row: Vec<R>,
    /// What the product is to be.
    pub value: R,
}

impl<R: Real> Condition<R> {
    /// That one unknown has this value.
    pub fn fixed(unknowns: usize, index: usize, value: R) -> Self {
        let mut row = vec![R::ZERO; unknowns];
        row[index] = R::ONE;
        Self { row, value }
    }
}

/// A solution.
#[derive(Clone, Debug)]
pub struct Corrected<R> {
    /// The unknowns.
    pub at: Vec<R>,
    /// Largest residual against the sizes of the unknowns that it is compared with.
    pub residual: f64,
    /// The latest correction, against the sizes of the unknowns.
    pub correction: f64,
    /// How many corrections were made.
    pub steps: usize,
    /// The bordered Jacobian's factors at the end.
    pub factors: Factored<R>,
}

/// Why there is no solution nearby.
#[derive(Clone, Debug, PartialEq)]
pub enum NewtonError {
    /// The equations have no meaning where it led.
    Left(Left),
    /// The bordered equations are singular there.
    Singular,
    /// Corrections do not become smaller.
    Stalled {
        /// The latest correction against the sizes of the unknowns.
        correction: f64,
        /// How many were made.
        steps: usize,
    },
}

impl fmt::Display for NewtonError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Left(left) => left.fmt(out),
            Self::Singular => write!(out, "the equations are singular"),
            Self::Stalled { correction, steps } => write!(
                out,
                "after {steps} corrections the last one is still {correction:.1e} of the solution's size"
            ),
        }
    }
}

impl core::error::Error for NewtonError {}

/// More corrections are never needed near a solution.
const MOST_STEPS: usize = 16;
/// A correction is none below so many roundoffs of the solution's size.
const DONE_ROUNDOFFS: f64 = 64.0;
/// Where corrections no longer shrink, rounding does it; so large may they be then.
const STALLED: f64 = 1e-7;
/// A first correction beyond this is a leap to somewhere else.
const LEAP: f64 = 0.5;

/// The solution near a point.
///
/// # Errors
/// There is none, or none was found.
pub fn newton<R: Real>(
    problem: &mut dyn Problem<R>,
    start: &[R],
    conditions: &[Condition<R>],
) -> Result<Corrected<R>, NewtonError> {
    let size = problem.unknowns();
    let mut at = start.to_vec();
    let mut latest = f64::INFINITY;
    for steps in 1..=MOST_STEPS {
        let linearised = problem.evaluate(&at).map_err(NewtonError::Left)?;
        let equations = linearised.residual.len();
        let mut bordered = Matrix::zeros(size, size);
        for i in 0..equations {
            (bordered.row_mut(i)).copy_from_slice(linearised.jacobian.row(i));
        }
        let mut right = linearised.residual;
        let residual = (right.iter()).fold(0.0_f64, |most, x| most.max(x.abs().to_f64()));
        for (i, condition) in conditions.iter().enumerate() {
            bordered
                .row_mut(equations + i)
                .copy_from_slice(&condition.row);
            right.push(dot(&condition.row, &at) - condition.value);
        }
        let factors = bordered.factored().ok_or(NewtonError::Singular)?;
        let step = factors.solve(&right);
        if !step.iter().all(|x| x.is_finite()) {
            return Err(NewtonError::Singular);
        }
        let correction = (step.iter().zip(problem.scales())).fold(0.0_f64, |most, (x, scale)| {
            most.max(x.abs().to_f64() / scale)
        });
        if correction > LEAP {
            return Err(NewtonError::Stalled { correction, steps });
        }
        let grows = correction >= 0.5 * latest;
        for (x, step) in at.iter_mut().zip(&step) {
            *x -= *step;
        }
        let rounding = DONE_ROUNDOFFS * R::ROUNDOFF;
        if correction <= rounding || (grows && correction < STALLED.min(R::ROUNDOFF.sqrt())) {
            return Ok(Corrected {
                at,
                residual,
                correction,
                steps,
                factors,
            });
        }
        if grows && steps > 4 {
            return Err(NewtonError::Stalled { correction, steps });
        }
        latest = correction;
    }
    Err(NewtonError::Stalled {
        correction: latest,
        steps: MOST_STEPS,
    })
}
