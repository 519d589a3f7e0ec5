//! One flight and impact near release: g, its inverse, and the factor h of nu (MATH.md (3)-(6)).

use super::constants::Constants;
use crate::numerics::Real;

/// The graze: u = 3/8, where the flight ends with zero rate.
pub const GRAZE: f64 = 0.375;

/// The map u -> g(u) of one flight and impact, and its inverse.
#[derive(Clone, Copy, Debug)]
pub struct ChatterMap<R> {
    restitution: R,
}

/// One step back along the chatter sequence: u_{i+1} = g^-1(u_i) and what comes with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackStep<R> {
    /// sqrt(3 r (8 u + 3 r)) at the old point.
    pub root: R,
    /// h at the new point.
    pub h: R,
}

/// How a step back from u differs from the one at u*: both vanish with u - u*, and keep its digits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure<R> {
    /// 1 - h / lambda.
    h: R,
    /// (root - root*) / (2 root*).
    root: R,
}

impl<R: Real> Departure<R> {
    /// h(g^-1(u)) / lambda.
    pub(super) fn product(&self) -> R {
        R::ONE - self.h
    }

    /// (g^-1(u) - g^-1(v)) / (u - v) over eta, from the departures of u and v. Exact: no digits are lost where u and v
    /// are close, or where both are close to u* and the result to one.
    pub(super) fn contraction(&self, other: &Self, lambda: R) -> R {
        let share = lambda / (R::ONE + lambda + lambda);
        (R::ONE - self.h) * (R::ONE - other.h) * (R::ONE - (self.h + other.h) * share)
            / (R::ONE + self.root + other.root)
    }

    /// The departure of u* itself.
    pub(super) fn none() -> Self {
        Self {
            h: R::ZERO,
            root: R::ZERO,
        }
    }
}

impl<R: Real> ChatterMap<R> {
    /// The map for the restitution of `constants`.
    pub fn new(constants: &Constants<R>) -> Self {
        Self {
            restitution: constants.restitution,
        }
    }

    /// s(u) = sqrt(1 - 8 u / 3) in [0, 1]; zero at the graze u = 3/8, NaN beyond it.
    pub fn flight_root(&self, u: R) -> R {
        (R::ONE - R::splat(8.0) * u / R::splat(3.0)).sqrt()
    }

    /// g(u): u after the next impact. Infinite at the pole u = 1/3, NaN beyond u = 3/8 where no impact follows.
    pub fn g(&self, u: R) -> R {
        let s = self.flight_root(u);
        let pole = R::ONE - R::splat(3.0) * s;
        // 1 - s = (8 u / 3) / (1 + s) keeps the digits of a small u.
        R::splat(8.0) * self.restitution * s * u / ((R::ONE + s) * pole * pole)
    }

    /// h(u) = (3 s - 1) / 2: the factor of nu over one flight and impact; zero at the pole of g, negative beyond.
    pub fn h(&self, u: R) -> R {
        (R::splat(3.0) * self.flight_root(u) - R::ONE) * R::splat(0.5)
    }

    pub(super) fn back_step(&self, u: R) -> BackStep<R> {
        let r = self.restitution;
        let three_r = R::splat(3.0) * r;
        let root = (three_r * (R::splat(8.0) * u + three_r)).sqrt();
        BackStep {
            root,
            h: (r + root) / (R::splat(4.0) * (R::splat(3.0) * u + r)),
        }
    }

    /// The departure of the step back from u = u* + `excess`, `fixed` being the step at u*.
    pub(super) fn departure(&self, u: R, excess: R, fixed: &BackStep<R>) -> Departure<R> {
        let step = self.back_step(u);
        let scaled = R::splat(12.0) * excess / (step.root + fixed.root);
        Departure {
            h: scaled * step.h,
            root: scaled * self.restitution / fixed.root,
        }
    }

    /// g^-1(u) in [0, 1/3) for u >= 0: the u of the impact before, equation (6) without its cancellations.
    pub fn inverse(&self, u: R) -> R {
        let step = self.back_step(u);
        let three_r = R::splat(3.0) * self.restitution;
        // u' = (1 - h)(2 + h) / 6 with 1 - h = 12 u / (12 u + 3 r + root).
        R::splat(2.0) * u * (R::splat(2.0) + step.h) / (R::splat(12.0) * u + three_r + step.root)
    }
}
