//! One side of a curve of special points, station by station.

use super::degenerate::{self, Sided, Test, ends, has_multipliers, tests};
use super::past_touch::touched;
use super::start::SLOWEST;
use crate::analysis::continuation::{
    Curve, NewtonError, Problem, Station, StepError, locate, meeting,
};
use crate::analysis::periodic::branch::{
    Along, Broken, End, Kept, Ledger, Limits, Of, Point, Side, Special, SpecialKind, Stand,
    Standing, Then, broken_beside, damaged, first_break, least_beside, moved, station_at,
};
use crate::analysis::periodic::condition::{Bordered, Condition};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::diary::{Diary, Told};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::margins::leaves_at_border;
use crate::analysis::periodic::multipliers::NEAR_ONE;
use crate::analysis::periodic::shooting::{Shooting, station_after};
use crate::analysis::periodic::solved::NOISE;
use crate::flow::GuardKind;
use crate::numerics::Complex;

/// One side of a curve.
pub(super) struct Follower {
    pub shooting: Shooting<f64>,
    pub kind: SpecialKind,
    pub condition: Condition,
    /// The step that an impact without rate ends.
    pub grazing: Option<usize>,
    pub limits: Limits,
    /// The station that the side began with, and the sequence of events there.
    pub began: (Station, Vec<Passage>),
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    /// Of a curve of doublings: the latest station, and the side on which the doubled orbits lie there.
    pub sided: Option<(Vec<f64>, Option<f64>)>,
    /// The free parameters where the sequence of events changed last, and how many points there were beyond that.
    pub passed: Option<(Vec<f64>, usize)>,
}

/// So many steps are too few to come back.
const FIRST: usize = 3;
/// Borders are found anew where a curve has come this far, in steps.
const RENEWED: usize = 8;
/// Errors are no less than so many roundoffs of the parameter.
const ROUNDOFFS: f64 = 64.0;
/// Where another curve is met what is solved for is singular: not so near, in parts of the way there.
pub(super) const NOT_QUITE: f64 = 1e-5;
/// Where a curve begins on such a point what vanishes there does so nearer than so many roundoffs of the solution's size.
const BEGINS: f64 = 64.0;
/// What vanishes where another curve is met is told to do so as near to that, in parts of the step.
const BESIDE_MEETING: f64 = 1e-2;
/// At a point of codimension two what vanishes is below this part of what it was to both sides.
pub(super) const VANISHES: f64 = 1e-4;

/// How the way to the next station ended.
pub(super) enum Stop {
    /// It did not.
    On,
    /// Events have changed places: with borders of the equations as they are now.
    Anew(Bordered),
    End(End),
}

/// Where a curve stands.
pub(super) struct Place {
    pub station: Station,
    pub bordered: Bordered,
    /// The next step, once one was made.
    pub next: Option<f64>,
    pub steps: usize,
}

impl Place {
    /// Where no step was made.
    pub(super) fn new(station: Station, bordered: Bordered) -> Self {
        Self {
            station,
            bordered,
            next: None,
            steps: 0,
        }
    }
}

impl Follower {
    /// Takes what is on record of this side: where it stands, or how it ended.
    pub(super) fn resume(
        &mut self,
        diary: &mut Diary<'_>,
    ) -> Result<(Option<Place>, Option<End>), PeriodicError> {
        let kept = Kept::read(diary, Some(&self.shooting.workshop))?;
        (self.points, self.special) = (kept.points, kept.special);
        let standing = match kept.then {
            None => return Ok((None, None)),
            Some(Then::Ended(end)) => return Ok((None, Some(end))),
            Some(Then::Points) => return Err(damaged()),
            Some(Then::On(standing)) => standing,
        };
        let (mut shooting, stand) = standing.restored(&self.shooting.workshop)?;
        let condition = self.condition_of(&mut shooting, &stand.station.at);
        (self.condition, self.grazing) = condition.ok_or_else(damaged)?;
        self.shooting = shooting;
        let Of::Curve(Along { borders, passed }) = stand.of else {
            return Err(damaged());
        };
        self.passed = passed;
        let equations = self.shooting.unknowns() - self.shooting.parameters();
        let singular = matches!(self.condition, Condition::Singular(_));
        if singular && borders.len() != 2 * equations {
            return Err(damaged());
        }
        let place = Place {
            bordered: self.condition.restored(&borders),
            station: stand.station,
            next: Some(stand.step),
            steps: stand.made,
        };
        Ok((Some(place), None))
    }

