//! Points where two solution curves meet: the equations' derivatives have one rank less than anywhere else on them.

use super::curve::length;
use super::newton::{Corrected, NewtonError, close_by};
use super::problem::{Left, Problem};
use crate::numerics::{Equations, Factored, Linearised, Matrix, dot, unit};

/// The equations of a meeting, with J all derivatives of F, b a column and c_1, c_2 rows that border them:
///
/// ```text
/// F + a b = 0,      [ J   b ]       J has lost a rank where g_1 = g_2 = 0;      [w^T g] [J b; c 0] = [0 1]
/// g_1 = g_2 = 0     [ c^T 0 ]       dg_k = -w^T dJ v_k,                         [J b; c 0] [v_k; .] = e_k
/// ```
///
/// The unknown a, zero at the solution, unfolds the meeting: so they are regular where F by itself is not.
struct Meeting<'p> {
    problem: &'p mut dyn Problem<f64>,
    column: Vec<f64>,
    rows: [Vec<f64>; 2],
}

/// Steps from which on the borders are near the null vectors.
const ITERATIONS: usize = 3;

impl Meeting<'_> {
    fn bordered(&self, jacobian: &Matrix<f64>) -> Option<Factored<f64>> {
        let (equations, unknowns) = (jacobian.rows(), jacobian.columns());
        let mut bordered = Matrix::zeros(unknowns + 1, unknowns + 1);
        for i in 0..equations {
            bordered.row_mut(i)[..unknowns].copy_from_slice(jacobian.row(i));
            bordered[(i, unknowns)] = self.column[i];
        }
        for (k, row) in self.rows.iter().enumerate() {
            bordered.row_mut(equations + k)[..unknowns].copy_from_slice(row);
        }
        bordered.factored()
    }

    /// w and g, then both v.
    fn null_vectors(&self, jacobian: &Matrix<f64>) -> Result<(Vec<f64>, [Vec<f64>; 2]), Left> {
        let (equations, unknowns) = (jacobian.rows(), jacobian.columns());
        let factors = (self.bordered(jacobian))
            .ok_or_else(|| Left::because("more than two curves meet here"))?;
        let left = factors.solve_transposed(&unit(unknowns + 1, unknowns));
        let right = [0, 1].map(|k| {
            let mut along = factors.solve(&unit(unknowns + 1, equations + k));
            along.truncate(unknowns);
            along
        });
        Ok((left, right))
    }

    /// Borders near the null vectors at a point.
    fn renew(&mut self, at: &[f64]) -> Result<(), Left> {
        let jacobian = self.problem.evaluate(at)?.jacobian;
        let equations = jacobian.rows();
        for _ in 0..ITERATIONS {
            let (mut left, [mut one, mut two]) = self.null_vectors(&jacobian)?;
            left.truncate(equations);
            scale(&mut left);
            scale(&mut one);
            let shared = dot(&one, &two);
            two.iter_mut().zip(&one).for_each(|(x, y)| *x -= shared * y);
            scale(&mut two);
            self.column = left;
            self.rows = [one, two];
        }
        Ok(())
    }

    /// The change of w^T J along v, by all unknowns.
    fn bends(&mut self, at: &[f64], along: &[f64], left: &[f64]) -> Result<Vec<f64>, Left> {
        let scales = self.problem.scales();
        let reach =
            (along.iter().zip(scales)).fold(0.0_f64, |most, (x, scale)| most.max(x.abs() / scale));
        let mut step = libm::cbrt(f64::EPSILON) / reach.max(f64::MIN_POSITIVE);
        for _ in 0..8 {
            let mut beside = |by: f64| -> Result<Vec<f64>, Left> {
                let point: Vec<f64> = at.iter().zip(along).map(|(x, v)| x + by * v).collect();
                Ok(self
                    .problem
                    .evaluate(&point)?
                    .jacobian
                    .apply_transposed(left))
            };
            if let Ok((up, down)) = beside(step).and_then(|up| Ok((up, beside(-step)?))) {
                return Ok((up.iter().zip(&down))
                    .map(|(up, down)| (up - down) / (2.0 * step))
                    .collect());
            }
            step *= 0.1;
        }
        Err(Left::because("no neighbourhood of the point has equations"))
    }
}

fn scale(vector: &mut [f64]) {
    let length = dot(vector, vector).sqrt();
    vector.iter_mut().for_each(|x| *x /= length);
}

