//! On past where a surface is touched: on one side of that the orbit crosses the surface and comes back, or stays on it. With that stay the
//! equations are singular at the touch, so that it is told of the orbit without.

use super::follower::{Follower, Stop};
use super::stay_end::KNOWN;
use crate::analysis::continuation::{
    Condition as Row, Curve, Problem, Station, locate, newton, tangent,
};
use crate::analysis::periodic::branch::{
    Broken, STAYS, Special, SpecialKind, Stay, VANISHED, broken_beside, moved, smallest,
};
use crate::analysis::periodic::condition::{Bordered, Condition};
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;

/// The orbits beyond are this near, against the sizes of the unknowns.
const NEAR: f64 = 1e-2;
/// Two touches this near, in parts of the parameters' sizes, are one.
const SAME: f64 = 1e-8;
/// So far beyond a touch the sequence of events without the stay is to hold, in parts of the longest step.
const BEYOND: [f64; 7] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0];
/// A stay that takes this part of the time is to be found nearer to the touch, by this factor.
const SHORTER: f64 = 0.25;
const NEARER: f64 = 0.5;
/// A stay that is all but over ends this near, in parts of the parameters' sizes.
const AT_END: f64 = 1e-3;
/// New equations begin their steps with this part of the longest one.
const CAREFUL: f64 = 1e-3;

/// A curve beyond a touch: its equations, and where it is.
pub(super) struct Onward {
    pub shooting: Shooting<f64>,
    pub condition: Condition,
    pub grazing: Option<usize>,
    pub bordered: Bordered,
    pub station: Station,
}

/// The surface that is touched where the sequence of events breaks, and the step on whose way it is.
pub(super) fn touched(broken: &Broken) -> Option<(usize, GuardKind)> {
    match *broken {
        Broken::Inner(index, guard) if guard.opposite().is_some() => Some((index, guard)),
        _ => None,
    }
}

/// The least value of a guard on the way of a step.
fn least_of(shooting: &mut Shooting<f64>, at: &[f64], touched: (usize, GuardKind)) -> Option<f64> {
    shooting.evaluate(at).ok()?;
    let least = shooting.least(at).ok()?;
    smallest(&least, touched, false).map(|least| least.value)
}

impl Follower {
    /// What is held at zero, of equations with other steps for the same orbit, and the step whose impact has no rate.
    pub(super) fn condition_of(
        &self,
        shooting: &mut Shooting<f64>,
        at: &[f64],
    ) -> Option<(Condition, Option<usize>)> {
        let Condition::Monitor(index) = self.condition else {
            return Some((self.condition, None));
        };
        if self.kind.is_graze() {
            shooting.evaluate(at).ok()?;
            let index = shooting.without_rate()?;
            return Some((Condition::Monitor(index), Some(index)));
        }
        // Functions of the orbit are numbered after its steps.
        let function = index.checked_sub(self.shooting.steps.len())?;
        let index = shooting.steps.len() + function;
        Some((Condition::Monitor(index), None))
    }

    /// A surface is touched: a stay comes in, and grows.
    pub(super) fn comes_to_stay(
        &mut self,
        touched: (usize, GuardKind),
        station: &Station,
    ) -> Option<Onward> {
        self.shooting.evaluate(&station.at).ok()?;
        let least = self.shooting.least(&station.at).ok()?;
        let touching = smallest(&least, touched, false)?;
        let longer = self.shooting.with_event(&station.at, touched.0, touching);
        let (mut touch, at, index) = longer.ok()?;
        touch.evaluate(&at).ok()?;
        let period = touch.period();
        let ways = [Stay::Beyond, Stay::On].into_iter();
        let mut ways = ways.flat_map(|stay| STAYS.map(|part| (stay, part * period)));
        ways.find_map(|(stay, duration)| {
            let (mut longer, guess, place) = touch.with_stay(&at, (index, stay, duration)).ok()?;
            let (condition, grazing) = self.condition_of(&mut longer, &guess)?;
            let bordered = condition.near(&mut longer, &guess, None).ok()?;
            let fixed = Row::fixed(guess.len(), place, guess[place]);
            let rows = core::slice::from_ref(&fixed);
            let found = newton(&mut bordered.of(&mut longer), &guess, rows).ok()?;
            if moved(&found.at, &guess, longer.scales()) > NEAR
                || !holds(&mut longer, &found.at, grazing)
            {
                return None;
            }
            let bordered = condition
                .near(&mut longer, &found.at, Some(&bordered))
                .ok()?;
            let shorter =
                self.shrinks_to(&mut longer, (&found.at, place, &bordered), touch.free(&at));
            if !shorter {
                return None;
            }
            let along = tangent(&mut bordered.of(&mut longer), &found.at, &fixed.row).ok()?;
            Some(Onward {
                shooting: longer,
                condition,
                grazing,
                bordered,
                station: Station::beginning(found, along),
            })
        })
    }

