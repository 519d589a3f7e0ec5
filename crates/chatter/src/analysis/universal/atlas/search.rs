//! Where orbits are looked for, and all mu at which a point is periodic.

use super::super::argument::Argument;
use super::super::windows::Located;
use super::enclosure::{Enclosing, Interval};
use super::orbit::Place;
use super::periodic::Atlas;
use super::recurrence::Recurrence;
use crate::numerics::Real;
use crate::numerics::root_between;

/// Laps that an orbit may extend over to either side of the point in question.
const WIDEST: i64 = 24;
/// Iterations in which an interval has grown to what its orbits cover.
const GROWTH: usize = 64;
/// Two points of an orbit nearer than this, relative, are one: the period is a smaller one.
const SAME: f64 = 1e-9;

impl<R: Real + Argument<Real = R>> Atlas<'_, R> {
    /// How many laps to either side the orbits near the end of a lap extend, where its fixed point grazes.
    pub(super) fn reach(&self, lap: i64) -> i64 {
        let universal = self.enclosing.universal;
        let slope = self.family.slope.to_f64();
        let graze = universal.window_of(slope, lap).grazing;
        let covered = covered(&self.enclosing, slope, graze.mu, graze.x);
        let laps_away = |x: f64| {
            let away = (universal.at(x).lap - lap as f64).abs();
            // Complete chatter is infinitely many laps away; an orbit that escapes has no lap at all.
            away.min(WIDEST as f64) as i64
        };
        laps_away(covered.low)
            .max(laps_away(covered.high))
            .min(WIDEST - 1)
            + 1
    }

    /// Where to look for orbits with a critical point on this lap.
    fn range(&self, lap: i64) -> Interval {
        let universal = self.enclosing.universal;
        let slope = self.family.slope.to_f64();
        let reach = self.reach(lap);
        let mut range = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        for lap in lap - reach..=lap + reach {
            let window = universal.window_of(slope, lap);
            for event in [window.superstable, window.grazing] {
                range = range.hull(Interval::point(event.mu));
            }
        }
        range
    }

    /// All mu at which a point is periodic with this period and no smaller one.
    pub(super) fn recurrences(
        &self,
        point: R,
        lap: i64,
        period: usize,
    ) -> (Vec<(Place<R>, R)>, usize) {
        let search = Recurrence {
            enclosing: &self.enclosing,
            slope: self.family.slope.to_f64(),
            point: point.to_f64(),
            period,
            beyond: self
                .enclosing
                .universal
                .window_of(1.0, lap - WIDEST)
                .grazing
                .x,
        };
        let found = search.all(self.range(lap));
        let places = found.brackets.iter().filter_map(|bracket| {
            let residual = |mu: f64| search.residual(mu);
            let mu = root_between(residual, bracket.low, bracket.high)?;
            let (place, left) = self.family.recurrent(point, R::splat(mu), period)?;
            let points = self.family.orbit(place, period);
            let again = points[1..].iter().any(|&x| {
                let apart = (x - place.x).abs();
                apart <= R::splat(SAME) * place.x.abs()
            });
            (!again).then_some((place, left))
        });
        (places.collect(), found.undecided)
    }

    pub(super) fn located(&self, place: Place<R>, residual: R) -> Located<R> {
        Located {
            mu: place.mu,
            x: place.x,
            z: self.family.universal.value(place.x),
            residual,
        }
    }
}

/// What the orbits cover that start at a point or between points so covered.
pub(super) fn covered(enclosing: &Enclosing<'_>, slope: f64, mu: f64, x: f64) -> Interval {
    let mut covered = Interval::point(x);
    for _ in 0..GROWTH {
        let (values, _) = enclosing.image(covered);
        let ends = [slope * values.low, slope * values.high].map(|value| value + mu);
        let image = Interval::new(ends[0].min(ends[1]), ends[0].max(ends[1]));
        covered = covered.hull(image);
    }
    covered
}
