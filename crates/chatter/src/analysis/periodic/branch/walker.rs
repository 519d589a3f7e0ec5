//! One side of a branch, station by station.

use super::between::STANDS;
use super::changes::holds::{broken, jumps_back};
use super::changes::touch::STAYS;
use super::ends::accumulation::accumulates;
use super::ends::growth::growth;
use super::ends::returns::passages;
use super::ends::unbounded::{Law, unbounded};
use super::kept::{Ledger, Of, Stand, Standing, Then, Walked, damaged};
use super::limits::{End, Limits, station_at};
use super::special::{Near, Seed, Special};
use super::{Growth, Point, Saddle, SpecialKind, Unbounded};
use crate::analysis::continuation::{Curve, Problem, Station, StepError, locate};
use crate::analysis::periodic::diary::{Diary, Told};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::margins::leaves_at_border;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::roundoff;

/// One side of a branch.
pub(in crate::analysis::periodic) struct Side {
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    pub end: End,
}

impl Side {
    /// The other side, where this one was broken off or has come back: there is none.
    pub(in crate::analysis::periodic) fn without_other(&self) -> Option<Self> {
        let all = matches!(self.end, End::Interrupted | End::Closed);
        all.then(|| Self {
            points: Vec::new(),
            special: Vec::new(),
            end: self.end.clone(),
        })
    }
}

/// A graze that leads back to itself this often is no way on.
const MOST_GRAZES: usize = 4_000;
/// So many special points, the same two in turn, are no way on.
const TURNS: usize = 6;
/// Close to a graze is this part of the next step.
const CLOSE: f64 = 1e-4;
/// A step of this part of the longest is on new ground.
const OF_NOTE: f64 = 2e-3;
/// Parameters differ by so much of their size where they tell which way a branch goes.
const HEADED: f64 = 1e-10;
/// A step that leads to another solution is made so much shorter.
const SHORTER: f64 = 0.4;
/// After so many points each the period is looked at.
const LOOKED_BACK: usize = 8;
/// Points nearer than this to the latest, in parts of a step, are not kept: at a border they accumulate.
const CROWDED: f64 = 1e-6;

pub(super) struct Walker {
    pub shooting: Shooting<f64>,
    pub limits: Limits,
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    /// The parameter of the orbit that the side began with, once it is followed.
    pub began: f64,
}

/// What a step came to.
pub(super) enum Stop {
    On,
    End(End),
    /// The sequence of events breaks here, and nothing that is known follows it.
    Broken(End, Box<Station>),
    /// The same, where there is no use in looking for a way on.
    Over(End),
}

impl Walker {
    /// At a station that nothing was followed from yet.
    pub(super) fn begin(&mut self, station: Station) -> Stand {
        self.settle(&station);
        Stand {
            here: Point::new(&mut self.shooting, &station),
            of: Of::Branch(Walked {
                origin: station.at.clone(),
                passages: passages(&self.shooting),
                rises: station.parameter_slope() > 0.0,
                grazes: 0,
                hops: 0,
                since_kept: f64::INFINITY,
            }),
            station,
            step: self.limits.settings().first_step,
            made: 0,
        }
    }