    pub(super) fn follow(mut self, place: Place, diary: &mut Diary<'_>) -> Side {
        let Place {
            station,
            mut bordered,
            next,
            mut steps,
        } = place;
        let mut curve = Curve::new(station, self.limits.settings());
        curve.step = next.unwrap_or(curve.step);
        let _ = self.shooting.evaluate(&curve.station.at);
        let workshop = self.shooting.workshop.clone();
        let system = Some(&workshop.system);
        let mut ledger = Ledger::new(system, (&self.points, &self.special), steps);
        let end = loop {
            if self.points.len() >= self.limits.points {
                break End::Points;
            }
            if steps % RENEWED == RENEWED - 1 {
                let at = &curve.station.at;
                match (self.condition).near(&mut self.shooting, at, Some(&bordered)) {
                    Ok(renewed) => {
                        bordered = renewed;
                        self.sided = None;
                    }
                    Err(left) => break End::Lost(left.to_string()),
                }
            }
            steps += 1;
            match self.step(&mut curve, &bordered, steps) {
                Stop::On => {}
                Stop::Anew(anew) => bordered = anew,
                Stop::End(end) => break end,
            }
            let Some(point) = self.points.last().cloned() else {
                continue;
            };
            let broken_off = diary.tell(Told::Orbit(&point)).is_break();
            if broken_off || ledger.is_due(steps) {
                let stand = Stand {
                    station: curve.station.clone(),
                    step: curve.step,
                    here: point,
                    made: steps,
                    of: Of::Curve(Along {
                        borders: bordered.numbers(),
                        passed: self.passed.clone(),
                    }),
                };
                let standing = Standing::of(&self.shooting, &stand);
                let then = (Then::On(Box::new(standing)), steps);
                let kept = ledger.keep((&self.points, &self.special), then, diary);
                if broken_off || kept.is_break() {
                    break End::Interrupted;
                }
            }
        };
        let end = ledger.close((&self.points, &self.special), end, diary);
        self.side(end)
    }

    pub(super) fn side(self, end: End) -> Side {
        Side {
            points: self.points,
            special: self.special,
            end,
        }
    }