impl Equations<f64> for Meeting<'_> {
    type Left = Left;

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, Left> {
        let unknowns = at.len() - 1;
        let (point, unfolds) = (&at[..unknowns], at[unknowns]);
        let inner = self.problem.evaluate(point)?;
        let equations = inner.residual.len();
        let (left, right) = self.null_vectors(&inner.jacobian)?;
        let (left, g) = left.split_at(equations);
        let mut residual = inner.residual;
        let mut jacobian = Matrix::zeros(unknowns + 1, unknowns + 1);
        for i in 0..equations {
            residual[i] += unfolds * self.column[i];
            jacobian.row_mut(i)[..unknowns].copy_from_slice(inner.jacobian.row(i));
            jacobian[(i, unknowns)] = self.column[i];
        }
        residual.extend(g);
        for (k, along) in right.iter().enumerate() {
            let slopes = self.bends(point, along, left)?;
            for (entry, slope) in jacobian.row_mut(equations + k).iter_mut().zip(slopes) {
                *entry = -slope;
            }
        }
        Ok(Linearised { residual, jacobian })
    }

    fn size(&self, _: &[f64], correction: &[f64]) -> f64 {
        let parts = correction.iter().zip(self.problem.scales());
        parts.fold(0.0_f64, |most, (x, scale)| most.max(x.abs() / scale))
    }
}

/// Before borders are near the null vectors they are any that are not orthogonal to these.
fn near(problem: &mut dyn Problem<f64>) -> Meeting<'_> {
    let unknowns = problem.unknowns();
    let some = |count: usize, k: f64| -> Vec<f64> {
        (0..count)
            .map(|i| libm::sin(k + (1.0 + k) * i as f64))
            .collect()
    };
    Meeting {
        column: some(unknowns - problem.parameters(), 1.0),
        rows: [some(unknowns, 0.3), some(unknowns, 0.7)],
        problem,
    }
}

/// The direction of the other curve through a point where two meet, of length one where each unknown is measured by its size; the one
/// goes about `along`. Both are null vectors t of J, and since F vanishes on either curve to the second order, w^T (dJ t) t = 0: a
/// quadratic equation. None where it has no two solutions.
pub fn other_direction(
    problem: &mut dyn Problem<f64>,
    at: &[f64],
    along: &[f64],
) -> Option<Vec<f64>> {
    let scales = problem.scales().to_vec();
    let mut equations = near(problem);
    equations.renew(at).ok()?;
    let ([one, two], left) = (equations.rows.clone(), equations.column.clone());
    let by_one = equations.bends(at, &one, &left).ok()?;
    let by_two = equations.bends(at, &two, &left).ok()?;
    let (a, c) = (dot(&by_one, &one), dot(&by_two, &two));
    let b = 0.5 * (dot(&by_one, &two) + dot(&by_two, &one));
    let root = (b * b - a * c).sqrt();
    if root.is_nan() || root == 0.0 {
        return None;
    }
    let q = -(b + root.copysign(b));
    let both = [(q, a), (c, q)].map(|(x, y)| {
        let mut sum: Vec<f64> = one.iter().zip(&two).map(|(v, w)| x * v + y * w).collect();
        let length = length(&sum, &scales);
        sum.iter_mut().for_each(|x| *x /= length);
        sum
    });
    let aligned = |other: &[f64]| {
        let parts = other.iter().zip(along).zip(&scales);
        parts.map(|((x, y), s)| x / s * (y / s)).sum::<f64>().abs()
    };
    let other = both.into_iter();
    other.min_by(|x, y| aligned(x).total_cmp(&aligned(y)))
}

/// The point near `start` where the solution curve meets another.
///
/// # Errors
/// There is none, or none was found.
pub fn meeting(
    problem: &mut dyn Problem<f64>,
    start: &[f64],
) -> Result<Corrected<f64>, NewtonError> {
    let unknowns = problem.unknowns();
    let mut equations = near(problem);
    equations.renew(start).map_err(NewtonError::Left)?;
    let mut extended = start.to_vec();
    extended.push(0.0);
    let found = close_by::<f64>().solve(&mut equations, &extended)?;
    let mut at = found.at;
    at.truncate(unknowns);
    let own = &found.residual[..unknowns - 1];
    Ok(Corrected {
        residual: own.iter().fold(0.0_f64, |most, x| most.max(x.abs())),
        at,
        correction: found.correction,
        steps: found.steps,
        factors: found.factors,
    })
}
