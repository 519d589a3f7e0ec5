//! Orbits with derivatives, and Newton's method on them.

use super::super::argument::Argument;
use super::super::evaluate::Universal;
use crate::numerics::Real;

/// On which branch a point is: the lap, and whether K Upsilon rises there (Upsilon does, that is).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Branch {
    pub lap: i64,
    pub rising: bool,
}

/// The end of an orbit of F, differentiated by its start and by mu.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<R> {
    pub x: R,
    pub by_start: R,
    pub by_mu: R,
    pub by_start_twice: R,
    pub by_start_and_mu: R,
}

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

/// Newton's steps that reach rounding error from any start that it reaches it from at all.
const STEPS: usize = 40;
/// A step below this many roundoffs is the last one.
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
                // Complete chatter has no lap.
                lap: if lap.is_finite() {
                    lap as i64
                } else {
                    i64::MAX
                },
                rising: at.derivative >= R::ZERO,
            }
        };
        points.iter().map(branch).collect()
    }

    /// `steps` steps from a point.
    pub(super) fn jet(&self, start: Place<R>, steps: usize) -> Jet<R> {
        let mut jet = Jet {
            x: start.x,
            by_start: R::ONE,
            by_mu: R::ZERO,
            by_start_twice: R::ZERO,
            by_start_and_mu: R::ZERO,
        };
        for _ in 0..steps {
            let at = self.universal.at(jet.x);
            let first = self.slope * at.derivative;
            let second = if jet.x > R::ZERO {
                self.slope * self.universal.curvature(jet.x)
            } else {
                R::ZERO
            };
            jet = Jet {
                x: self.slope * at.value + start.mu,
                by_start: first * jet.by_start,
                by_mu: R::ONE + first * jet.by_mu,
                by_start_twice: second * jet.by_start * jet.by_start + first * jet.by_start_twice,
                by_start_and_mu: second * jet.by_start * jet.by_mu + first * jet.by_start_and_mu,
            };
        }
        jet
    }

    /// mu at which `x` returns to itself after `period` steps, by Newton's method from `mu`; with what is left of the
    /// equation.
    pub(super) fn recurrent(&self, x: R, mu: R, period: usize) -> Option<(Place<R>, R)> {
        // The first step must not ask for derivatives: x may be where Upsilon has none.
        let residual = |mu: R| {
            let start = Place {
                x: self.next(x, mu),
                mu,
            };
            let mut value = start.x;
            let mut by_mu = R::ONE;
            for _ in 1..period {
                let at = self.universal.at(value);
                by_mu = R::ONE + self.slope * at.derivative * by_mu;
                value = self.slope * at.value + mu;
            }
            (value - x, by_mu)
        };
        let mut mu = mu;
        let mut best = None::<(R, R)>;
        for _ in 0..STEPS {
            let (value, by_mu) = residual(mu);
            let better = best.is_none_or(|(_, least)| value.abs() < least);
            if !better {
                break;
            }
            best = Some((mu, value.abs()));
            mu -= value / by_mu;
        }
        let (mu, _) = best?;
        let left = residual(mu).0;
        let good = left.abs() <= R::splat(1e3 * R::ROUNDOFF).sqrt() * x.abs();
        good.then_some((Place { x, mu }, left))
    }

    /// The point of period `period` with this multiplier, by Newton's method from `from`; with what is left of the second
    /// equation, multiplier less the one sought.
    pub(super) fn with_multiplier(
        &self,
        multiplier: R,
        from: Place<R>,
        period: usize,
    ) -> Option<(Place<R>, R)> {
        let mut at = from;
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let jet = self.jet(at, period);
            let (g, m) = (jet.x - at.x, jet.by_start - multiplier);
            let g_x = jet.by_start - R::ONE;
            let determinant = g_x * jet.by_start_and_mu - jet.by_mu * jet.by_start_twice;
            let dx = (jet.by_mu * m - jet.by_start_and_mu * g) / determinant;
            let dmu = (jet.by_start_twice * g - g_x * m) / determinant;
            let size = (dx / at.x).abs().max((dmu / at.x).abs()).to_f64();
            if !size.is_finite() {
                return None;
            }
            // The residual decides: steps at rounding level wander.
            if size <= DONE * R::ROUNDOFF || (size >= last && last < R::ROUNDOFF.sqrt()) {
                return Some((at, m));
            }
            last = size;
            at = Place {
                x: at.x + dx,
                mu: at.mu + dmu,
            };
        }
        None
    }
}