    fn step(&mut self, curve: &mut Curve, bordered: &Bordered, made: usize) -> Stop {
        if self.has_shrunk(&curve.station) {
            let last = curve.station.clone();
            let vanishes = self.shrinks(&last);
            if let Some(anew) = self.past_break(curve, (&last, bordered), Some(vanishes)) {
                return Stop::Anew(anew);
            }
        }
        if let Some(stop) = self.stay_is_over(curve, bordered) {
            return stop;
        }
        let found = curve.next(&mut bordered.of(&mut self.shooting));
        let (mut next, mut step) = match found {
            Ok(found) => found,
            Err(StepError::TooShort(error)) => {
                let last = curve.station.clone();
                if let Some(anew) = self.past_way_onto(curve, &last) {
                    return Stop::Anew(anew);
                }
                let stop = self.past_stay(curve, (&last, bordered));
                let stop = stop.or_else(|| {
                    let is_end = leaves_at_border(&self.shooting, &last.at, &error);
                    let vanishes = self.shrinks(&last);
                    let past = || self.past_break(curve, (&last, bordered), Some(vanishes));
                    (!is_end).then(past).flatten().map(Stop::Anew)
                });
                return stop.unwrap_or_else(|| Stop::End(self.border(curve, error)));
            }
        };
        if let Some(anew) = self.past_way_onto(curve, &next) {
            return Stop::Anew(anew);
        }
        let from = curve.station.clone();
        let evaluated = self.shooting.evaluate(&next.at);
        let broken =
            evaluated.and_then(|_| broken_beside(&mut self.shooting, &next.at, self.grazing));
        let broken = match broken {
            Ok(broken) => broken,
            // The last correction may have taken what is left of a stay.
            Err(left) => {
                let stop = self.past_stay(curve, (&from, bordered));
                let stop = stop.or_else(|| {
                    let vanishes = self.shrinks(&from);
                    let past = self.past_break(curve, (&from, bordered), Some(vanishes));
                    past.map(Stop::Anew)
                });
                return stop.unwrap_or_else(|| Stop::End(End::Lost(left.to_string())));
            }
        };
        if !broken.is_empty() {
            let mut reader = self.shooting.clone();
            let mut held = bordered.of(&mut self.shooting);
            let reader = (&mut reader, self.grazing);
            let first = first_break(&mut held, reader, (&from, step), broken);
            // What lies beyond the range is not looked at.
            match first {
                Some((_, station, ahead)) if !self.limits.hold(&station) => {
                    if let Err(left) = self.shooting.evaluate(&station.at) {
                        return Stop::End(End::Lost(left.to_string()));
                    }
                    (next, step) = (station, ahead);
                }
                Some((broken, station, ahead)) => {
                    if made > FIRST
                        && let Some(end) = self.closes((&from, &station), ahead, bordered)
                    {
                        return Stop::End(end);
                    }
                    if let Some(stop) = self.stay_ends(curve, (&station, ahead), bordered) {
                        return stop;
                    }
                    let meets = from.orientation * next.orientation < 0.0;
                    let place = (&station, ahead, meets.then_some(step));
                    return self.changes(curve, (&broken, place), bordered);
                }
                None => return Stop::End(End::Lost("the sequence of events changes".to_owned())),
            }
        }
        if let Some(end) = self.is_of_no_kind() {
            let stop = self.past_stay(curve, (&from, bordered));
            let stop = stop.or_else(|| self.leaps_to_end_of_stay(curve, (&from, bordered)));
            return stop.unwrap_or(Stop::End(end));
        }
        if made > FIRST
            && let Some(end) = self.closes((&from, &next), step, bordered)
        {
            return Stop::End(end);
        }
        let edge = self.limits.beyond(next.parameter());
        if let Some(edge) = edge {
            let mut held = bordered.of(&mut self.shooting);
            if let Some(found) = station_at(&mut held, (&from, &next), step, edge) {
                (next, step) = found;
            }
        }
        let other = next.at.len() - 2;
        let other_edge = self.limits.beyond_other(next.at[other]);
        if let Some(edge) = other_edge {
            let mut held = bordered.of(&mut self.shooting);
            let ends = (from.at[other] - edge, next.at[other] - edge);
            let found = locate(&mut held, &from, step, ends, &mut |_, station| {
                Some(station.at[other] - edge)
            });
            if let Some(found) = found {
                (next, step) = found;
            }
        }
        if let Some(end) = self.between(&from, (&next, step), bordered) {
            return Stop::End(end);
        }
        if let Err(left) = self.shooting.evaluate(&next.at) {
            return Stop::End(End::Lost(left.to_string()));
        }
        let told = self.told(&next);
        self.points.push(told);
        if edge.or(other_edge).is_some() {
            return Stop::End(End::Range);
        }
        curve.moves(next);
        self.shooting.adopt(&curve.station.at);
        if self.shooting.has_planes() {
            curve.turns(&mut bordered.of(&mut self.shooting));
        }
        Stop::On
    }

    /// The end where the orbit that was evaluated last solves the equations of a fold or doubling and yet has no multiplier of 1 or -1: the
    /// matrix is singular there by rounding alone, as where an arc is narrower than a rounding of the parameters, or where what vanishes
    /// is the time between two events of a touch.
    fn is_of_no_kind(&self) -> Option<End> {
        let Condition::Singular(sign) = self.condition else {
            return None;
        };
        let multipliers = self.shooting.multipliers();
        let largest = (multipliers.iter()).fold(0.0_f64, |most, m| most.max(m.modulus()));
        // Rounding of the largest is in all of them.
        let off = |m: &Complex| (m.re - sign).hypot(m.im);
        let near = NEAR_ONE.max(ROUNDOFFS * f64::EPSILON * largest);
        let is_known = multipliers.iter().all(|m| m.modulus().is_finite());
        let is_there = !is_known || multipliers.iter().any(|m| off(m) <= near);
        (!is_there).then(|| {
            End::Lost(format!(
                "the next orbit has no multiplier of {sign} any more: what vanishes there is rounding"
            ))
        })
    }

