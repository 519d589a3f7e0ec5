//! A problem with one more condition: special points are its solutions, their curves its curves.

use super::problem::{Left, Linearised, Problem, Wrap};
use crate::numerics::{Factored, Matrix, Real, dot, unit};

/// A matrix that is singular on the curve, by its bordering.
///
/// With A the derivatives by the unknowns that are no parameters, and b, c near its null vectors,
///
/// ```text
/// [ A   b ] [v]   [0]
/// [ c^T 0 ] [g] = [1]        g = 0 where A is singular,      dg = -w^T dA v
/// ```
///
/// w from the transposed system. Since A v is the derivative of the residual along v, the gradient of g is the change of
/// w^T J along v: two more Jacobians give all of it.
#[derive(Clone, Debug)]
pub struct Singular<R> {
    /// With this sign the last image of a cycle is compared with its first point: 1 for a fold, -1 for a period doubling.
    sign: f64,
    b: Vec<R>,
    c: Vec<R>,
}

/// What is held at zero.
#[derive(Clone, Debug)]
enum Condition<R> {
    Singular(Singular<R>),
    /// A function of the problem, less a number.
    Monitor(usize, R),
}

/// A problem and a condition.
#[derive(Debug)]
pub struct Held<'p, R, P: ?Sized> {
    problem: &'p mut P,
    condition: Condition<R>,
}

/// Steps of inverse iteration from which on the null vectors of a nearly singular matrix are known.
const ITERATIONS: usize = 4;

fn turned<R: Real>(linearised: &Linearised<R>, wrap: &Wrap, sign: f64) -> Matrix<R> {
    let size = linearised.residual.len();
    let mut matrix = Matrix::zeros(size, size);
    for i in 0..size {
        (matrix.row_mut(i)).copy_from_slice(&linearised.jacobian.row(i)[..size]);
    }
    for &(row, column, entry) in &wrap.entries {
        matrix[(row, column)] += R::splat((sign - 1.0) * entry);
    }
    matrix
}

fn normalised<R: Real>(mut vector: Vec<R>) -> Option<Vec<R>> {
    let length = dot(&vector, &vector).sqrt();
    if !(length > R::ZERO && length.is_finite()) {
        return None;
    }
    vector.iter_mut().for_each(|x| *x = *x / length);
    Some(vector)
}

/// A matrix with one more column and row.
fn bordered<R: Real>(matrix: &Matrix<R>, column: &[R], row: &[R]) -> Option<Factored<R>> {
    let size = matrix.rows();
    let mut bordered = Matrix::zeros(size + 1, size + 1);
    for i in 0..size {
        bordered.row_mut(i)[..size].copy_from_slice(matrix.row(i));
        bordered[(i, size)] = column[i];
        bordered[(size, i)] = row[i];
    }
    bordered.factored()
}

impl<R: Real> Singular<R> {
    /// Borders found at a point near the curve, with `sign` as described.
    ///
    /// # Errors
    /// The equations have no meaning there.
    pub fn near<P: Problem<R> + ?Sized>(
        problem: &mut P,
        at: &[R],
        sign: f64,
    ) -> Result<Self, Left> {
        Self::from_start(problem, at, sign, None)
    }

    /// The same borders at a point further on.
    ///
    /// # Errors
    /// As for [`near`](Self::near).
    pub fn renewed<P: Problem<R> + ?Sized>(&self, problem: &mut P, at: &[R]) -> Result<Self, Left> {
        Self::from_start(problem, at, self.sign, Some(self))
    }

    fn from_start<P: Problem<R> + ?Sized>(
        problem: &mut P,
        at: &[R],
        sign: f64,
        before: Option<&Self>,
    ) -> Result<Self, Left> {
        let linearised = problem.evaluate(at)?;
        let matrix = turned(&linearised, &problem.wrap(), sign);
        let size = matrix.rows();
        let singular = || Left::because("the equations have more than one null vector");
        let start: Vec<R> = (0..size)
            .map(|i| R::splat(1.0 + 0.3 * libm::sin(1.0 + i as f64)))
            .collect();
        let start = normalised(start).ok_or_else(singular)?;
        let (mut right, mut left) = match before {
            Some(before) => (before.c.clone(), before.b.clone()),
            None => (start.clone(), start),
        };
        // By the bordered matrix, which is regular however near to singular the other one is.
        for _ in 0..ITERATIONS {
            let factors = bordered(&matrix, &left, &right).ok_or_else(singular)?;
            let one = unit(size + 1, size);
            right = normalised(factors.solve(&one)[..size].to_vec()).ok_or_else(singular)?;
            left =
                normalised(factors.solve_transposed(&one)[..size].to_vec()).ok_or_else(singular)?;
        }
        // Along a curve they turn, and do not change their sign.
        if let Some(before) = before {
            for (vector, known) in [(&mut left, &before.b), (&mut right, &before.c)] {
                if dot(vector, known) < R::ZERO {
                    vector.iter_mut().for_each(|x| *x = -*x);
                }
            }
        }
        Ok(Self {
            sign,
            b: left,
            c: right,
        })
    }