    pub(super) fn walk(
        mut self,
        stand: Stand,
        diary: &mut Diary<'_>,
    ) -> Result<Side, PeriodicError> {
        let Stand {
            station,
            step,
            mut here,
            mut made,
            of: Of::Branch(mut walked),
        } = stand
        else {
            return Err(damaged());
        };
        self.began = walked.origin.last().copied().unwrap_or(f64::NAN);
        let mut curve = Curve::new(station, self.limits.settings());
        curve.step = step;
        self.settle(&curve.station);
        let workshop = self.shooting.workshop.clone();
        let system = Some(&workshop.system);
        let mut ledger = Ledger::new(system, (&self.points, &self.special), made);
        // At a graze multipliers have a pole: what changes its sign is looked for from close by.
        let mut at_graze = false;
        let end = loop {
            if self.points.len() >= self.limits.points || walked.grazes > MOST_GRAZES {
                break End::Points;
            }
            let leaves_graze = core::mem::take(&mut at_graze);
            if leaves_graze && let Some(impacts) = self.leads_back(ledger.special_points()) {
                break End::Rounding(impacts);
            }
            if leaves_graze
                && let Ok((close, _)) =
                    (curve.station).ahead(&mut self.shooting, CLOSE * curve.step)
            {
                self.settle(&close);
                here = Point::new(&mut self.shooting, &close);
                curve.moves(close);
            }
            let crossed = self.shooting.section_rates();
            let (next, step) = match curve.next(&mut self.shooting) {
                Ok(found) => found,
                Err(StepError::TooShort(error)) => {
                    if let Some(end) = self.ends_beside_root(&curve.station, &here) {
                        break end;
                    }
                    if let Some(end) = self.ends_with_strike(&curve.station, &here) {
                        break end;
                    }
                    // Where a crossing and the way back become one, no time is left between them.
                    self.settle(&curve.station);
                    let vanishes = self.shooting.impact_that_vanishes(&curve.station.at);
                    if let Some(index) = vanishes
                        && self.stay_ends(index, &mut curve, &mut here)
                    {
                        walked.grazes += 1;
                        at_graze = true;
                        continue;
                    }
                    let over = self.shooting.shortest_stay();
                    let over =
                        over.or_else(|| self.shooting.stay_with_corner_over(&curve.station.at));
                    if let Some(index) = over {
                        walked.grazes += 1;
                        if self.stay_ends(index, &mut curve, &mut here) {
                            at_graze = true;
                            continue;
                        }
                    }
                    walked.grazes += 1;
                    if let Some(Stop::On) = self.flight_ends(None, &mut curve, &mut here) {
                        at_graze = true;
                        continue;
                    }
                    if self.grazes_end(&mut curve, &mut here) {
                        at_graze = true;
                        continue;
                    }
                    if self.slips_begin(&mut curve, &mut here) {
                        at_graze = true;
                        continue;
                    }
                    match self.begins_to_open(&mut curve, &mut here) {
                        Some(Stop::Over(end) | Stop::End(end)) => break end,
                        Some(_) => {
                            at_graze = true;
                            continue;
                        }
                        None => self.settle(&curve.station),
                    }
                    if self.hop(&mut curve, &mut here, (walked.hops, None)) {
                        walked.hops += 1;
                        at_graze = true;
                        continue;
                    }
                    // Chatter that begins with nothing seems to end as late as contact does, too.
                    if self.stays_closed(&mut curve, &mut here) {
                        at_graze = true;
                        continue;
                    }
                    self.settle(&curve.station);
                    if leaves_at_border(&self.shooting, &curve.station.at, &error)
                        && self.note_border(&here, &curve.station)
                    {
                        break End::ChatterBorder;
                    }
                    let longer = self.comes_to_rest(&curve.station);
                    break longer.unwrap_or_else(|| End::Lost(error.to_string()));
                }
            };
            // Beyond an end of what restitutions may be solutions are no motion, and what breaks there is none.
            let theory_ends = self.leaves_theory((&curve.station, &next), step);
            let (next, step, theory_ends) = match theory_ends {
                Some((end, station, ahead)) => {
                    self.settle(&station);
                    (station, ahead, Some(end))
                }
                None => (next, step, None),
            };
            let crosses = self.shooting.section_rates();
            let both = crossed.into_iter().zip(crosses);
            if let Some((index, rates)) = { both }.enumerate().find(|(_, (was, is))| was * is < 0.0)
            {
                match self.loses_section(&mut curve, (step, index), rates, &mut here) {
                    Some(end) => break end,
                    None => continue,
                }
            }
            // Beyond where a way back takes no time the equations have solutions that are no motion.
            if self.shooting.comes_back_at_once(&next.at) {
                walked.grazes += 1;
                if self.hop(&mut curve, &mut here, (walked.hops, Some(&next))) {
                    walked.hops += 1;
                    at_graze = true;
                    continue;
                }
            }
            // Where two such ways are over at once equations become singular before they are.
            if self
                .shooting
                .way_onto_that_shrinks(&next, STAYS[1])
                .is_some()
                && self.past_stay(&next, &mut curve, &mut here)
            {
                walked.grazes += 1;
                at_graze = true;
                continue;
            }
            if self.shooting.flight_has_vanished(&next.at)
                && let Some(Stop::On) = self.flight_ends(Some((&next, step)), &mut curve, &mut here)
            {
                walked.grazes += 1;
                at_graze = true;
                continue;
            }
            // The landings of the last correction belong to a point that differs by less than its square; a hop that led nowhere has left
            // others.
            if !self
                .shooting
                .was_evaluated_at(&next.at, 2.0 * next.correction)
            {
                self.settle(&next);
            }
            let least = self.shooting.least(&next.at).unwrap_or_default();
            let broken = broken(&self.shooting, &least);
            let shorter = SHORTER * step;
            if shorter >= self.limits.settings().shortest_step
                && jumps_back(&self.shooting, (&curve.station, step), &broken)
            {
                curve.step = shorter;
                continue;
            }
            if !broken.is_empty() {
                walked.grazes += 1;
                let ends = (&curve.station, &next);
                if made > 3
                    && let Some(end) = self.ends_where_it_began(ends, (step, true), &walked, &here)
                {
                    break end;
                }
                // What is left of a stay that comes to its end breaks in whichever way rounding says.
                if let Some(index) = self.stay_vanishes(&curve.station)
                    && self.stay_ends(index, &mut curve, &mut here)
                {
                    at_graze = true;
                    continue;
                }
                let told = self.special.len();
                match self.pass(&mut curve, step, broken, &mut here) {
                    Stop::On => {
                        at_graze = true;
                        if diary.tell(Told::Orbit(&here)).is_break() {
                            break End::Interrupted;
                        }
                        if self.leaves(&here) {
                            break End::Range;
                        }
                        if here
                            .impacts
                            .is_some_and(|impacts| impacts > self.limits.impacts)
                        {
                            break End::Impacts(self.limits.impacts);
                        }
                        continue;
                    }
                    Stop::Broken(end, station) => {
                        let known = self.special.len();
                        if !self.hop(&mut curve, &mut here, (walked.hops, Some(&station))) {
                            if self.stays_closed(&mut curve, &mut here) {
                                at_graze = true;
                                continue;
                            }
                            break end;
                        }
                        if known > told
                            && let Some(special) = self.special.last_mut()
                        {
                            special.persists = Some(true);
                        }
                        walked.hops += 1;
                        at_graze = true;
                        continue;
                    }
                    Stop::End(end) | Stop::Over(end) => break end,
                }
            }
            made += 1;
            let ends = (&curve.station, &next);
            if made > 3
                && let Some(end) = self.ends_where_it_began(ends, (step, false), &walked, &here)
            {
                break end;
            }
            if let Some(end) = theory_ends {
                let last = Point::new(&mut self.shooting, &next);
                let points = (&here, &last);
                if let Some(end) = self.between(&curve.station, &next, step, points) {
                    break end;
                }
                self.points.push(last);
                break end;
            }
            let there = Point::new(&mut self.shooting, &next);
            let edge = self.limits.beyond(there.parameter());
            if let Some(edge) = edge
                && let Some(end) = self.ends_at_edge((&curve.station, &next), (step, edge), &here)
            {
                break end;
            }
            if edge.is_none()
                && let Some(end) = self.turns_beyond_edge((&curve.station, &next), step, &here)
            {
                break end;
            }
            let ends = (&curve.station, &next);
            let passed = match leaves_graze {
                true => self.between_beside_graze(ends, step, (&here, &there), true),
                false => self.between(ends.0, ends.1, step, (&here, &there)),
            };
            if let Some(end) = passed {
                break end;
            }
            if edge.is_some() {
                break End::Range;
            }
            self.settle(&next);
            curve.moves(next);
            self.shooting.adopt(&curve.station.at);
            if self.shooting.grows_up() || self.shooting.has_planes() {
                curve.turns(&mut self.shooting);
            }
            here = there;
            walked.since_kept += step;
            if step > OF_NOTE * self.limits.longest_step {
                walked.hops = 0;
            }
            if walked.since_kept > CROWDED * self.limits.longest_step {
                self.points.push(here.clone());
                walked.since_kept = 0.0;
                if self.points.len().is_multiple_of(LOOKED_BACK) {
                    if let Some(unbounded) = self.unbounded(&curve.station) {
                        let end = self.comes_to_rest(&curve.station);
                        break end.unwrap_or(End::Unbounded(unbounded));
                    }
                    if let Some(growth) = self.growth() {
                        break End::Growth(growth);
                    }
                }
            }
            let broken_off = diary.tell(Told::Orbit(&here)).is_break();
            if broken_off || ledger.is_due(made) {
                let stand = Stand {
                    station: curve.station.clone(),
                    step: curve.step,
                    here: here.clone(),
                    made,
                    of: Of::Branch(walked.clone()),
                };
                let standing = Standing::of(&self.shooting, &stand);
                let then = (Then::On(Box::new(standing)), made);
                let kept = ledger.keep((&self.points, &self.special), then, diary);
                if broken_off || kept.is_break() {
                    break End::Interrupted;
                }
            }
        };
        // Whatever else is said where nothing is left of the orbit.
        let end = match end {
            End::Lost(_) if self.has_shrunk(&curve.station) => self.shrunk(&curve.station),
            End::Lost(_) => (self.shrinks_to(&curve.station))
                .map(End::Shrunk)
                .or_else(|| {
                    self.settle(&curve.station);
                    let are_low = self.shooting.has_brief_flight()
                        || self.shooting.has_low_flight(&curve.station.at);
                    accumulates(&self.special, are_low).map(End::Rounding)
                })
                .or_else(|| self.ends_in_family(&curve.station))
                .unwrap_or(end),
            end => end,
        };
        let end = ledger.close((&self.points, &self.special), end, diary);
        Ok(self.side(end))
    }