    /// A station as a point: of the orbit without the impact that grazes.
    pub(super) fn told(&mut self, station: &Station) -> Point {
        let mut point = Point::new(&mut self.shooting, station);
        if self.grazing.is_some() {
            point.impacts = point.impacts.map(|count| count.saturating_sub(1));
            (point.multipliers, point.modulus_error) =
                multipliers(&self.shooting, &station.at, self.grazing);
        }
        if self.kind.has_neutral_multiplier() {
            // It is on the circle by the equations: what it is told off is what moduli there are known to.
            let off = |m: &Complex| (m.modulus() - 1.0).abs();
            let nearest = (point.multipliers.iter()).map(off).fold(NEAR_ONE, f64::min);
            if nearest < NEAR_ONE {
                point.modulus_error = point.modulus_error.max(2.0 * nearest);
            }
        }
        point
    }

    /// Points of codimension two between two stations; the end, if the curve ends at one of them.
    pub(super) fn between(
        &mut self,
        from: &Station,
        (to, step): (&Station, f64),
        bordered: &Bordered,
    ) -> Option<End> {
        let mut reader = self.shooting.clone();
        let (kind, grazing) = (self.kind, self.grazing);
        let mut at = |station: &Station, sided: Sided| -> Option<(Vec<Test>, f64)> {
            reader.evaluate(&station.at).ok()?;
            let (multipliers, modulus_error) = multipliers(&reader, &station.at, grazing);
            let place = degenerate::Place {
                shooting: &reader,
                station,
                grazing,
                multipliers: &multipliers,
                bordered,
                from,
                sided,
            };
            Some((tests(kind, &place), modulus_error))
        };
        let known = self.sided.take().filter(|(there, _)| *there == from.at);
        let sided = known.map_or(Sided::Asked, |(_, side)| Sided::Told(side));
        let ((before, from_error), (after, to_error)) = (at(from, sided)?, at(to, Sided::Asked)?);
        let is_side = |test: &&Test| test.kind == SpecialKind::GeneralisedDoubling;
        let side = after.iter().find(is_side);
        self.sided = side.map(|side| (to.at.clone(), side.value));
        let begins = self.points.is_empty();
        let begun = match begins && self.shooting.evaluate(&from.at).is_ok() {
            true => multipliers(&self.shooting, &from.at, grazing).0,
            false => Vec::new(),
        };
        let mut found = Vec::new();
        for (index, (test, after_test)) in before.iter().zip(&after).enumerate() {
            let (Some(before), Some(after)) = (test.value, after_test.value) else {
                continue;
            };
            let error = from_error.max(to_error);
            let is_nothing = test.is_rounding(error) && after_test.is_rounding(error);
            if is_nothing {
                continue;
            }
            let slope = (after - before) / step;
            if begins && (before / slope).abs() <= BEGINS * f64::EPSILON {
                // Both sides begin with what rounding leaves of zero. It is told of one, where the curve ends of that which does not go on.
                let is_own = match ends(self.kind, test.kind) {
                    true => after < 0.0,
                    false => from.parameter_slope() > 0.0,
                };
                if is_own && (!test.of_multipliers || has_multipliers(test.kind, &begun)) {
                    found.push((test.kind, from.clone(), 0.0, (before, slope), 0.0));
                }
                continue;
            }
            if before * after >= 0.0 {
                continue;
            }
            let mut held = bordered.of(&mut self.shooting);
            let sided = match test.kind {
                SpecialKind::GeneralisedDoubling => Sided::Asked,
                _ => Sided::Told(None),
            };
            let mut value = |station: &Station| at(station, sided)?.0.get(index)?.value;
            let located = locate(&mut held, from, step, (before, after), &mut |_, station| {
                value(station)
            });
            let Some((mut station, ahead)) = located else {
                continue;
            };
            let mut here = value(&station).unwrap_or(f64::NAN);
            // What jumps has no zero, and what has a pole comes no nearer to it in between.
            let (least, most) = (before.abs().min(after.abs()), before.abs().max(after.abs()));
            let vanishes = |here: f64| here.abs() <= least.min(VANISHES * most);
            // Where another curve is met stations are known the less the nearer they are, and the meeting itself to rounding.
            if from.orientation * to.orientation < 0.0
                && let Some(met) = self.met((&station, BESIDE_MEETING * step), bordered)
                && let Some(there) = value(&met).filter(|&there| vanishes(there))
            {
                (station, here) = (met, there);
            }
            if !vanishes(here) || self.shooting.evaluate(&station.at).is_err() {
                continue;
            }
            let (there, known_to) = multipliers(&self.shooting, &station.at, grazing);
            let is_there = match test.kind {
                SpecialKind::Cusp => degenerate::stands(&self.shooting, (from, &station)),
                _ => !test.of_multipliers || has_multipliers(test.kind, &there),
            };
            let known_to = if test.of_multipliers { known_to } else { 0.0 };
            if is_there {
                found.push((test.kind, station, ahead, (here, slope), known_to));
            }
        }
        found.sort_by(|a, b| a.2.total_cmp(&b.2));
        for (kind, station, _, vanishes, known_to) in found {
            self.note_known(kind, &station, vanishes, known_to);
            if ends(self.kind, kind) {
                return Some(End::At(kind));
            }
        }
        None
    }

