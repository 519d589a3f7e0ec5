//! Newton's method on a problem that is bordered by linear conditions.

use super::problem::{Left, Problem};
use crate::numerics::{Equations, Factored, Linearised, Newton, Real, dot, unit};
use core::fmt;
use core::ops::Range;

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
        let row = unit(unknowns, index);
        Self { row, value }
    }

    /// That these unknowns are what they are at a point.
    pub fn held(at: &[R], indices: Range<usize>) -> Vec<Self> {
        indices
            .map(|index| Self::fixed(at.len(), index, at[index]))
            .collect()
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
pub type NewtonError = crate::numerics::NewtonError<Left>;

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

/// A correction is none below so many roundoffs of the solution's size.
const DONE_ROUNDOFFS: f64 = 64.0;
/// Where corrections no longer shrink, rounding does it; so large may they be then.
const STALLED: f64 = 1e-7;

/// Near a solution few corrections are needed, and a large one is a leap to somewhere else.
pub(super) fn close_by<R: Real>() -> Newton {
    Newton {
        steps: 16,
        leap: 0.5,
        settled: STALLED.min(R::ROUNDOFF.sqrt()),
        shrinks: 0.5,
        patience: 4,
        ..Newton::to_rounding::<R>(DONE_ROUNDOFFS)
    }
}

/// Corrections of a wild first guess: short ones, halved where they lead nowhere; what is left is for [`newton`].
const FAR: Newton = Newton {
    steps: 30,
    leap: f64::INFINITY,
    longest: 0.2,
    halvings: 7,
    done: 1e-6,
    settled: 0.0,
    stalls: 0,
    shrinks: 1.0,
    patience: usize::MAX,
};

/// A problem with as many conditions as it has free parameters.
struct Bordered<'p, R: Real> {
    problem: &'p mut dyn Problem<R>,
    conditions: &'p [Condition<R>],
}

impl<R: Real> Equations<R> for Bordered<'_, R> {
    type Left = Left;

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let linearised = self.problem.evaluate(at)?;
        let rows = self.conditions.iter().map(|condition| &*condition.row);
        let jacobian = linearised.bordered(rows);
        let mut residual = linearised.residual;
        let off = |condition: &Condition<R>| dot(&condition.row, at) - condition.value;
        residual.extend(self.conditions.iter().map(off));
        Ok(Linearised { residual, jacobian })
    }

    fn size(&self, _: &[R], correction: &[R]) -> f64 {
        let parts = correction.iter().zip(self.problem.scales());
        parts.fold(0.0_f64, |most, (x, scale)| {
            most.max(x.abs().to_f64() / scale)
        })
    }
}

/// A point near a solution, from a guess that may be far off.
///
/// # Errors
/// None was found.
pub fn approach<R: Real>(
    problem: &mut dyn Problem<R>,
    start: &[R],
    conditions: &[Condition<R>],
) -> Result<Vec<R>, NewtonError> {
    let mut equations = Bordered {
        problem,
        conditions,
    };
    Ok(FAR.solve(&mut equations, start)?.at)
}

/// The solution near a point.
///
/// # Errors
/// There is none, or none was found.
pub fn newton<R: Real>(
    problem: &mut dyn Problem<R>,
    start: &[R],
    conditions: &[Condition<R>],
) -> Result<Corrected<R>, NewtonError> {
    let mut equations = Bordered {
        problem,
        conditions,
    };
    let found = close_by::<R>().solve(&mut equations, start)?;
    let own = &found.residual[..found.residual.len() - conditions.len()];
    Ok(Corrected {
        residual: (own.iter()).fold(0.0_f64, |most, x| most.max(x.abs().to_f64())),
        at: found.at,
        correction: found.correction,
        steps: found.steps,
        factors: found.factors,
    })
}
