//! Where two functions vanish at once on a curve whose equations are singular there, as the two halves of a solution with a symmetry make them.

use super::curve::length;
use super::newton::{Corrected, NewtonError, close_by};
use super::problem::{Left, Problem};
use crate::numerics::{Equations, Linearised, Matrix, Real, dot, unit};

/// The equations of a coincidence, with r_1 and r_2 the functions and b a column:
///
/// ```text
/// F + a b = 0,      r_1 = r_2 = 0;      [J; dr_1 + dr_2]^T [y; .] = dr_1 - dr_2,    b = y / |y|
/// ```
///
/// The unknown a, zero at the solution, is how far the equations are from one where both vanish. b is what of F the difference of both
/// tells most of: where J has lost a rank by displacements that take one up and the other down, what J does not reach. There F with one of the
/// conditions has a root that is not simple, and this one is.
#[derive(Debug)]
pub struct Coincidence<'p, R: Real, P: ?Sized> {
    problem: &'p mut P,
    conditions: [usize; 2],
    column: Vec<R>,
}

/// A solution.
#[derive(Debug)]
pub struct Coincident {
    /// Of the problem's own unknowns.
    pub found: Corrected<f64>,
    /// b.
    pub column: Vec<f64>,
    /// a.
    pub unfolds: f64,
    /// The direction along which both functions grow alike, of length one where each unknown is measured by its size: that of the curve, where they
    /// do so along it.
    pub along: Vec<f64>,
}

impl<'p, R: Real, P: Problem<R> + ?Sized> Coincidence<'p, R, P> {
    /// With a column that is known.
    pub fn with_column(problem: &'p mut P, conditions: [usize; 2], column: Vec<R>) -> Self {
        Self {
            problem,
            conditions,
            column,
        }
    }

    /// With that of a point near the solution.
    ///
    /// # Errors
    /// The equations have no meaning there, or are singular however they are bordered.
    pub fn near(problem: &'p mut P, at: &[R], conditions: [usize; 2]) -> Result<Self, NewtonError> {
        let linearised = problem.evaluate(at).map_err(NewtonError::Left)?;
        let mut slopes = Vec::with_capacity(2);
        for index in conditions {
            slopes.push(problem.monitor(index, at).map_err(NewtonError::Left)?.1);
        }
        let with = |sign: R| -> Vec<R> {
            let both = slopes[0].iter().zip(&slopes[1]);
            both.map(|(&one, &other)| one + sign * other).collect()
        };
        let (sum, difference) = (with(R::ONE), with(-R::ONE));
        let factors = linearised.bordered([&*sum]).factored();
        let factors = factors.ok_or(NewtonError::Singular)?;
        let mut column = factors.solve_transposed(&difference);
        column.truncate(linearised.residual.len());
        let length = dot(&column, &column).sqrt();
        if !(length > R::ZERO && length.is_finite()) {
            return Err(NewtonError::Singular);
        }
        column.iter_mut().for_each(|x| *x = *x / length);
        Ok(Self::with_column(problem, conditions, column))
    }
}

impl<R: Real, P: Problem<R> + ?Sized> Equations<R> for Coincidence<'_, R, P> {
    type Left = Left;

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let unknowns = at.len() - 1;
        let (point, unfolds) = (&at[..unknowns], at[unknowns]);
        let inner = self.problem.evaluate(point)?;
        let mut residual = inner.residual;
        let equations = residual.len();
        let mut jacobian = Matrix::zeros(unknowns + 1, unknowns + 1);
        for (i, &by) in self.column.iter().enumerate() {
            residual[i] += unfolds * by;
            jacobian.row_mut(i)[..unknowns].copy_from_slice(inner.jacobian.row(i));
            jacobian[(i, unknowns)] = by;
        }
        for (k, index) in self.conditions.into_iter().enumerate() {
            let (value, slopes) = self.problem.monitor(index, point)?;
            residual.push(value);
            jacobian.row_mut(equations + k)[..unknowns].copy_from_slice(&slopes);
        }
        Ok(Linearised { residual, jacobian })
    }

    fn size(&self, _: &[R], correction: &[R]) -> f64 {
        let parts = correction.iter().zip(self.problem.scales());
        parts.fold(0.0_f64, |most, (x, scale)| {
            most.max(x.abs().to_f64() / scale)
        })
    }
}

/// The coincidence near a point, of a problem with one parameter.
///
/// # Errors
/// There is none, or none was found.
pub fn coincidence(
    problem: &mut dyn Problem<f64>,
    start: &[f64],
    conditions: [usize; 2],
) -> Result<Coincident, NewtonError> {
    let equations = Coincidence::near(problem, start, conditions)?;
    let column = equations.column;
    coincidence_along(problem, start, conditions, column)
}

/// The same with a column that is known.
///
/// # Errors
/// There is none, or none was found.
pub fn coincidence_along(
    problem: &mut dyn Problem<f64>,
    start: &[f64],
    conditions: [usize; 2],
    column: Vec<f64>,
) -> Result<Coincident, NewtonError> {
    let (unknowns, scales) = (start.len(), problem.scales().to_vec());
    let mut equations = Coincidence::with_column(problem, conditions, column);
    let mut extended = start.to_vec();
    extended.push(0.0);
    let found = close_by::<f64>().solve(&mut equations, &extended)?;
    let mut at = found.at;
    let unfolds = at.pop().unwrap_or_default();
    let alike = [unknowns - 1, unknowns].map(|row| found.factors.solve(&unit(unknowns + 1, row)));
    let mut along: Vec<f64> = { alike[0].iter().zip(&alike[1]) }
        .map(|(one, other)| one + other)
        .collect();
    along.truncate(unknowns);
    let length = length(&along, &scales);
    along.iter_mut().for_each(|x| *x /= length);
    let own = &found.residual[..unknowns - 1];
    Ok(Coincident {
        found: Corrected {
            residual: own.iter().fold(0.0_f64, |most, x| most.max(x.abs())),
            at,
            correction: found.correction,
            steps: found.steps,
            factors: found.factors,
        },
        column: equations.column,
        unfolds,
        along,
    })
}