    /// The law by which the period has grown, if it does without bound: an orbit whose time is a logarithm comes to rest.
    fn unbounded(&self, station: &Station) -> Option<Unbounded> {
        let workshop = &self.shooting.workshop;
        let name = &workshop.model.parameters[*workshop.free.last()?].name;
        let scale = self.shooting.scales().last().copied()?;
        let found = unbounded(&self.points, name, scale)?;
        let rests = || self.shooting.all_but_rests(&station.at);
        (!matches!(found.law, Law::Logarithm(_)) || rests()).then_some(found)
    }

    /// How a state has grown, if it does without bound.
    fn growth(&self) -> Option<Growth> {
        let workshop = &self.shooting.workshop;
        let parameter = &workshop.model.parameters[*workshop.free.last()?].name;
        let scale = self.shooting.scales().last().copied()?;
        let states = workshop.model.states.iter().enumerate();
        states
            .filter(|(place, _)| !workshop.closure.is_phase(*place))
            .find_map(|(place, state)| {
                growth(&self.points, (&state.name, place), (parameter, scale))
            })
    }

    /// Whether nothing is left of the orbit at a station.
    pub(super) fn has_shrunk(&mut self, station: &Station) -> bool {
        if self.shooting.scales().len() != station.at.len() {
            return false;
        }
        self.settle(station);
        // What a forcing finds at rest all along has not shrunk.
        let is_forced = self.shooting.counts.iter().any(|&count| count != 0);
        let rest = self.shooting.node(&station.at, 0);
        let was_there = |point: &Point| self.shooting.is_one_place(&point.state, rest);
        let always = is_forced && self.points.iter().all(was_there);
        !always && self.shooting.has_shrunk(&station.at)
    }

