//! A family of periodic orbits, followed through its stable part to either end.

use super::super::argument::Argument;
use super::cycle::{Cycle, place};
use super::orbit::{Family, Place};
use crate::analysis::continuation::{Curve, Settings, Station, tangent};
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

/// By how much the multiplier may change in a step.
const LARGEST_CHANGE: f64 = 0.3;
/// Steps, relative to x, that are too long and too short to be tried.
const SETTINGS: Settings = Settings {
    first_step: 1e-2,
    longest_step: 0.1,
    shortest_step: 1e-13,
};
/// More steps than any family takes whose points do not come to a lap's end.
const STEPS: usize = 400;
/// The halves of an orbit have met where they are this much nearer to each other than a step before.
const MET: f64 = 1e-6;

impl<R: Real + Argument<Real = R>> Family<'_, R> {
    fn laps(&self, points: &[R]) -> Vec<i64> {
        let word = self.word(points);
        word.iter().map(|branch| branch.lap).collect()
    }

    /// Follows the family of a stable orbit of some period, starting towards larger x (or smaller).
    pub(super) fn follow(
        &self,
        from: Place<R>,
        towards: f64,
        period: usize,
    ) -> Option<Followed<R>> {
        let start = self.unknowns(from, period);
        let laps = self.laps(&start[..period]);
        let half = period / 2;
        let twice = period.is_multiple_of(2) && laps[..half] == laps[half..];
        let parted = |at: &[R]| at[0] - at[half];
        let map = self.with_slopes();
        let mut cycle = Cycle::new(self, &map, &start);
        let mut curve = Curve::new(self.beginning(&mut cycle, start, towards)?, SETTINGS);
        let mut passed_zero = false;
        for _ in 0..STEPS {
            let here = curve.station.clone();
            let multiplier = cycle.multiplier(&here.at);
            let next = loop {
                let Ok((there, step)) = curve.next(&mut cycle) else {
                    break None;
                };
                let reached = cycle.multiplier(&there.at);
                let change = (reached - multiplier).abs().to_f64();
                if self.laps(&there.at[..period]) == laps && change <= LARGEST_CHANGE {
                    break Some((there, reached));
                }
                curve.step = 0.5 * step;
                if curve.step < SETTINGS.shortest_step {
                    break None;
                }
            };
            let Some((there, reached)) = next else {
                return Some(Followed {
                    end: End::Border(place(&here.at)),
                    passed_zero,
                });
            };
            if twice {
                let (a, b) = (parted(&here.at), parted(&there.at));
                // The step goes past the point where the halves meet, or from there on along the shorter orbit.
                if (a > R::ZERO) != (b > R::ZERO) || b.abs() < R::splat(MET) * a.abs() {
                    let middle = Place {
                        x: here.at[0] - a * R::splat(0.5),
                        mu: here.at[period],
                    };
                    let near = self.unknowns(middle, half);
                    let mut shorter = Cycle::new(self, &map, &near);
                    let (at, left) = shorter.with_multiplier(-1.0, &near)?;
                    return Some(Followed {
                        end: End::Doubled(at, left),
                        passed_zero,
                    });
                }
            }
            for limit in [1.0, -1.0] {
                let exact = R::splat(limit);
                if (reached - exact) * exact > R::ZERO {
                    let share = (exact - multiplier) / (reached - multiplier);
                    let guess: Vec<R> = (here.at.iter().zip(&there.at))
                        .map(|(&a, &b)| a + (b - a) * share)
                        .collect();
                    let (at, left) = cycle.with_multiplier(limit, &guess)?;
                    let end = if limit > 0.0 {
                        End::Fold(at, left)
                    } else {
                        End::PeriodDoubling(at, left)
                    };
                    return Some(Followed { end, passed_zero });
                }
            }
            passed_zero |= multiplier != R::ZERO && (multiplier > R::ZERO) != (reached > R::ZERO);
            curve.moves(there);
        }
        None
    }

    /// Where a family is begun to be followed, towards larger x or smaller.
    fn beginning(&self, cycle: &mut Cycle<'_, R>, at: Vec<R>, towards: f64) -> Option<Station<R>> {
        let mut along = vec![R::ZERO; at.len()];
        along[0] = R::splat(towards);
        Some(Station {
            tangent: tangent(cycle, &at, &along).ok()?,
            at,
            residual: 0.0,
            correction: 0.0,
            orientation: 1.0,
        })
    }
}
