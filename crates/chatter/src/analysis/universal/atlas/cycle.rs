//! Periodic orbits as a problem to be continued in mu.

use super::super::argument::Argument;
use super::orbit::{Family, Place};
use crate::analysis::continuation::{
    Held, ImageWithSlopes, Left, Linearised, MapOrbit, MapWithSlopes, Problem, Wrap, newton,
};
use crate::numerics::{Matrix, Real};

/// The points of a periodic orbit one after the other, then mu. Its functions: multiplier less 1, and less -1.
pub(super) struct Cycle<'a, R> {
    family: &'a Family<'a, R>,
    orbit: MapOrbit<'a, R>,
}

/// The multipliers whose differences from that of an orbit are the functions of a [`Cycle`].
const LIMITS: [f64; 2] = [1.0, -1.0];

impl<'a, R: Real + Argument<Real = R>> Family<'a, R> {
    /// The map, as cycles ask for it.
    pub(super) fn with_slopes(&self) -> impl Fn(&[R], &[R]) -> ImageWithSlopes<R> + '_ {
        |x, mu| {
            let at = self.universal.at(x[0]);
            let slopes = vec![self.slope * at.derivative, R::ONE];
            Ok((
                vec![self.slope * at.value + mu[0]],
                Matrix::from_rows(&[slopes]),
            ))
        }
    }

    /// The points of an orbit, and mu.
    pub(super) fn unknowns(&self, start: Place<R>, period: usize) -> Vec<R> {
        let mut unknowns = self.orbit(start, period);
        unknowns.push(start.mu);
        unknowns
    }
}

impl<'a, R: Real + Argument<Real = R>> Cycle<'a, R> {
    /// Of orbits with as many points as these unknowns have.
    pub(super) fn new(
        family: &'a Family<'a, R>,
        map: &'a MapWithSlopes<'a, R>,
        unknowns: &[R],
    ) -> Self {
        let points = &unknowns[..unknowns.len() - 1];
        let sizes: Vec<f64> = points.iter().map(|x| x.abs().to_f64()).collect();
        let orbit = MapOrbit::with_sizes(map, 1, sizes, &[unknowns[0].abs().to_f64()]);
        Self { family, orbit }
    }

    /// The multiplier at a point of the curve.
    pub(super) fn multiplier(&self, at: &[R]) -> R {
        self.family.multiplier(&at[..at.len() - 1])
    }

    /// The orbit with multiplier 1 or -1 near one; with what is left of that equation.
    pub(super) fn with_multiplier(&mut self, limit: f64, near: &[R]) -> Option<(Place<R>, R)> {
        let index = LIMITS.iter().position(|&known| known == limit)?;
        let mut held = Held::monitor(self, index);
        let found = newton(&mut held, near, &[]).ok()?;
        let left = self.multiplier(&found.at) - R::splat(limit);
        Some((place(&found.at), left))
    }
}

/// The first point of a cycle, and mu.
pub(super) fn place<R: Real>(at: &[R]) -> Place<R> {
    Place {
        x: at[0],
        mu: at[at.len() - 1],
    }
}

impl<R: Real + Argument<Real = R>> Problem<R> for Cycle<'_, R> {
    fn unknowns(&self) -> usize {
        self.orbit.unknowns()
    }

    fn parameters(&self) -> usize {
        self.orbit.parameters()
    }

    fn scales(&self) -> &[f64] {
        self.orbit.scales()
    }

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        self.orbit.evaluate(at)
    }

    fn monitor(&mut self, index: usize, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let Family { universal, slope } = *self.family;
        let points = &at[..at.len() - 1];
        let factors: Vec<R> = (points.iter())
            .map(|&x| slope * universal.at(x).derivative)
            .collect();
        let without = |k: usize| {
            let others = factors.iter().enumerate().filter(|(i, _)| *i != k);
            others.fold(R::ONE, |product, (_, &factor)| product * factor)
        };
        let change = |(k, &x): (usize, &R)| {
            let bend = if x > R::ZERO {
                slope * universal.curvature(x)
            } else {
                R::ZERO
            };
            bend * without(k)
        };
        let mut gradient: Vec<R> = points.iter().enumerate().map(change).collect();
        gradient.push(R::ZERO);
        let product = factors.iter().fold(R::ONE, |product, &x| product * x);
        Ok((product - R::splat(LIMITS[index]), gradient))
    }

    fn wrap(&self) -> Wrap {
        self.orbit.wrap()
    }
}
