//! A family of periodic orbits, followed through its stable part to either end.

use super::super::argument::Argument;
use super::orbit::{Family, Place};
use crate::numerics::Real;

/// Where the stable part of a family ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum End<R> {
    /// Multiplier 1, with what is left of that equation.
    Fold(Place<R>, R),
    /// Multiplier -1.
    PeriodDoubling(Place<R>, R),
    /// The orbits' two halves meet: multiplier -1 of the orbit with half the period.
    Doubled(Place<R>, R),
    /// A point of the orbit came to the end of its lap near this place.
    Border(Place<R>),
}

/// A followed family.
#[derive(Clone, Copy, Debug)]
pub(super) struct Followed<R> {
    pub end: End<R>,
    /// Whether there was a superstable orbit on the way.
    pub passed_zero: bool,
}

/// By how much the multiplier is to change in a step, and may.
const CHANGE: f64 = 0.1;
const LARGEST_CHANGE: f64 = 0.3;
/// Steps, relative to x, that are too long and too short to be tried.
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-13;
/// More steps than any family takes whose points do not come to a lap's end.
const STEPS: usize = 400;
/// Newton's steps back to the family.
const CORRECTIONS: usize = 12;
/// A correction below this part of the step leaves the point on the family as well as its use demands.
const LARGEST_SLIP: f64 = 1e-10;
/// The halves of an orbit have met where they are this much nearer to each other than a step before.
const MET: f64 = 1e-6;

/// A point of the family with its tangent and multiplier.
#[derive(Clone, Copy)]
struct Station<R> {
    at: Place<R>,
    /// Unit tangent.
    tangent: (R, R),
    multiplier: R,
    /// Change of the multiplier along the tangent.
    rate: R,
}

impl<R: Real + Argument<Real = R>> Family<'_, R> {
    fn laps(&self, at: Place<R>, period: usize) -> Vec<i64> {
        let word = self.word(&self.orbit(at, period));
        word.iter().map(|branch| branch.lap).collect()
    }

    fn station(&self, at: Place<R>, period: usize, along: (R, R)) -> Option<Station<R>> {
        let jet = self.jet(at, period);
        let (a, b) = (jet.by_mu, R::ONE - jet.by_start);
        let mut size = (a * a + b * b).sqrt();
        if a * along.0 + b * along.1 < R::ZERO {
            size = -size;
        }
        let tangent = (a / size, b / size);
        let rate = jet.by_start_twice * tangent.0 + jet.by_start_and_mu * tangent.1;
        let finite = tangent.0.is_finite() && tangent.1.is_finite() && rate.is_finite();
        finite.then_some(Station {
            at,
            tangent,
            multiplier: jet.by_start,
            rate,
        })
    }

    /// The point of the family at this distance along the tangent.
    fn step(&self, from: &Station<R>, distance: R, period: usize) -> Option<Place<R>> {
        let (tx, tmu) = from.tangent;
        let mut at = Place {
            x: from.at.x + distance * tx,
            mu: from.at.mu + distance * tmu,
        };
        for _ in 0..CORRECTIONS {
            let jet = self.jet(at, period);
            let (g, g_x) = (jet.x - at.x, jet.by_start - R::ONE);
            // Orthogonal to the tangent.
            let along = -g / (g_x * -tmu + jet.by_mu * tx);
            at.x -= along * tmu;
            at.mu += along * tx;
            if !along.is_finite() {
                return None;
            }
            if along.abs() <= distance.abs() * R::splat(LARGEST_SLIP) {
                return Some(at);
            }
        }
        None
    }

    /// Follows the family of a stable orbit of some period, starting towards larger x (or smaller).
    pub(super) fn follow(
        &self,
        from: Place<R>,
        towards: f64,
        period: usize,
    ) -> Option<Followed<R>> {
        let laps = self.laps(from, period);
        let half = period / 2;
        let twice = period.is_multiple_of(2) && laps[..half] == laps[half..];
        let parted = |at: Place<R>| at.x - self.orbit(at, half + 1)[half];
        let mut here = self.station(from, period, (R::splat(towards), R::ZERO))?;
        let mut passed_zero = false;
        let mut longest = LONGEST * from.x.to_f64();
        for _ in 0..STEPS {
            let wanted = CHANGE / here.rate.abs().to_f64();
            let mut distance = wanted.min(longest);
            let next = loop {
                if distance < SHORTEST * here.at.x.to_f64().abs() {
                    break None;
                }
                let there = self.step(&here, R::splat(distance), period).and_then(|at| {
                    let station = self.station(at, period, here.tangent)?;
                    let change = (station.multiplier - here.multiplier).abs();
                    let same = self.laps(at, period) == laps;
                    (same && change.to_f64() <= LARGEST_CHANGE).then_some(station)
                });
                if there.is_some() {
                    break there;
                }
                distance *= 0.5;
            };
            let Some(there) = next else {
                return Some(Followed {
                    end: End::Border(here.at),
                    passed_zero,
                });
            };
            longest = 2.0 * distance;
            if twice {
                let (a, b) = (parted(here.at), parted(there.at));
                // The step goes past the point where the halves meet, or from there on along the shorter orbit.
                if (a > R::ZERO) != (b > R::ZERO) || b.abs() < R::splat(MET) * a.abs() {
                    let middle = Place {
                        x: here.at.x - a * R::splat(0.5),
                        mu: here.at.mu,
                    };
                    let (at, left) = self.with_multiplier(-R::ONE, middle, half)?;
                    return Some(Followed {
                        end: End::Doubled(at, left),
                        passed_zero,
                    });
                }
            }
            let zero = here.multiplier != R::ZERO
                && (here.multiplier > R::ZERO) != (there.multiplier > R::ZERO);
            for limit in [R::ONE, -R::ONE] {
                if (there.multiplier - limit) * limit > R::ZERO {
                    let share = (limit - here.multiplier) / (there.multiplier - here.multiplier);
                    let guess = Place {
                        x: here.at.x + (there.at.x - here.at.x) * share,
                        mu: here.at.mu + (there.at.mu - here.at.mu) * share,
                    };
                    let (at, left) = self.with_multiplier(limit, guess, period)?;
                    let end = if limit > R::ZERO {
                        End::Fold(at, left)
                    } else {
                        End::PeriodDoubling(at, left)
                    };
                    return Some(Followed { end, passed_zero });
                }
            }
            passed_zero |= zero;
            here = there;
        }
        None
    }
}