    /// How the branch ends where its orbit has shrunk to a point, or its period grows without bound, to a saddle if the last orbit passes
    /// one.
    fn comes_to_rest(&mut self, station: &Station) -> Option<End> {
        if self.has_shrunk(station) {
            return Some(self.shrunk(station));
        }
        self.settle(station);
        let unbounded = self.unbounded(station);
        match self.shooting.saddle(&station.at) {
            Some(saddle) => Some(End::Saddle(Saddle {
                unbounded: unbounded.map(Box::new),
                ..saddle
            })),
            None => unbounded.map(End::Unbounded),
        }
    }

    /// The crossing whose way back takes no time any more, but for rounding. Stays that begin are longer.
    fn stay_vanishes(&mut self, station: &Station) -> Option<usize> {
        self.settle(station);
        let (index, _) = self.shooting.stay_that_vanishes(&station.at)?;
        Some(index)
    }

    /// On past where a crossing and the way back become one: no time is left between them. Whether that is so.
    fn stay_ends(&mut self, index: usize, curve: &mut Curve, here: &mut Point) -> bool {
        let (station, told) = (curve.station.clone(), self.special.len());
        self.settle(&station);
        let forward = self.heading_known(&station);
        let outcome = self.lose(&station, index, &here.clone());
        let ends = matches!(self.goes_on(outcome, (curve, forward), here), Stop::On);
        if !ends {
            self.special.truncate(told);
            self.settle(&station);
        }
        ends
    }