    /// Notes a special point with the value there of what vanishes, and how that changes along the curve.
    pub(super) fn note(&mut self, kind: SpecialKind, station: &Station, vanishes: (f64, f64)) {
        self.note_known(kind, station, vanishes, 0.0);
    }

    /// The same where that value is known to so much only.
    fn note_known(
        &mut self,
        kind: SpecialKind,
        station: &Station,
        (value, slope): (f64, f64),
        known_to: f64,
    ) {
        if self.shooting.evaluate(&station.at).is_err() {
            return;
        }
        let point = self.told(station);
        let scale = self.shooting.scales()[station.at.len() - 1];
        let off = (NOISE * station.correction).max(value.abs().max(known_to) / slope.abs());
        let off = off.max(f64::EPSILON);
        self.special.push(Special {
            kind,
            error: (ROUNDOFFS * f64::EPSILON * station.parameter().abs()).max(off * scale),
            residual: value.abs(),
            persists: None,
            above: None,
            monitor: None,
            leaves: Vec::new(),
            place: self.points.len(),
            point,
            seed: None,
        });
    }

    /// On with two events in another order, which is nothing that happens to the orbit.
    fn exchange(
        &mut self,
        curve: &mut Curve,
        (index, station, ahead): (usize, &Station, f64),
        bordered: &Bordered,
    ) -> Result<Bordered, End> {
        let from = curve.station.clone();
        if let Some(end) = self.between(&from, (station, ahead), bordered) {
            return Err(end);
        }
        let lost = |error: &dyn core::fmt::Display| End::Lost(error.to_string());
        self.shooting
            .evaluate(&station.at)
            .map_err(|left| lost(&left))?;
        let exchanged = self.shooting.exchanged(&station.at, index);
        let mut exchanged = exchanged.map_err(|error| lost(&error))?;
        let number = |index: usize| exchanged.numbers.get(index).copied().unwrap_or(index);
        let condition = match self.condition {
            Condition::Monitor(index) => Condition::Monitor(number(index)),
            singular @ Condition::Singular(_) => singular,
        };
        let grazing = self.grazing.map(number);
        let direction = exchanged.direction(&station.tangent);
        let grows = exchanged.grows();
        let shooting = &mut exchanged.shooting;
        let anew = condition.near(shooting, &exchanged.guess, None);
        let anew = anew.map_err(|left| lost(&left))?;
        let guess = (&*exchanged.guess, &*direction);
        let next =
            station_after(&mut anew.of(shooting), guess, grows).map_err(|error| lost(&error))?;
        self.shooting = exchanged.shooting;
        (self.condition, self.grazing) = (condition, grazing);
        self.shooting
            .evaluate(&next.at)
            .map_err(|left| lost(&left))?;
        let told = self.told(&next);
        self.points.push(told);
        curve.moves(next);
        self.shooting.adopt(&curve.station.at);
        Ok(anew)
    }

    /// The sequence of events changes: two of them change places, or something breaks.
    fn changes(
        &mut self,
        curve: &mut Curve,
        (broken, place): (&Broken, (&Station, f64, Option<f64>)),
        bordered: &Bordered,
    ) -> Stop {
        let Broken::Passed(index) = *broken else {
            return self.breaks(curve, (broken, place), bordered);
        };
        let (station, ahead, _) = place;
        match self.exchange(curve, (index, station, ahead), bordered) {
            Ok(anew) => Stop::Anew(anew),
            Err(end @ End::Lost(_)) => {
                let before = self.left_of(broken, &curve.station);
                let here = self.left_of(broken, station);
                let vanishes = (here, (here - before) / ahead);
                let past = self.past_break(curve, (station, bordered), Some(vanishes));
                past.map_or(Stop::End(end), Stop::Anew)
            }
            Err(end) => Stop::End(end),
        }
    }