    /// Whether a stay that becomes shorter leads to such parameters, and not to others nearby: beside a jump of the force what folds with a stay
    /// is another curve.
    fn shrinks_to(
        &self,
        longer: &mut Shooting<f64>,
        (at, place, bordered): (&[f64], usize, &Bordered),
        touch: &[f64],
    ) -> bool {
        let sizes = &self.shooting.workshop.sizes;
        let far = moved(longer.free(at), touch, sizes);
        let row = Row::fixed(at.len(), place, SHORTER * at[place]);
        let rows = core::slice::from_ref(&row);
        match newton(&mut bordered.of(longer), at, rows) {
            Ok(found) => {
                let near = moved(longer.free(&found.at), touch, sizes);
                near <= NEARER * far || far <= SAME
            }
            Err(_) => false,
        }
    }

    /// Whether the stay at a station, or at the one before, ends at such parameters: one that is all but over where the curve is extrapolated to end, or
    /// if it cannot be, no farther than it may take to end; and another one is to come nearer as it becomes shorter.
    fn ends_at(
        &mut self,
        (before, station, bordered): (&Station, &Station, &Bordered),
        first: usize,
        touch: &[f64],
    ) -> bool {
        let Some(place) = self.shooting.duration_place(self.shooting.after(first)) else {
            return false;
        };
        if station.at[place] <= VANISHED * self.shooting.period() {
            let end = self.without_time(before, place, bordered);
            let (at, most) = match &end {
                Some((end, _)) => (end, KNOWN),
                None => (&station.at, AT_END),
            };
            let shooting = &self.shooting;
            return moved(shooting.free(at), touch, &shooting.workshop.sizes) <= most;
        }
        let longer = &mut self.shooting.clone();
        self.shrinks_to(longer, (&station.at, place, bordered), touch)
    }

    /// Whether a stay has come to its end at a station, or all but and becomes shorter along the curve: the crossing that it begins with. (Where it
    /// has, rounding says how it changes; and where nothing leads on, too.)
    fn ending_stay(&mut self, station: &Station, leads_on: bool) -> Option<usize> {
        self.shooting.evaluate(&station.at).ok()?;
        let first = self.shooting.shortest_stay()?;
        let place = self.shooting.duration_place(self.shooting.after(first))?;
        let is_over = station.at[place] <= VANISHED * self.shooting.period();
        (is_over || !leads_on || station.tangent[place] < 0.0).then_some(first)
    }

    /// A stay has come to its end: on without it, to the side where the sequence of events holds then. With that the touch, what is left there
    /// of the least value, and how that changes.
    pub(super) fn loses_stay(
        &mut self,
        (before, station, bordered): (&Station, &Station, &Bordered),
        leads_on: bool,
    ) -> Option<(Onward, Station, (f64, f64))> {
        let first = self.ending_stay(station, leads_on)?;
        let guard = self.shooting.steps[first].ends_at()?;
        let (mut touching, start, index) =
            (self.shooting).without_way_back(&station.at, first).ok()?;
        touching.evaluate(&start).ok()?;
        let (shorter, guess, merged) = touching.without_event(&start, index).ok()?;
        let (mut onward, distance) = self.leads_on(shorter, (&guess, NEAR), &BEYOND)?;
        let (shorter, borders) = (&mut onward.shooting, &onward.bordered);
        let back = onward.station.clone().reversed();
        let within = 2.0 * distance;
        let mut reader = shorter.clone();
        let mut value = |station: &Station| least_of(&mut reader, &station.at, (merged, guard));
        let (far, _) = back.ahead(&mut borders.of(shorter), within).ok()?;
        let ends = (value(&back)?, value(&far)?);
        let mut held = borders.of(shorter);
        let (touch, ahead) = locate(&mut held, &back, within, ends, &mut |_, station| {
            value(station)
        })?;
        // Not back to where it has just begun.
        let free = touch.at.len() - shorter.parameters();
        let is_there = |special: &Special| {
            let sizes = &shorter.scales()[free..];
            special.kind == SpecialKind::Touch
                && moved(&touch.at[free..], &special.point.parameters, sizes) <= SAME
        };
        if self.special.last().is_some_and(is_there) {
            return None;
        }
        let there = &touch.at[free..];
        if !self.ends_at((before, station, bordered), first, there) {
            return None;
        }
        let left = value(&touch)?;
        let slope = (left - ends.0) / ahead;
        Some((onward, touch, (left, slope)))
    }

