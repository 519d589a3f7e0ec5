//! The period doublings of the fixed point on a lap, to their accumulation.

use super::super::argument::Argument;
use super::super::error::UniversalError;
use super::super::evaluate::Universal;
use super::EdgeKind;
use super::periodic::Atlas;
use crate::numerics::Real;

/// Superstable orbits of period 1, 2, 4, … on one lap, and where they accumulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Cascade<R> {
    /// The lap.
    pub lap: i64,
    /// mu of the superstable orbits of period 1, 2, 4, ….
    pub superstable: Vec<R>,
    /// The latest ratio of distances between them: towards Feigenbaum's constant 4.669….
    pub ratio: R,
    /// Where they accumulate: chaos begins there.
    pub accumulation: R,
    /// How far that may be off.
    pub error: R,
}

/// Feigenbaum's constant.
const FEIGENBAUM: f64 = 4.669_201_609_102_99;
/// Ratios of distances that the first members of a cascade may have.
const RATIOS: core::ops::Range<f64> = 2.0..12.0;
/// Doublings followed: the distance shrinks to 1e-7 of the first.
const DOUBLINGS: usize = 10;
/// With fewer than that a cascade is taken to be broken off, by an orbit of it that comes to a lap's end.
const FEWEST: usize = 6;
/// Starts of Newton's method, as ratios of distances.
const GUESSES: [f64; 5] = [1.0, 0.8, 1.25, 0.65, 1.5];

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// The cascade of period doublings that begins with the fixed point on a lap; `None` where the period doubling is
    /// missing or subcritical, and where the cascade breaks off because an
    /// orbit of it comes to a lap's end.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn cascade(&self, slope: R, lap: i64) -> Result<Option<Cascade<R>>, UniversalError> {
        UniversalError::check_slope(slope)?;
        let double = self.double()?;
        Ok(Atlas::new(self, slope, &double).cascade(lap))
    }
}

impl<R: Real + Argument<Real = R>> Atlas<'_, R> {
    pub(super) fn cascade(&self, lap: i64) -> Option<Cascade<R>> {
        let first = self.fixed(lap);
        let (twice, _) = self.superstable(lap, 2);
        let doubling = first.edge(EdgeKind::PeriodDoubling)?;
        let second = twice.iter().find(|window| {
            window
                .edge(EdgeKind::DoubledFrom)
                .is_some_and(|at| (at.mu - doubling.mu).abs() <= R::splat(SAME) * doubling.mu.abs())
        })?;
        let start = first.superstable?;
        let mut found = vec![start.mu, second.superstable?.mu];
        let mut ratio = FEIGENBAUM;
        for doublings in 2..=DOUBLINGS {
            let (last, before) = (found[doublings - 1], found[doublings - 2]);
            let gap = last - before;
            let next = GUESSES.iter().find_map(|guess| {
                let from = last + gap / R::splat(guess * ratio);
                let (place, _) = self.family.recurrent(start.x, from, 1 << doublings)?;
                let now = (gap / (place.mu - last)).to_f64();
                RATIOS.contains(&now).then_some((place.mu, now))
            });
            let Some((mu, now)) = next else {
                break;
            };
            found.push(mu);
            ratio = now;
        }
        if found.len() <= FEWEST {
            return None;
        }
        let last = found.len() - 1;
        let gap = found[last] - found[last - 1];
        let rest = gap / R::splat(FEIGENBAUM - 1.0);
        Some(Cascade {
            lap,
            accumulation: found[last] + rest,
            // The ratio is off by so much at the end of the list.
            error: rest.abs() * R::splat((ratio / FEIGENBAUM - 1.0).abs().max(R::ROUNDOFF)),
            ratio: R::splat(ratio),
            superstable: found,
        })
    }
}

/// Two places of the same period doubling agree to this.
const SAME: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};

    #[test]
    fn period_doublings_are_universal() {
        for (r, slope, lap) in [
            (0.8, 1.0, 8),
            (0.8, 1.0, 20),
            (0.3, 1.0, 3),
            (0.8, -1.0, 20),
        ] {
            let universal = Universal::new(DoubleDouble::from(r)).unwrap();
            let cascade = universal
                .cascade(DoubleDouble::from(slope), lap)
                .unwrap()
                .unwrap();
            assert_eq!(
                cascade.superstable.len(),
                DOUBLINGS + 1,
                "{r} {slope} {lap}"
            );
            let off = cascade.ratio.to_f64() / FEIGENBAUM - 1.0;
            assert!(off.abs() < 1e-4, "{r} {slope} {lap} {off}");
            // Without its last two members the cascade ends at the same place.
            let list = &cascade.superstable[..DOUBLINGS - 1];
            let gap = list[DOUBLINGS - 2] - list[DOUBLINGS - 3];
            let shorter = list[DOUBLINGS - 2] + gap / DoubleDouble::from(FEIGENBAUM - 1.0);
            let apart = (shorter - cascade.accumulation).abs();
            assert!(apart < gap.abs() * DoubleDouble::from(1e-4));
            assert!(cascade.error < apart);
        }
        // Broken off, and subcritical.
        let universal = Universal::new(DoubleDouble::from(0.8)).unwrap();
        for lap in [45, 60] {
            assert_eq!(universal.cascade(DoubleDouble::ONE, lap), Ok(None));
        }
    }
}
