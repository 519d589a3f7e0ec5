//! Newton's method, for as many equations as unknowns, in any number type.

use super::{Factored, Matrix, Real};

/// Equations at a point.
#[derive(Clone, Debug)]
pub struct Linearised<R> {
    /// What is to be zero.
    pub residual: Vec<R>,
    /// Its derivatives: a row for each equation, a column for each unknown.
    pub jacobian: Matrix<R>,
}

impl<R: Real> Linearised<R> {
    /// The derivatives, and one more row for each condition.
    pub fn bordered<'r>(&self, rows: impl IntoIterator<Item = &'r [R]>) -> Matrix<R>
    where
        R: 'r,
    {
        let mut bordered = self.jacobian.clone();
        rows.into_iter().for_each(|row| bordered.push(row));
        bordered
    }
}

/// As many equations as unknowns.
pub trait Equations<R: Real> {
    /// Why they have no meaning at a point.
    type Left;

    /// Residual and Jacobian at a point.
    ///
    /// # Errors
    /// The equations have no meaning there.
    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Self::Left>;

    /// How large a correction is at a point, against the size of the unknowns there.
    fn size(&self, at: &[R], correction: &[R]) -> f64;
}

/// How far Newton's method goes, and when it has arrived.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    /// At most so many corrections.
    pub steps: usize,
    /// A correction beyond this is a leap to somewhere else.
    pub leap: f64,
    /// Longer corrections are cut to this.
    pub longest: f64,
    /// One that leads where the equations have no meaning is halved so often.
    pub halvings: usize,
    /// A correction below this is none.
    pub done: f64,
    /// Where corrections do not become smaller, rounding makes them if they are below this: the point is as good as it gets.
    pub settled: f64,
    /// So many that are not the smallest so far may be due to something else.
    pub stalls: usize,
    /// A correction shrinks if it is less than this part of the one before.
    pub shrinks: f64,
    /// After so many corrections each must shrink.
    pub patience: usize,
}

impl Newton {
    /// From a start of any quality to so many roundoffs.
    pub fn to_rounding<R: Real>(roundoffs: f64) -> Self {
        let done = roundoffs * R::ROUNDOFF;
        Self {
            steps: 40,
            leap: f64::INFINITY,
            longest: f64::INFINITY,
            halvings: 0,
            done,
            settled: done.sqrt(),
            stalls: 0,
            shrinks: 1.0,
            patience: usize::MAX,
        }
    }
}

/// A solution.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    /// The unknowns.
    pub at: Vec<R>,
    /// The equations where the latest correction began.
    pub residual: Vec<R>,
    /// The latest correction.
    pub correction: f64,
    /// How many corrections were made.
    pub steps: usize,
    /// Factors of the latest Jacobian.
    pub factors: Factored<R>,
}

/// Why there is no solution nearby.
#[derive(Clone, Debug, PartialEq)]
pub enum NewtonError<L> {
    /// The equations have no meaning where it led.
    Left(L),
    /// They are singular there.
    Singular,
    /// Corrections do not become smaller.
    Stalled {
        /// The latest correction against the size of the unknowns.
        correction: f64,
        /// How many were made.
        steps: usize,
    },
}

impl Newton {
    /// The solution that corrections from a start lead to.
    ///
    /// # Errors
    /// There is none, or none was found.
    pub fn solve<R: Real, E: Equations<R> + ?Sized>(
        &self,
        equations: &mut E,
        start: &[R],
    ) -> Result<Solution<R>, NewtonError<E::Left>> {
        let mut at = start.to_vec();
        let mut here = equations.evaluate(&at).map_err(NewtonError::Left)?;
        let (mut latest, mut least) = (f64::INFINITY, f64::INFINITY);
        let mut stalls = 0;
        for steps in 1..=self.steps {
            let factors = here.jacobian.factored().ok_or(NewtonError::Singular)?;
            let step = factors.solve(&here.residual);
            if !step.iter().all(|x| x.is_finite()) {
                return Err(NewtonError::Singular);
            }
            let correction = equations.size(&at, &step);
            if !correction.is_finite() || correction > self.leap {
                return Err(NewtonError::Stalled { correction, steps });
            }
            let grows = correction >= self.shrinks * latest;
            let stalled = correction >= self.shrinks * least;
            stalls += usize::from(stalled);
            let mut part = (self.longest / correction).min(1.0);
            let moved = |part: f64| -> Vec<R> {
                let moved = at.iter().zip(&step).map(|(&x, &dx)| match part {
                    1.0 => x - dx,
                    _ => x - R::splat(part) * dx,
                });
                moved.collect()
            };
            let mut next = moved(part);
            let is_rounding = stalled && stalls > self.stalls && correction < self.settled;
            if correction <= self.done || is_rounding {
                return Ok(Solution {
                    at: next,
                    residual: here.residual,
                    correction,
                    steps,
                    factors,
                });
            }
            if grows && steps > self.patience {
                return Err(NewtonError::Stalled { correction, steps });
            }
            let mut there = equations.evaluate(&next);
            for _ in 0..self.halvings {
                if there.is_ok() {
                    break;
                }
                part *= 0.5;
                next = moved(part);
                there = equations.evaluate(&next);
            }
            here = there.map_err(NewtonError::Left)?;
            at = next;
            latest = correction;
            least = least.min(correction);
        }
        Err(NewtonError::Stalled {
            correction: latest,
            steps: self.steps,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};

    /// sqrt(x) - sqrt(value): no meaning below zero, where a full correction from a large start leads.
    struct Root<R>(R);

    impl<R: Real> Equations<R> for Root<R> {
        type Left = &'static str;

        fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Self::Left> {
            if at[0] <= R::ZERO {
                return Err("negative");
            }
            let root = at[0].sqrt();
            Ok(Linearised {
                residual: vec![root - self.0.sqrt()],
                jacobian: Matrix::from_rows(&[vec![R::ONE / (root + root)]]),
            })
        }

        fn size(&self, at: &[R], correction: &[R]) -> f64 {
            (correction[0] / at[0]).abs().to_f64()
        }
    }

    #[test]
    fn roots_are_found_to_rounding_in_any_number_type() {
        let newton = Newton::to_rounding::<f64>(4.0);
        let found = newton.solve(&mut Root(2.0_f64), &[3.0]).unwrap();
        assert!((found.at[0] - 2.0).abs() < 1e-15);
        let fine = Newton::to_rounding::<DoubleDouble>(4.0);
        let value = DoubleDouble::from(2.0);
        let found = fine
            .solve(&mut Root(value), &[DoubleDouble::from(3.0)])
            .unwrap();
        assert!((found.at[0] - value).abs().to_f64() < 1e-30);
    }

    #[test]
    fn what_does_not_lead_anywhere_is_told() {
        let newton = Newton::to_rounding::<f64>(4.0);
        let far = newton.solve(&mut Root(2.0_f64), &[20.0]);
        assert_eq!(far.unwrap_err(), NewtonError::Left("negative"));
        let careful = Newton {
            halvings: 8,
            ..newton
        };
        let found = careful.solve(&mut Root(2.0_f64), &[20.0]).unwrap();
        assert!((found.at[0] - 2.0).abs() < 1e-15);
        let hasty = Newton {
            leap: 0.1,
            ..newton
        };
        let error = hasty.solve(&mut Root(2.0_f64), &[3.0]).unwrap_err();
        assert!(matches!(error, NewtonError::Stalled { steps: 1, .. }));
    }
}
