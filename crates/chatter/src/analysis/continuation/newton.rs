//! Newton's method on a problem that is bordered by linear conditions.

use super::problem::{Left, Problem};
use crate::numerics::{Factored, Real, dot};
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
        let mut row = vec![R::ZERO; unknowns];
        row[index] = R::ONE;
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

/// What a point is to be moved by, backwards.
struct Correction<R> {
    step: Vec<R>,
    factors: Factored<R>,
    /// Largest residual of the equations.
    residual: f64,
    /// Against the sizes of the unknowns.
    size: f64,
}

fn correction<R: Real>(
    problem: &mut dyn Problem<R>,
    at: &[R],
    conditions: &[Condition<R>],
) -> Result<Correction<R>, NewtonError> {
    let linearised = problem.evaluate(at).map_err(NewtonError::Left)?;
    let bordered = linearised.bordered(conditions.iter().map(|condition| &*condition.row));
    let mut right = linearised.residual;
    let residual = (right.iter()).fold(0.0_f64, |most, x| most.max(x.abs().to_f64()));
    let off = |condition: &Condition<R>| dot(&condition.row, at) - condition.value;
    right.extend(conditions.iter().map(off));
    let factors = bordered.factored().ok_or(NewtonError::Singular)?;
    let step = factors.solve(&right);
    if !step.iter().all(|x| x.is_finite()) {
        return Err(NewtonError::Singular);
    }
    let size = (step.iter().zip(problem.scales())).fold(0.0_f64, |most, (x, scale)| {
        most.max(x.abs().to_f64() / scale)
    });
    Ok(Correction {
        step,
        factors,
        residual,
        size,
    })
}

/// Corrections of a wild first guess: no longer than so much of the solution's size, and halved where they lead nowhere.
const DAMPED: usize = 30;
const LONGEST: f64 = 0.2;
const HALVINGS: usize = 8;
/// What is left for [`newton`].
const NEAR: f64 = 1e-6;

/// A point near a solution, from a guess that may be far off.
///
/// # Errors
/// None was found.
pub fn approach<R: Real>(
    problem: &mut dyn Problem<R>,
    start: &[R],
    conditions: &[Condition<R>],
) -> Result<Vec<R>, NewtonError> {
    let mut at = start.to_vec();
    let mut latest = f64::NAN;
    for _ in 0..DAMPED {
        let Correction { step, size, .. } = correction(problem, &at, conditions)?;
        if size < NEAR {
            return Ok(at);
        }
        latest = size;
        let mut part = (LONGEST / size).min(1.0);
        let mut moved = None;
        for _ in 0..HALVINGS {
            let next: Vec<R> = (at.iter().zip(&step))
                .map(|(&x, &s)| x - R::splat(part) * s)
                .collect();
            if problem.evaluate(&next).is_ok() {
                moved = Some(next);
                break;
            }
            part *= 0.5;
        }
        at = moved.ok_or(NewtonError::Stalled {
            correction: size,
            steps: DAMPED,
        })?;
    }
    Err(NewtonError::Stalled {
        correction: latest,
        steps: DAMPED,
    })
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
    let mut at = start.to_vec();
    let mut latest = f64::INFINITY;
    for steps in 1..=MOST_STEPS {
        let Correction {
            step,
            factors,
            residual,
            size: correction,
        } = correction(problem, &at, conditions)?;
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