    /// The curve of other equations near a guess, no farther from it than this, on the side where their sequence of events holds; and how far along
    /// it that was found, of these parts of the longest step.
    pub(super) fn leads_on(
        &self,
        mut shooting: Shooting<f64>,
        (guess, near): (&[f64], f64),
        beyond: &[f64],
    ) -> Option<(Onward, f64)> {
        let (condition, grazing) = self.condition_of(&mut shooting, guess)?;
        let bordered = condition.near(&mut shooting, guess, None).ok()?;
        let last = guess.len() - 1;
        let there = Station::near(&mut bordered.of(&mut shooting), guess, last).ok()?;
        if moved(&there.at, guess, shooting.scales()) > near {
            return None;
        }
        let reach = self.limits.longest_step;
        let distances: Vec<f64> = beyond.iter().map(|part| part * reach).collect();
        let known = (&mut shooting, &bordered);
        let (station, distance) = side_that_holds(known, &there, grazing, &distances)?;
        let onward = Onward {
            shooting,
            condition,
            grazing,
            bordered,
            station,
        };
        Some((onward, distance))
    }

    /// On past where a stay comes to its end, if one does at this station, with a touch that is told.
    pub(super) fn past_stay(
        &mut self,
        curve: &mut Curve,
        (station, bordered): (&Station, &Bordered),
    ) -> Option<Stop> {
        match self.loses_stay((&curve.station, station, bordered), false) {
            Some(past) => Some(Stop::Anew(self.goes_past(past, curve))),
            None => self.ends_with_stay(curve, (station, bordered)),
        }
    }

    /// The same where a stay has all but come to its end at the latest station: nearer to that rounding says how the curve goes on.
    pub(super) fn stay_is_over(&mut self, curve: &mut Curve, bordered: &Bordered) -> Option<Stop> {
        if !matches!(self.condition, Condition::Singular(_)) {
            return None;
        }
        let station = curve.station.clone();
        self.shooting.evaluate(&station.at).ok()?;
        let (_, place) = self.shooting.stay_that_vanishes(&station.at)?;
        if station.tangent[place] >= 0.0 {
            return None;
        }
        self.past_stay(curve, (&station, bordered))
    }

    /// The same, with what is known of it.
    pub(super) fn goes_past(
        &mut self,
        (onward, touch, vanishes): (Onward, Station, (f64, f64)),
        curve: &mut Curve,
    ) -> Bordered {
        self.take(&onward);
        self.note(SpecialKind::Touch, &touch, vanishes);
        self.begins(onward, curve)
    }

    fn take(&mut self, onward: &Onward) {
        self.shooting = onward.shooting.clone();
        (self.condition, self.grazing) = (onward.condition, onward.grazing);
        self.sided = None;
    }

    /// On with other equations.
    pub(super) fn goes_on(&mut self, onward: Onward, curve: &mut Curve) -> Bordered {
        self.take(&onward);
        self.begins(onward, curve)
    }

    fn begins(&mut self, onward: Onward, curve: &mut Curve) -> Bordered {
        let Onward {
            bordered, station, ..
        } = onward;
        if self.shooting.evaluate(&station.at).is_ok() {
            let told = self.told(&station);
            self.points.push(told);
        }
        curve.moves(station);
        curve.step = CAREFUL * self.limits.longest_step;
        self.shooting.adopt(&curve.station.at);
        bordered
    }
}

/// A station beside another one, to the side where the sequence of events holds, and how far that is from there.
pub(super) fn side_that_holds(
    (shooting, bordered): (&mut Shooting<f64>, &Bordered),
    there: &Station,
    grazing: Option<usize>,
    distances: &[f64],
) -> Option<(Station, f64)> {
    let sides = [there.clone(), there.clone().reversed()];
    distances.iter().find_map(|&distance| {
        let beside = sides.each_ref().map(|side| {
            let (next, _) = side.ahead(&mut bordered.of(shooting), distance).ok()?;
            holds(shooting, &next.at, grazing).then_some(next)
        });
        match beside {
            [Some(next), None] | [None, Some(next)] => Some((next, distance)),
            _ => None,
        }
    })
}

/// Whether the sequence of events holds.
pub(super) fn holds(shooting: &mut Shooting<f64>, at: &[f64], grazing: Option<usize>) -> bool {
    shooting.evaluate(at).is_ok()
        && broken_beside(shooting, at, grazing).is_ok_and(|broken| broken.is_empty())
}