    /// The sequence of events changes: what breaks, where, how far ahead, and within which distance another curve is met.
    fn breaks(
        &mut self,
        curve: &mut Curve,
        (broken, (station, ahead, meets)): (&Broken, (&Station, f64, Option<f64>)),
        bordered: &Bordered,
    ) -> Stop {
        let from = &curve.station.clone();
        let turned = self.turns_back(broken, (from, ahead), bordered);
        let (station, ahead) = (turned.as_ref()).map_or((station, ahead), |(at, by)| (at, *by));
        let losing = self.loses_rate(broken, (from, station));
        let broken = losing.as_ref().unwrap_or(broken);
        // Where both halves of a doubled orbit graze at once its curve meets that of the simple one: the equations are singular there.
        // Near there the equations tell little, and their solutions what is no meeting. Rounding may tell a flight before or after the
        // impact that loses its rate there for that impact.
        let starts = meets.map(|within| [(station, within), (from, 2.0 * within)]);
        let lost = self.losing(broken).into_iter().map(Broken::Event);
        let all: Vec<Broken> = lost.chain([broken.clone()]).collect();
        let met = starts.into_iter().flatten().find_map(|start| {
            let met = self.met(start, bordered)?;
            let vanishes = |one: &&Broken| {
                let before = self.left_of(one, from);
                self.left_of(one, &met).abs() <= VANISHES * before.abs()
            };
            Some((all.iter().find(vanishes)?.clone(), met))
        });
        let is_graze = match *broken {
            Broken::Event(index) => self.shooting.steps[index].impact().is_some(),
            Broken::Inner(_, guard) => matches!(guard, GuardKind::Gap(_)),
            Broken::Early(..)
            | Broken::Beyond(..)
            | Broken::Passed(_)
            | Broken::Carried(_)
            | Broken::Order(_) => false,
        };
        let met = match met {
            None if is_graze => self.extrapolated(from, (station, ahead), &all, bordered),
            met => met,
        };
        let (lost, met) = met.unzip();
        let broken = lost.as_ref().unwrap_or(broken);
        let before = self.left_of(broken, from);
        let short = met.as_ref().map(|met| {
            let reach = from.reach(&met.at, self.shooting.scales());
            reach * (1.0 - NOT_QUITE)
        });
        match short {
            None => {
                self.between(from, (station, ahead), bordered);
            }
            Some(short) => {
                let close = from.ahead(&mut bordered.of(&mut self.shooting), short);
                if let Ok((close, _)) = close {
                    self.between(from, (&close, short), bordered);
                }
            }
        }
        let station = met.as_ref().unwrap_or(station);
        if let Some(touch) = touched(broken) {
            let here = self.left_of(broken, station);
            self.note(SpecialKind::Touch, station, (here, (here - before) / ahead));
            let anew = match self.comes_to_stay(touch, station) {
                Some(onward) => Some(self.goes_on(onward, curve)),
                None => self.past_break(curve, (station, bordered), None),
            };
            return anew.map_or(Stop::End(End::At(SpecialKind::Touch)), Stop::Anew);
        }
        let lost = End::Lost(broken.told(&self.shooting));
        if !is_graze {
            let here = self.left_of(broken, station);
            let vanishes = (here, (here - before) / ahead);
            let past = self.past_break(curve, (station, bordered), Some(vanishes));
            return past.map_or(Stop::End(lost), Stop::Anew);
        }
        let kind = match self.kind {
            SpecialKind::Fold => SpecialKind::GrazeFold,
            SpecialKind::PeriodDoubling => SpecialKind::GrazeDoubling,
            SpecialKind::NeimarkSacker => SpecialKind::GrazeTorus,
            SpecialKind::Monitor => {
                // Named by how the gap of the orbit without the impact goes over the parameter.
                let closes =
                    matches!(broken, Broken::Inner(..)) == (station.parameter_slope() > 0.0);
                match closes {
                    true => SpecialKind::FlightGraze,
                    false => SpecialKind::ImpactGraze,
                }
            }
            kind if kind.is_graze() => SpecialKind::DoubleGraze,
            _ => return Stop::End(lost),
        };
        let here = self.left_of(broken, station);
        // Told without the impact that loses its rate, as on curves of grazes.
        let known = self.grazing;
        if let Broken::Event(index) = *broken {
            self.grazing = known.or(Some(index));
        }
        self.note(kind, station, (here, (here - before) / ahead));
        self.grazing = known;
        // Where an impact of the orbit without that one loses its rate, too, they have a pole.
        if let Broken::Event(_) = broken
            && (known.is_some() || self.shooting.slower_than(SLOWEST).len() > 1)
            && let Some(special) = self.special.last_mut()
        {
            special.point.multipliers.clear();
        }
        Stop::End(End::At(kind))
    }

