//! Where a curve of folds or doublings ends with a stay that comes to nothing, and none leads on without it: beside a jump of the force
//! multipliers grow beyond all bounds as the stay becomes short, unless what is in front of that vanishes. On the curve it vanishes with the
//! stay, at a point of the curve of touches that is not one of the same curve without the stay.
//!
//! The equations are singular there: a stay of no time at all solves them all along the curve of touches. But the curve is a smooth
//! function of how long the stay takes, so that its end is extrapolated from where that is not short.

use super::extrapolated::at_zero;
use super::follower::{Follower, Stop};
use crate::analysis::continuation::{Condition as Row, Curve, Problem, Station, newton};
use crate::analysis::periodic::branch::{End, SpecialKind, VANISHED};
use crate::analysis::periodic::condition::{Bordered, Condition};

/// The longest of the stays that are extrapolated from, in parts of the period; each of the others takes half as long as the one before.
const LONGEST: f64 = 1e-2;
const STAYS: i32 = 13;
/// A stay grows by this factor at most from one solution to the next.
const GROWS: f64 = 4.0;
/// What is known no better, in parts of the solution's size, is no end of the curve.
pub(super) const KNOWN: f64 = 1e-6;

impl Follower {
    /// The end of the curve, where a stay has all but come to nothing at a station on its way.
    pub(super) fn ends_with_stay(
        &mut self,
        curve: &Curve,
        known: (&Station, &Bordered),
    ) -> Option<Stop> {
        self.ends_with_stay_within(VANISHED, curve, known)
    }

    /// The same where a step has led from a stay that becomes shorter to what is no orbit of the curve: long steps do before it is as short. That the
    /// curve goes on to where it takes no time is to show in what is extrapolated.
    pub(super) fn leaps_to_end_of_stay(
        &mut self,
        curve: &Curve,
        (station, bordered): (&Station, &Bordered),
    ) -> Option<Stop> {
        self.shooting.evaluate(&station.at).ok()?;
        let (_, place) = self.shooting.stay_within(&station.at, LONGEST)?;
        if station.tangent[place] >= 0.0 {
            return None;
        }
        self.ends_with_stay_within(LONGEST, curve, (station, bordered))
    }

    fn ends_with_stay_within(
        &mut self,
        part: f64,
        curve: &Curve,
        (station, bordered): (&Station, &Bordered),
    ) -> Option<Stop> {
        if !matches!(self.condition, Condition::Singular(_)) {
            return None;
        }
        self.shooting.evaluate(&station.at).ok()?;
        let (first, place) = self.shooting.stay_within(&station.at, part)?;
        let (at, off) = self.without_time(&curve.station, place, bordered)?;
        // Told of the orbit without the stay.
        self.shooting.evaluate(&station.at).ok()?;
        let (touching, start, index) = self.shooting.without_way_back(&at, first).ok()?;
        let (mut shorter, guess, _) = touching.without_event(&start, index).ok()?;
        let held = Row::held(&guess, guess.len() - shorter.parameters()..guess.len());
        let found = newton(&mut shorter, &guess, &held).ok()?;
        let no_way = vec![0.0; found.at.len()];
        let touch = Station::beginning(found, no_way);
        self.shooting = shorter;
        self.sided = None;
        self.note(SpecialKind::Touch, &touch, (off, 1.0));
        Some(Stop::End(End::At(SpecialKind::Touch)))
    }

    /// The unknowns where a stay takes no time any more, and what they are off by, in parts of their sizes.
    pub(super) fn without_time(
        &mut self,
        from: &Station,
        place: usize,
        bordered: &Bordered,
    ) -> Option<(Vec<f64>, f64)> {
        let period = self.shooting.period();
        let longest = LONGEST * period;
        let slope = from.tangent[place];
        // The way up to the longest one, along the curve.
        let mut here = Lasting {
            time: from.at[place],
            at: from.at.clone(),
            along: from.tangent.iter().map(|by| by / slope).collect(),
            bordered: bordered.clone(),
        };
        while here.time != longest {
            let next = longest.min(GROWS * here.time.max(VANISHED * period));
            // Other events may be nearer than that.
            let Some(longer) = self.on_to(&here, (place, next)) else {
                break;
            };
            here = longer;
        }
        let longest = here.time;
        let mut all = vec![here];
        for halves in 1..STAYS {
            let next = longest * 0.5_f64.powi(halves);
            match self.on_to(all.last()?, (place, next)) {
                Some(shorter) => all.push(shorter),
                None => break,
            }
        }
        let (times, all): (Vec<f64>, Vec<Vec<f64>>) =
            (all.into_iter().map(|lasting| (lasting.time, lasting.at))).unzip();
        let (mut end, off) = at_zero((&times, &all), self.shooting.scales())?;
        end[place] = 0.0;
        (off <= KNOWN).then_some((end, off))
    }

    /// On from where a stay takes one time to where it takes another.
    fn on_to(&mut self, from: &Lasting, (place, time): (usize, f64)) -> Option<Lasting> {
        let by = time - from.time;
        let parts = from.at.iter().zip(&from.along);
        let guess: Vec<f64> = parts.map(|(x, slope)| x + by * slope).collect();
        let row = Row::fixed(guess.len(), place, time);
        let rows = core::slice::from_ref(&row);
        let found = newton(&mut from.bordered.of(&mut self.shooting), &guess, rows).ok()?;
        let bordered = (self.condition).near(&mut self.shooting, &found.at, Some(&from.bordered));
        let moves = found.at.iter().zip(&from.at);
        Some(Lasting {
            time,
            along: moves.map(|(to, from)| (to - from) / by).collect(),
            bordered: bordered.ok()?,
            at: found.at,
        })
    }
}

/// The curve where a stay takes a time, how its unknowns change with that, and what is held.
struct Lasting {
    time: f64,
    at: Vec<f64>,
    along: Vec<f64>,
    bordered: Bordered,
}