    /// With borders that are known: b, then c.
    pub(crate) fn with_borders(sign: f64, borders: &[R]) -> Self {
        let (b, c) = borders.split_at(borders.len() / 2);
        let (b, c) = (b.to_vec(), c.to_vec());
        Self { sign, b, c }
    }

    /// b, then c.
    pub(crate) fn borders(&self) -> Vec<R> {
        [&*self.b, &*self.c].concat()
    }

    /// With which sign a cycle is closed.
    pub fn sign(&self) -> f64 {
        self.sign
    }

    /// What the matrix takes to zero, of length one: one number for each unknown that is no parameter.
    pub fn direction(&self) -> &[R] {
        &self.c
    }

    /// g alone, from derivatives that are known; none where they are singular even with the borders.
    pub(crate) fn defect(&self, wrap: &Wrap, linearised: &Linearised<R>) -> Option<R> {
        let size = linearised.residual.len();
        let factors = bordered(&turned(linearised, wrap, self.sign), &self.b, &self.c)?;
        Some(factors.solve(&unit(size + 1, size))[size])
    }

    /// g and its gradient.
    fn value<P: Problem<R> + ?Sized>(
        &self,
        problem: &mut P,
        at: &[R],
        linearised: &Linearised<R>,
    ) -> Result<(R, Vec<R>), Left> {
        let size = linearised.residual.len();
        let matrix = turned(linearised, &problem.wrap(), self.sign);
        let factors = bordered(&matrix, &self.b, &self.c)
            .ok_or_else(|| Left::because("the bordered equations are singular"))?;
        let right = unit(size + 1, size);
        let v = factors.solve(&right);
        let w = factors.solve_transposed(&right);
        // A displacement along v by a small part of the size of whatever it displaces most.
        let reach = (v[..size].iter().zip(problem.scales())).fold(0.0_f64, |most, (x, scale)| {
            most.max(x.abs().to_f64() / scale)
        });
        let part = libm::cbrt(R::ROUNDOFF);
        let mut displacement = R::splat(part / reach.max(f64::MIN_POSITIVE));
        let mut slopes = None;
        for _ in 0..8 {
            let mut moved = |by: R| {
                let mut point = at.to_vec();
                for (x, &v) in point.iter_mut().zip(&v[..size]) {
                    *x += by * v;
                }
                let jacobian = problem.evaluate(&point)?.jacobian;
                Ok::<_, Left>(jacobian.apply_transposed(&w[..size]))
            };
            let pair = moved(displacement).and_then(|up| Ok((up, moved(-displacement)?)));
            if let Ok(pair) = pair {
                slopes = Some(pair);
                break;
            }
            displacement *= R::splat(0.1);
        }
        let Some((up, down)) = slopes else {
            return Err(Left::because("no neighbourhood of the point has equations"));
        };
        let twice = displacement + displacement;
        let gradient = (up.iter().zip(&down))
            .map(|(&up, &down)| -(up - down) / twice)
            .collect();
        Ok((v[size], gradient))
    }
}

impl<'p, R: Real, P: Problem<R> + ?Sized> Held<'p, R, P> {
    /// Where a matrix is singular.
    pub fn singular(problem: &'p mut P, singular: Singular<R>) -> Self {
        Self {
            problem,
            condition: Condition::Singular(singular),
        }
    }

    /// The problem itself.
    pub fn problem_mut(&mut self) -> &mut P {
        self.problem
    }

    /// Where a function of the problem vanishes.
    pub fn monitor(problem: &'p mut P, index: usize) -> Self {
        Self::level(problem, index, R::ZERO)
    }

    /// Where a function of the problem has a value.
    pub fn level(problem: &'p mut P, index: usize, level: R) -> Self {
        Self {
            problem,
            condition: Condition::Monitor(index, level),
        }
    }
}

impl<R: Real, P: Problem<R> + ?Sized> Problem<R> for Held<'_, R, P> {
    fn unknowns(&self) -> usize {
        self.problem.unknowns()
    }

    fn parameters(&self) -> usize {
        self.problem.parameters() - 1
    }

    fn scales(&self) -> &[f64] {
        self.problem.scales()
    }

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let inner = self.problem.evaluate(at)?;
        let (value, gradient) = match &self.condition {
            Condition::Singular(singular) => singular.value(self.problem, at, &inner)?,
            Condition::Monitor(index, level) => {
                let (value, gradient) = self.problem.monitor(*index, at)?;
                (value - *level, gradient)
            }
        };
        let jacobian = inner.bordered([&*gradient]);
        let mut residual = inner.residual;
        residual.push(value);
        Ok(Linearised { residual, jacobian })
    }
}
