//! Where a curve of folds or doublings ends with a stay that comes to nothing, and none leads on without it: beside a jump of the force
//! multipliers grow beyond all bounds as the stay becomes short, unless what is in front of that vanishes. On the curve it vanishes with the
//! stay, at a point of the curve of touches that is not one of the same curve without the stay.
//!
//! The equations are singular there: a stay of no time at all solves them all along the curve of touches. But the curve is a smooth
//! function of how long the stay takes, so that its end is extrapolated from where that is not short.

use super::follower::{Follower, Stop};
use crate::analysis::continuation::{Condition as Row, Curve, Problem, Station, newton};
use crate::analysis::periodic::branch::{End, SpecialKind, VANISHED};
use crate::analysis::periodic::condition::{Bordered, Condition};

/// The longest of the stays that are extrapolated from, in parts of the period; each of the others takes half as long as the one before.
const LONGEST: f64 = 1e-2;
const STAYS: i32 = 13;
/// So many of them at a time: the polynomial goes through these.
const AT_A_TIME: usize = 6;
/// A stay grows by this factor at most from one solution to the next.
const GROWS: f64 = 4.0;
/// What is known no better, in parts of the solution's size, is no end of the curve.
const KNOWN: f64 = 1e-6;

/// The value at zero of the polynomial through such points.
fn at_zero(points: &[(f64, f64)]) -> f64 {
    let mut all: Vec<f64> = points.iter().map(|&(_, y)| y).collect();
    for order in 1..points.len() {
        for i in 0..points.len() - order {
            let (near, far) = (points[i + order].0, points[i].0);
            all[i] = (far * all[i + 1] - near * all[i]) / (far - near);
        }
    }
    all.first().copied().unwrap_or(f64::NAN)
}

impl Follower {
    /// The end of the curve, where a stay has all but come to nothing at a station on its way.
    pub(super) fn ends_with_stay(
        &mut self,
        curve: &Curve,
        (station, bordered): (&Station, &Bordered),
    ) -> Option<Stop> {
        if !matches!(self.condition, Condition::Singular(_)) {
            return None;
        }
        self.shooting.evaluate(&station.at).ok()?;
        let first = self.shooting.shortest_stay()?;
        let place = self.shooting.duration_place(self.shooting.after(first))?;
        if station.at[place] > VANISHED * self.shooting.period() {
            return None;
        }
        let (at, off) = self.without_time(&curve.station, place, bordered)?;
        // Told of the orbit without the stay.
        self.shooting.evaluate(&station.at).ok()?;
        let (touching, start, index) = self.shooting.without_way_back(&at, first).ok()?;
        let (mut shorter, guess, _) = touching.without_event(&start, index).ok()?;
        let held = Row::held(&guess, guess.len() - shorter.parameters()..guess.len());
        let found = newton(&mut shorter, &guess, &held).ok()?;
        let touch = Station {
            tangent: vec![0.0; found.at.len()],
            at: found.at,
            residual: found.residual,
            correction: found.correction,
            orientation: 0.0,
        };
        self.shooting = shorter;
        self.sided = None;
        self.note(SpecialKind::Touch, &touch, (off, 1.0));
        Some(Stop::End(End::At(SpecialKind::Touch)))
    }

    /// The unknowns where a stay takes no time any more, and what they are off by, in parts of their sizes.
    fn without_time(
        &mut self,
        from: &Station,
        place: usize,
        bordered: &Bordered,
    ) -> Option<(Vec<f64>, f64)> {
        let period = self.shooting.period();
        let longest = LONGEST * period;
        let slope = from.tangent[place];
        // The way up to the longest one, along the curve.
        let mut lasts = from.at[place];
        let mut along: Vec<f64> = from.tangent.iter().map(|by| by / slope).collect();
        let (mut at, mut known) = (from.at.clone(), bordered.clone());
        while lasts != longest {
            let next = longest.min(GROWS * lasts.max(VANISHED * period));
            let by = next - lasts;
            let guess: Vec<f64> = at.iter().zip(&along).map(|(x, s)| x + by * s).collect();
            let (found, anew) = self.with_lasting(&guess, (place, next), &known)?;
            along = (found.iter().zip(&at)).map(|(a, b)| (a - b) / by).collect();
            (at, known, lasts) = (found, anew, next);
        }
        let mut all = vec![(lasts, at)];
        for halves in 1..STAYS {
            let next = longest * 0.5_f64.powi(halves);
            let (lasts, at) = all.last()?;
            let guess: Vec<f64> = (at.iter().zip(&along))
                .map(|(x, s)| x + (next - lasts) * s)
                .collect();
            let Some((found, anew)) = self.with_lasting(&guess, (place, next), &known) else {
                break;
            };
            along = (found.iter().zip(at))
                .map(|(a, b)| (a - b) / (next - lasts))
                .collect();
            known = anew;
            all.push((next, found));
        }
        let scales = self.shooting.scales().to_vec();
        let extrapolated = |part: &[(f64, Vec<f64>)]| -> Vec<f64> {
            let value = |i: usize| {
                let points: Vec<(f64, f64)> = part.iter().map(|(x, y)| (*x, y[i])).collect();
                at_zero(&points)
            };
            (0..scales.len()).map(value).collect()
        };
        let apart = |one: &[f64], other: &[f64]| {
            let parts = one.iter().zip(other).zip(&scales);
            parts.fold(0.0_f64, |most, ((a, b), scale)| {
                most.max(((a - b) / scale).abs())
            })
        };
        // The longest tells what the polynomial leaves out, the shortest what is rounding.
        let ends = all.windows(AT_A_TIME).map(|part| {
            let end = extrapolated(part);
            let fewer = [&part[1..], &part[..part.len() - 1]].map(extrapolated);
            let off = fewer.iter().map(|other| apart(other, &end));
            let off = off.fold(0.0, f64::max);
            (end, off)
        });
        let ends: Vec<(Vec<f64>, f64)> = ends.collect();
        let least = (0..ends.len()).min_by(|&a, &b| ends[a].1.total_cmp(&ends[b].1))?;
        let (mut end, off) = ends[least].clone();
        // Chance makes one difference small: those beside it have to agree.
        let beside = [least.checked_sub(1), Some(least + 1)];
        let beside = beside.into_iter().flatten().filter_map(|k| ends.get(k));
        let off = beside.fold(off, |most, (other, _)| most.max(apart(other, &end)));
        end[place] = 0.0;
        (off <= KNOWN).then_some((end, off))
    }

    /// The curve where a stay takes so long.
    fn with_lasting(
        &mut self,
        guess: &[f64],
        (place, lasts): (usize, f64),
        known: &Bordered,
    ) -> Option<(Vec<f64>, Bordered)> {
        let row = Row::fixed(guess.len(), place, lasts);
        let rows = core::slice::from_ref(&row);
        let found = newton(&mut known.of(&mut self.shooting), guess, rows).ok()?;
        let anew = (self.condition).near(&mut self.shooting, &found.at, Some(known));
        Some((found.at, anew.ok()?))
    }
}
