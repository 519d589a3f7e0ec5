//! Orbits of the map, and mu at which a point is periodic.

use super::super::argument::Argument;
use super::super::evaluate::Universal;
use crate::numerics::{Equations, Linearised, Matrix, Newton, Real};

/// On which branch a point is: the lap, and whether K Upsilon rises there (Upsilon does, that is).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Branch {
    pub lap: i64,
    pub rising: bool,
}

/// In place of a lap: complete chatter, which is infinitely many laps away.
pub(super) const COMPLETE: i64 = i64::MAX;

/// F with slope K.
#[derive(Clone, Copy)]
pub(super) struct Family<'a, R> {
    pub universal: &'a Universal<R>,
    pub slope: R,
}

/// A periodic point: its x, and mu.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place<R> {
    pub x: R,
    pub mu: R,
}

/// A correction below this many roundoffs is none.
const DONE: f64 = 16.0;

impl<R: Real + Argument<Real = R>> Family<'_, R> {
    /// The point after `x`.
    pub(super) fn next(&self, x: R, mu: R) -> R {
        self.slope * self.universal.value(x) + mu
    }

    /// The next `count` points.
    pub(super) fn orbit(&self, start: Place<R>, count: usize) -> Vec<R> {
        let mut points = vec![start.x];
        for k in 1..count {
            points.push(self.next(points[k - 1], start.mu));
        }
        points
    }

    /// The branches of these points.
    pub(super) fn word(&self, points: &[R]) -> Vec<Branch> {
        let branch = |&x: &R| {
            let at = self.universal.at(x);
            let lap = at.lap.to_f64();
            Branch {
                lap: if lap.is_finite() {
                    lap as i64
                } else {
                    COMPLETE
                },
                rising: at.derivative >= R::ZERO,
            }
        };
        points.iter().map(branch).collect()
    }

    /// The multiplier of the orbit that runs through these points.
    pub(super) fn multiplier(&self, points: &[R]) -> R {
        points.iter().fold(R::ONE, |product, &x| {
            product * self.slope * self.universal.at(x).derivative
        })
    }

    /// mu at which `x` returns to itself after `period` steps, by Newton's method from `mu`; with what is left of the
    /// equation.
    pub(super) fn recurrent(&self, x: R, mu: R, period: usize) -> Option<(Place<R>, R)> {
        let mut returns = Returns {
            family: self,
            x,
            period,
        };
        let newton = Newton::to_rounding::<R>(DONE);
        let mu = newton.solve(&mut returns, &[mu]).ok()?.at[0];
        let (left, _) = returns.missed(mu);
        let good = left.abs() <= R::splat(1e3 * R::ROUNDOFF).sqrt() * x.abs();
        good.then_some((Place { x, mu }, left))
    }
}

/// That a point returns to itself, as an equation for mu.
struct Returns<'a, R> {
    family: &'a Family<'a, R>,
    x: R,
    period: usize,
}

impl<R: Real + Argument<Real = R>> Returns<'_, R> {
    /// By how much it does not, and the derivative of that. Upsilon is not differentiated at the point itself: there it may
    /// have no derivative.
    fn missed(&self, mu: R) -> (R, R) {
        let Family { universal, slope } = *self.family;
        let mut value = self.family.next(self.x, mu);
        let mut by_mu = R::ONE;
        for _ in 1..self.period {
            let at = universal.at(value);
            by_mu = R::ONE + slope * at.derivative * by_mu;
            value = slope * at.value + mu;
        }
        (value - self.x, by_mu)
    }
}

impl<R: Real + Argument<Real = R>> Equations<R> for Returns<'_, R> {
    type Left = core::convert::Infallible;

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Self::Left> {
        let (residual, slope) = self.missed(at[0]);
        Ok(Linearised {
            residual: vec![residual],
            jacobian: Matrix::from_rows(&[vec![slope]]),
        })
    }

    fn size(&self, _: &[R], correction: &[R]) -> f64 {
        (correction[0] / self.x).abs().to_f64()
    }
}
