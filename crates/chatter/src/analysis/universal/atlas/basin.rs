//! What is attracted by a periodic orbit.

use super::super::argument::Argument;
use super::super::error::UniversalError;
use super::super::evaluate::Universal;
use super::enclosure::Enclosing;
use super::search::covered;
use super::window::PeriodicWindow;
use crate::numerics::Real;

/// The basin of a window's orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basin {
    /// Where it was computed: at the superstable orbit, or in the middle of the window.
    pub mu: f64,
    /// The immediate basin: all z between these around the orbit's first point are attracted. Infinite where there is no end.
    pub from: f64,
    /// Its other end.
    pub to: f64,
    /// The part that is attracted of the interval that the orbits around the attractor cover.
    pub share: f64,
}

/// Points of that interval.
const POINTS: usize = 1000;
/// Iterates after which an orbit that has not come near is said to go elsewhere.
const LONGEST: usize = 3000;
/// Nearer than this, relative to x, is near.
const NEAR: f64 = 1e-7;
/// Steps outwards on each lap, and how many laps; an end is then found by halving.
const STEPS: f64 = 256.0;
const LAPS: usize = 24;
const HALVINGS: usize = 60;

struct Attraction<'a> {
    universal: &'a Universal<f64>,
    slope: f64,
    mu: f64,
    points: &'a [f64],
}

impl Attraction<'_> {
    fn holds(&self, start: f64) -> bool {
        let mut x = start;
        let first = self.points[0];
        for _ in 0..LONGEST {
            if (x - first).abs() <= NEAR * first.abs() {
                return true;
            }
            x = self.slope * self.universal.value(x) + self.mu;
        }
        false
    }

    /// The point a period later.
    fn after_period(&self, start: f64) -> f64 {
        self.points
            .iter()
            .fold(start, |x, _| self.slope * self.universal.value(x) + self.mu)
    }

    /// From the first point of the orbit outwards, to where `inside` ends.
    fn end(&self, way: f64, inside: impl Fn(f64) -> bool) -> f64 {
        let rest = self.universal.constants().one_minus_eta;
        let mut last = self.points[0];
        for _ in 0..(STEPS as usize * LAPS) {
            let next = last + way * rest / STEPS * last.abs();
            if !inside(next) {
                let mut outside = next;
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (last + outside);
                    if inside(middle) {
                        last = middle;
                    } else {
                        outside = middle;
                    }
                }
                return last;
            }
            last = next;
        }
        way * f64::INFINITY
    }

    /// Both ends of the immediate basin: points that return to themselves after a period, unstably, or come to such a
    /// point, or go elsewhere.
    fn immediate(&self) -> [f64; 2] {
        const WAYS: [f64; 2] = [-1.0, 1.0];
        let partners = WAYS.map(|way| {
            let moves_back = |x: f64| (self.after_period(x) - x) * way < 0.0;
            self.end(way, moves_back)
        });
        let between = |x: f64| {
            let image = self.after_period(x);
            partners[0] < image && image < partners[1] && self.holds(x)
        };
        let ends = WAYS.map(|way| self.end(way, between));
        [ends[0].max(partners[0]), ends[1].min(partners[1])]
    }
}

impl<R: Real + Argument<Real = R>> PeriodicWindow<R> {
    /// The basin of the orbit, in double precision. Ends of the immediate basin are looked for in steps of 1/256 of a lap:
    /// two of them within a step are not seen. `None` where the window has no interval of mu, or is
    /// too narrow for doubles.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn basin(
        &self,
        universal: &Universal<f64>,
        slope: f64,
    ) -> Result<Option<Basin>, UniversalError> {
        UniversalError::check_slope(slope)?;
        let Some((low, high)) = self.stable() else {
            return Ok(None);
        };
        let half = R::splat(0.5);
        let (mu, start) = match self.superstable {
            Some(at) => (at.mu, at.x),
            None => ((low + high) * half, self.edges[0].at.x),
        };
        let (mu, mut x) = (mu.to_f64(), start.to_f64());
        for _ in 0..LONGEST * self.period() {
            x = slope * universal.value(x) + mu;
        }
        // Onto the lap that the window is named after.
        for _ in 0..self.period() {
            if universal.at(x).lap == self.lap as f64 {
                break;
            }
            x = slope * universal.value(x) + mu;
        }
        let mut points = vec![x];
        for k in 1..self.period() {
            points.push(slope * universal.value(points[k - 1]) + mu);
        }
        let back = slope * universal.value(points[points.len() - 1]) + mu;
        if (back - x).abs() > NEAR * x.abs() {
            return Ok(None);
        }
        let attraction = Attraction {
            universal,
            slope,
            mu,
            points: &points,
        };
        let ends = attraction.immediate().map(|x| (x - mu) / slope);
        let around = covered(&Enclosing::new(universal), slope, mu, x);
        let inside = (0..POINTS).filter(|&k| {
            let part = (k as f64 + 0.5) / POINTS as f64;
            attraction.holds(around.low + (around.high - around.low) * part)
        });
        Ok(Some(Basin {
            mu,
            from: ends[0].min(ends[1]),
            to: ends[0].max(ends[1]),
            share: inside.count() as f64 / POINTS as f64,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::DoubleDouble;

    /// The immediate basin of a fixed point born at a fold ends at its unstable partner.
    #[test]
    fn a_basin_ends_at_the_unstable_partner() {
        let double = Universal::new(0.8).unwrap();
        let fine = Universal::new(DoubleDouble::from(0.8)).unwrap();
        for lap in [5, 8, 20] {
            let atlas = fine
                .periodic_windows(DoubleDouble::ONE, lap..=lap, 1..=1)
                .unwrap();
            let window = &atlas.windows[0];
            let basin = window.basin(&double, 1.0).unwrap().unwrap();
            let fold = window.edges[0].at.x.to_f64();
            // x = mu + Upsilon(x) between the lap's beginning and the fold.
            let begin = double.window_of(1.0, lap + 1).grazing.x;
            let off = |x: f64| double.value(x) + basin.mu - x;
            let partner = crate::numerics::root_between(off, begin, fold).unwrap();
            let found = basin.from + basin.mu;
            assert!(
                (found - partner).abs() < 1e-12 * partner,
                "{lap} {found} {partner}"
            );
            // The other end has the same image.
            let image = double.value(basin.to + basin.mu) + basin.mu;
            assert!(
                (image - partner).abs() < 1e-10 * partner,
                "{lap} {image} {partner}"
            );
            assert!(basin.share > 0.2 && basin.share <= 1.0);
        }
    }
}