    /// Whether the direction at a station says nothing of where the parameter goes.
    pub(super) fn stands_still(&self, station: &Station) -> bool {
        self.is_flat(station) || self.shooting.comes_back_at_once(&station.at)
    }

    /// Where the parameter goes at a station: where it all but stands still, as where a stay comes to its end, as the points before say.
    pub(super) fn heading(&self, station: &Station) -> f64 {
        self.heading_known(station)
            .unwrap_or(station.parameter_slope())
    }

    /// The same, if it goes anywhere: all orbits of a family may have one value of it.
    pub(super) fn heading_known(&self, station: &Station) -> Option<f64> {
        let value = station.parameter();
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        if !self.stands_still(station) {
            return Some(station.parameter_slope());
        }
        let turns = |special: &&Special| {
            special.kind == SpecialKind::Fold || special.persists == Some(false)
        };
        let turned = self.special.iter().rev().find(turns);
        let since = turned
            .map_or(0, |special| special.place)
            .min(self.points.len());
        let told = self.points[since..].iter().rev().map(Point::parameter);
        let all = told.chain((since == 0).then_some(self.began));
        let ways = all.map(|before| value - before);
        // The latest that tells, or else the longest way.
        let known = ways.clone().find(|way| way.abs() > HEADED * scale);
        let known = known.or_else(|| ways.max_by(|a, b| a.abs().total_cmp(&b.abs())));
        // A direction stands still where what has been gone, more than rounding of the value, does not.
        let slope = station.parameter_slope();
        known
            .filter(|way| way.abs() > roundoff(value).max(STANDS * scale))
            .or((slope.abs() > STANDS * scale).then_some(slope))
    }

    /// From a station to where, on the way to the next, the parameter leaves its range.
    pub(super) fn ends_at_edge(
        &mut self,
        (from, to): (&Station, &Station),
        (step, edge): (f64, f64),
        here: &Point,
    ) -> Option<End> {
        let (station, step) = station_at(&mut self.shooting, (from, to), step, edge)?;
        self.settle(&station);
        let last = Point::new(&mut self.shooting, &station);
        if let Some(end) = self.between(from, &station, step, (here, &last)) {
            return Some(end);
        }
        self.points.push(last);
        Some(End::Range)
    }

    /// The same where both are in the range, and the curve turns back between them beyond its edge.
    fn turns_beyond_edge(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        here: &Point,
    ) -> Option<End> {
        let ends = (from.parameter_slope(), to.parameter_slope());
        if ends.0 * ends.1 >= 0.0 {
            return None;
        }
        let slope =
            &mut |_: &mut dyn Problem<f64>, station: &Station| Some(station.parameter_slope());
        let turn = locate(&mut self.shooting, from, step, ends, slope);
        let end = turn.and_then(|(turn, ahead)| {
            let edge = self.limits.beyond(turn.parameter())?;
            self.ends_at_edge((from, &turn), (ahead, edge), here)
        });
        if end.is_none() {
            self.settle(to);
        }
        end
    }