    /// Where a stay comes to its end before a step does: the way there is looked at, and gone on from.
    fn stay_ends(
        &mut self,
        curve: &mut Curve,
        (station, ahead): (&Station, f64),
        bordered: &Bordered,
    ) -> Option<Stop> {
        let lost = self.loses_stay((&curve.station, station, bordered), true);
        let Some((onward, touch, vanishes)) = lost else {
            return self.ends_with_stay(curve, (station, bordered));
        };
        let (from, close) = (curve.station.clone(), ahead * (1.0 - NOT_QUITE));
        if let Ok((near, _)) = from.ahead(&mut bordered.of(&mut self.shooting), close)
            && let Some(end) = self.between(&from, (&near, close), bordered)
        {
            return Some(Stop::End(end));
        }
        Some(Stop::Anew(self.goes_past((onward, touch, vanishes), curve)))
    }

    /// The impacts that may lose their rate where this breaks: of one whose rate has turned the flight to it goes through the wall as well as
    /// that from it.
    fn losing(&self, broken: &Broken) -> Vec<usize> {
        let steps = &self.shooting.steps;
        let (beside, contact) = match *broken {
            Broken::Event(index) => (vec![index], steps[index].impact()),
            Broken::Inner(step, GuardKind::Gap(contact)) => {
                (vec![self.shooting.before(step), step], Some(contact))
            }
            _ => return Vec::new(),
        };
        let loses = |index: &usize| {
            contact.is_some() && steps[*index].impact() == contact && self.grazing != Some(*index)
        };
        beside.into_iter().filter(loses).collect()
    }

    /// What is left at a station of what breaks.
    pub(super) fn left_of(&mut self, broken: &Broken, station: &Station) -> f64 {
        let _ = self.shooting.evaluate(&station.at);
        let least = least_beside(&mut self.shooting, &station.at, self.grazing).unwrap_or_default();
        broken.value(&self.shooting, &least).unwrap_or(f64::NAN)
    }

    /// Where another curve is met, within a distance of a station.
    pub(super) fn met(
        &mut self,
        (near, within): (&Station, f64),
        bordered: &Bordered,
    ) -> Option<Station> {
        let found = meeting(&mut bordered.of(&mut self.shooting), &near.at).ok()?;
        (moved(&found.at, &near.at, self.shooting.scales()) <= within).then(|| Station {
            at: found.at,
            residual: found.residual,
            correction: found.correction,
            ..near.clone()
        })
    }

    /// No further step: at a border, if the orbit goes through complete chatter.
    fn border(&mut self, curve: &Curve, error: NewtonError) -> End {
        let kind = match self.kind {
            SpecialKind::Fold => SpecialKind::BorderFold,
            SpecialKind::PeriodDoubling => SpecialKind::BorderDoubling,
            _ => return End::Lost(error.to_string()),
        };
        if !leaves_at_border(&self.shooting, &curve.station.at, &error) {
            return End::Lost(error.to_string());
        }
        let station = curve.station.clone();
        self.note(kind, &station, (station.residual, 1.0));
        End::At(kind)
    }
}

/// The multipliers at a solution that was evaluated last, and what their moduli may be off by, without the impact that has no rate: with it they have a pole.
fn multipliers(
    shooting: &Shooting<f64>,
    at: &[f64],
    grazing: Option<usize>,
) -> (Vec<Complex>, f64) {
    let Some(index) = grazing else {
        return shooting.multipliers_known();
    };
    let Ok((mut shorter, guess, _)) = shooting.without_event(at, index) else {
        return (Vec::new(), f64::NAN);
    };
    match shorter.evaluate(&guess) {
        Ok(_) => shorter.multipliers_known(),
        Err(_) => (Vec::new(), f64::NAN),
    }
}
