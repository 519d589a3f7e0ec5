//! Solutions of an orbit's equations with one more condition, and how well their parameter is known.

use super::condition::Bordered;
use super::shooting::Shooting;
use crate::analysis::continuation::{Corrected, NewtonError, Problem, Singular, Station, newton};
use crate::numerics::{Complex, DoubleDouble, Real, dot};

/// The last correction of Newton's method is a sample of what rounding does; errors are so many of it.
pub(super) const NOISE: f64 = 16.0;

/// What rounding makes of a parameter.
pub(super) fn roundoff(parameter: f64) -> f64 {
    NOISE * f64::EPSILON * parameter.abs()
}

/// No rounding makes a larger correction, against the sizes of the unknowns.
const ROUNDED: f64 = 1e-7;

/// A solution.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// As doubles solve the equations: what doubles go on from.
    pub at: Vec<f64>,
    /// What it is, as well as that is known.
    pub told: Vec<f64>,
    pub residual: f64,
    pub correction: f64,
    /// Of the parameter.
    pub error: f64,
}

impl Shooting<f64> {
    /// Multipliers where a branch passes a station, as longer numbers tell them, and what their moduli may be off by. A curve in two parameters has one
    /// more condition, which these equations do not know.
    pub(crate) fn multipliers_beside(&self, station: &Station) -> Option<(Vec<Complex>, f64)> {
        if self.parameters() != 1 || station.tangent.len() != self.scales().len() {
            return None;
        }
        let across = station.across(self.scales());
        let row = longer(&across.row);
        let value = DoubleDouble::from(across.value);
        let mut own = self.clone();
        let found = newton(&mut own, &station.at, &[across]).ok()?;
        let start = found.at.clone();
        let mut told = None;
        own.refined_by(found, &start, |fine, at| {
            let here = fine.evaluate(at).ok()?;
            told = Some(fine.multipliers_known());
            let off = dot(&row, at) - value;
            Some(
                here.residual
                    .iter()
                    .chain([&off])
                    .map(|x| x.to_f64())
                    .collect(),
            )
        });
        told
    }

    /// The solution of the equations and a condition near a point.
    ///
    /// # Errors
    /// There is none, or none was found.
    pub(crate) fn solved(
        &mut self,
        bordered: &Bordered,
        start: &[f64],
    ) -> Result<Solved, NewtonError> {
        let found = newton(&mut bordered.of(self), start, &[])?;
        Ok(self.refined(bordered, found))
    }

    /// A solution in doubles, corrected twice more by what longer numbers leave of the equations there. Doubles do not tell how far rounding
    /// has taken it: where flights are short, or there are many of them, the same rounding is made at each correction. The second
    /// correction, which derivatives in doubles make necessary, tells how far the first one is to be trusted.
    pub(crate) fn refined(&self, bordered: &Bordered, found: Corrected<f64>) -> Solved {
        let start = found.at.clone();
        self.refined_by(found, &start, |fine, at| left_of(fine, bordered, at))
            .0
    }

    /// The same of equations that may have more unknowns, the last of them, from what is left of all of them; with these as they are then.
    pub(crate) fn refined_by(
        &self,
        found: Corrected<f64>,
        start: &[f64],
        mut left_of: impl FnMut(&mut Shooting<DoubleDouble>, &[DoubleDouble]) -> Option<Vec<f64>>,
    ) -> (Solved, Vec<f64>) {
        let (own, last) = (found.at.len(), found.at.len().saturating_sub(1));
        let parameter = found.at.last().copied().unwrap_or_default();
        let scale = self.scales().last().copied().unwrap_or(1.0);
        let mut solved = Solved {
            residual: found.residual,
            correction: found.correction,
            error: roundoff(parameter).max(NOISE * found.correction * scale),
            told: found.at.clone(),
            at: found.at,
        };
        let more = start[own..].to_vec();
        let Ok(mut fine) = self.in_longer_numbers(&solved.at) else {
            return (solved, more);
        };
        let mut at = longer(start);
        let mut latest = ROUNDED;
        for _ in 0..2 {
            let Some(left) = left_of(&mut fine, &at) else {
                return (solved, more);
            };
            let by = found.factors.solve(&left);
            let off = by.get(last).copied().unwrap_or_default().abs();
            // A parameter whose range is narrow is rounded to what it is itself.
            let parts = by[..last].iter().zip(self.scales());
            let most = parts.fold(off / parameter.abs().max(scale), |most, (x, size)| {
                most.max(x.abs() / size)
            });
            if most.is_nan() || most > latest {
                solved.error = solved.error.max(off);
                return (solved, more);
            }
            (at.iter_mut().zip(&by)).for_each(|(x, &by)| *x -= DoubleDouble::from(by));
            latest = most;
            solved.error = roundoff(parameter).max(off);
        }
        let all: Vec<f64> = at.iter().map(|x| x.to_f64()).collect();
        solved.told = all[..own].to_vec();
        (solved, all[own..].to_vec())
    }
}

fn longer(numbers: &[f64]) -> Vec<DoubleDouble> {
    numbers.iter().map(|&x| DoubleDouble::from(x)).collect()
}

/// What equations and condition leave of zero at a point.
fn left_of(
    fine: &mut Shooting<DoubleDouble>,
    bordered: &Bordered,
    at: &[DoubleDouble],
) -> Option<Vec<f64>> {
    let here = fine.evaluate(at).ok()?;
    let condition = match bordered {
        Bordered::Monitor(index) => fine.monitor(*index, at).ok()?.0,
        Bordered::Level(index, level) => {
            fine.monitor(*index, at).ok()?.0 - DoubleDouble::from(*level)
        }
        Bordered::Singular(singular) => {
            let borders = longer(&singular.borders());
            Singular::with_borders(singular.sign(), &borders).defect(&fine.wrap(), &here)?
        }
    };
    let left = here.residual.iter().chain([&condition]);
    Some(left.map(|x| x.to_f64()).collect())
}