    pub(super) fn side(mut self, end: End) -> Side {
        if end == End::Back {
            self.forget_way_back();
        }
        self.leave_out_events();
        Side {
            points: self.points,
            special: self.special,
            end,
        }
    }

    /// The landings of a station, which trials may have overwritten.
    pub(super) fn settle(&mut self, station: &Station) {
        let _ = self.shooting.evaluate(&station.at);
    }

    /// Whether the latest special points are the same two in turn: grazes that rounding does not tell apart, where the way on leads
    /// back; or one graze twice: between both the way has turned by rounding, as no fold lies there. Only the first of each is kept, beside those on
    /// `record`. Returns the fewest impacts among them.
    fn leads_back(&mut self, record: usize) -> Option<u64> {
        let count = self.special.len();
        let is_one = |a: &Special, b: &Special| a.is_that_of(b, Near::known(a, b));
        let turns = |latest: &[Special]| match latest {
            [a, b] => a.kind.is_graze() && is_one(a, b),
            latest => latest.windows(3).all(|of| is_one(&of[0], &of[2])),
        };
        let (first, kept) = [(2, 1), (TURNS, 2)].into_iter().find_map(|(of, kept)| {
            let first = count.checked_sub(of)?;
            turns(&self.special[first..]).then_some((first, kept))
        })?;
        let impacts = self.special[first..].iter();
        let impacts = impacts.filter_map(|special| special.point.impacts);
        let fewest = impacts.min().unwrap_or_default();
        self.special.truncate((first + kept).max(record));
        Some(fewest)
    }

    fn leaves(&self, point: &Point) -> bool {
        self.limits.beyond(point.parameter()).is_some()
    }

    /// The latest special point where the sequence of events changes.
    pub(super) fn latest_change(&mut self) -> Option<&mut Special> {
        let changes = |kind: SpecialKind| kind.is_graze() || kind == SpecialKind::Touch;
        let mut all = self.special.iter_mut().rev();
        all.find(|special| changes(special.kind))
    }

    /// Tells of the latest such point, and of those at one place with it, whether the branch goes on in the parameter.
    pub(super) fn tell_persists(&mut self, persists: Option<bool>) {
        let Some(latest) = self.latest_change() else {
            return;
        };
        latest.persists = persists;
        let told_as = latest.told_as();
        let is_there = |special: &&mut Special| special.told_as() == told_as;
        let together = self.special.iter_mut().rev().take_while(is_there);
        together.for_each(|special| special.persists = persists);
    }

    /// Of the latest special point multipliers have a pole, or few digits.
    pub(super) fn tell_no_multipliers(&mut self) {
        if let Some(special) = self.special.last_mut() {
            special.point.multipliers.clear();
        }
    }

    /// Notes a special point: an orbit near it, with the state and parameter of the solution of its equations, which the trace that finds
    /// it again starts from.
    pub(super) fn note(
        &mut self,
        kind: SpecialKind,
        point: &Point,
        at: &[f64],
        error: f64,
        residual: f64,
    ) {
        let mut shooting = self.shooting.clone();
        let point = point.moved(&mut shooting, at);
        let at = at.to_vec();
        self.note_with(kind, point, Seed { shooting, at }, (error, residual));
    }

    /// The same of an orbit whose equations are others than the branch's.
    pub(super) fn note_with(
        &mut self,
        kind: SpecialKind,
        point: Point,
        seed: Seed,
        (error, residual): (f64, f64),
    ) {
        self.special.push(Special {
            kind,
            point,
            error,
            residual,
            persists: None,
            above: None,
            monitor: None,
            leaves: Vec::new(),
            place: self.points.len(),
            seed: Some(seed),
        });
    }
}
