//! Where a surface on which formulas change their form is touched: a stay comes in, or goes out. Where the field is continuous it is on
//! the other side, from a crossing to the way back; where the fields of both sides lead to the surface it is on the surface itself.

use super::coincidence::Together;
use super::events::unfollowed;
use super::graze::{THERE, moved};
use super::holds::sequence_holds;
use crate::analysis::continuation::{
    Condition, Left, NewtonError, Problem, Station, newton, tangent,
};
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::branch::{Point, SpecialKind};
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step, around};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Exchanged, Shooting};
use crate::expressions::Side;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least, LegKind};

/// On the other side an orbit begins with so long a stay, in parts of its period, or else with a shorter one.
pub(in crate::analysis::periodic) const STAYS: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// A stay that takes less than this part of the period has come to its end.
pub(in crate::analysis::periodic) const VANISHED: f64 = 1e-6;
/// One of two solutions that is farther from where both are looked for by this factor is another touch.
const FARTHER: f64 = 2.0;
/// Between a crossing and the way back no time is left: less than this part of the period.
pub(in crate::analysis::periodic::branch) const NO_TIME: f64 = 1e-2;

/// Stays that vanish at once are as long as each other, but for this factor.
const TOGETHER: f64 = 2.0;

/// What touches a surface as well has a least value of no more than this part of what it is the sum of.
const TOUCHES: f64 = 1e-11;

/// A stay that begins where a surface is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::analysis::periodic) enum Stay {
    /// On its other side.
    Beyond,
    /// On it.
    On,
}

impl Shooting<f64> {
    /// The crossing whose way back follows with no time left, if it is this event or the one before; without an event, any.
    pub(super) fn crossing_that_vanishes(&self, event: usize) -> Option<usize> {
        [event, self.before(event)]
            .into_iter()
            .find(|&index| self.comes_back(index))
    }

    /// Whether a guard ends a stay that a step leads to: back where that comes from, onto the surface if that is left.
    fn ends_stay(&self, step: &Step, guard: Option<GuardKind>) -> bool {
        if let Some(GuardKind::Leave(surface, _)) = step.ends_at() {
            return guard == Some(GuardKind::Switch(surface));
        }
        let back = step.ends_at().and_then(GuardKind::opposite);
        let origin = self.workshop.system.origin_of(step.mode());
        let leaves = match (guard, origin) {
            (Some(GuardKind::Leave(surface, side)), Some((_, sides, _))) => {
                back == Some(GuardKind::Switch(surface)) && sides.get(surface) == side
            }
            _ => false,
        };
        back.is_some() && (guard == back || leaves)
    }

    /// Whether a step ends with a crossing whose way back follows at once.
    pub(super) fn comes_back(&self, index: usize) -> bool {
        let count = self.steps.len();
        let after = self.after(index);
        let [step, next, last] = [index, after, self.after(after)].map(|k| &self.steps[k]);
        let is_leg =
            |step: &Step| matches!(step.passage, Passage::Leg(kind) if kind.jump == Jump::None);
        let all = count > 1 && is_leg(step) && is_leg(next);
        // Across the end of a cycle pieces are numbered a turn on.
        let wraps = after <= index || self.after(after) <= after;
        let stay = self.latest.get(after);
        all && self.ends_stay(step, next.ends_at())
            && (last.mode() == step.mode() || self.turns_beyond(index))
            && (wraps || last.pieces == step.pieces)
            && stay.is_some_and(|stay| stay.duration < NO_TIME * self.period())
    }

    /// Whether on the way back from beyond a surface the state comes to the other side of one more, as of drag that is there alone: without the stay it crosses that
    /// instead.
    fn turns_beyond(&self, index: usize) -> bool {
        let stay = self.after(index);
        let [step, last] = [index, self.after(stay)].map(|k| &self.steps[k]);
        let turned = self.surface_at_impact(step.mode(), last.mode());
        turned.is_some_and(|surface| step.ends_at() != Some(GuardKind::Switch(surface)))
    }

    /// The crossing whose way back follows soonest, with no time left.
    pub(in crate::analysis::periodic) fn shortest_stay(&self) -> Option<usize> {
        let count = self.steps.len();
        let stay = |index: usize| self.latest[self.after(index)].duration;
        let all = (0..count).filter(|&index| self.comes_back(index));
        all.min_by(|&a, &b| stay(a).total_cmp(&stay(b)))
    }

    /// The crossing before the shortest stay with a corner within it, which is over but for that.
    pub(in crate::analysis::periodic) fn stay_with_corner_over(&self, at: &[f64]) -> Option<usize> {
        let lasts = |&index: &usize| {
            let corner = self.after(index);
            self.latest[corner].duration + self.latest[self.after(corner)].duration
        };
        let is_over = |&index: &usize| self.with_corner_after_stay(at, index).is_some();
        let all = (0..self.steps.len()).filter(is_over);
        all.min_by(|a, b| lasts(a).total_cmp(&lasts(b)))
    }

    /// Of that the crossing, and where the duration of the stay stands among the unknowns, if it takes no more than this part of the period.
    pub(in crate::analysis::periodic) fn stay_within(
        &self,
        at: &[f64],
        part: f64,
    ) -> Option<(usize, usize)> {
        let first = self.shortest_stay()?;
        let place = self.duration_place(self.after(first))?;
        (at[place] <= part * self.period()).then_some((first, place))
    }

    /// The same if it takes no time any more but for rounding.
    pub(in crate::analysis::periodic) fn stay_that_vanishes(
        &self,
        at: &[f64],
    ) -> Option<(usize, usize)> {
        self.stay_within(at, VANISHED)
    }

    /// The crossings whose way back takes no time any more but for rounding, or little more than that of one of them which is about to end.
    fn stays_that_vanish(&self, with: Option<usize>) -> Vec<usize> {
        let lasts = |index: usize| self.latest[self.after(index)].duration;
        let shortest = with.map_or(0.0, |first| TOGETHER * lasts(first));
        let is_over = |index: &usize| {
            let most = shortest.max(VANISHED * self.period());
            self.comes_back(*index) && lasts(*index) <= most
        };
        (0..self.steps.len()).filter(is_over).collect()
    }

    /// One of them, if one is of this surface.
    pub(super) fn stay_over(&self, at: &[f64], guard: GuardKind) -> Option<usize> {
        let (first, _) = self.stay_that_vanishes(at)?;
        let is_of = |&index: &usize| {
            let ends_at = self.steps[index].ends_at();
            ends_at == Some(guard) || ends_at == guard.opposite()
        };
        self.stays_that_vanish(None)
            .iter()
            .any(is_of)
            .then_some(first)
    }

    /// The same orbit with one of the stays that vanish at once, as those of an orbit with a symmetry do, and its crossing: where one vanishes the
    /// equations with another are singular.
    pub(super) fn with_one_stay(
        self,
        (at, first): (Vec<f64>, usize),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let (mut shooting, mut at, mut first) = (self, at, first);
        loop {
            let all = shooting.stays_that_vanish(Some(first));
            // Where rounding has the shortest end before it begins, the equations with it are left as soon as another is gone.
            let lasts = |&index: &usize| {
                let place = shooting.duration_place(shooting.after(index));
                place.map_or(f64::INFINITY, |place| at[place])
            };
            let shortest = all.iter().min_by(|a, b| lasts(a).total_cmp(&lasts(b)));
            let Some(&other) = shortest.filter(|_| all.len() > 1) else {
                return Ok((shooting, at, first));
            };
            let left = |left: Left| PeriodicError::NoConvergence {
                how: left.to_string(),
            };
            let (mut touching, start, index) = shooting.without_way_back(&at, other)?;
            touching.evaluate(&start).map_err(left)?;
            let (mut fewer, guess, _) = touching.without_event(&start, index)?;
            fewer.evaluate(&guess).map_err(left)?;
            first = fewer
                .shortest_stay()
                .ok_or_else(|| unfollowed("the loss of all stays at once"))?;
            (shooting, at) = (fewer, guess);
        }
    }

    /// Where a stay whose crossing or way back is this event, or one that begins with the next, is over, but for a corner of the field between both,
    /// as that of drag which turns with the rate that vanishes: the equations with the corner after the way back, and the crossing.
    pub(super) fn with_corner_after_stay(
        &self,
        at: &[f64],
        event: usize,
    ) -> Option<(Self, Vec<f64>, usize)> {
        let count = self.steps.len();
        let first = (0..3).map(|back| around(event, -back, count));
        first.into_iter().find_map(|first| {
            let corner = self.after(first);
            let back = self.after(corner);
            let apart = [corner, back].map(|k| self.latest.get(k).map(|l| l.duration));
            let [before, after] = apart;
            let is_over = before? + after? < NO_TIME * self.period();
            if count < 3
                || !is_over
                || !self.ends_stay(&self.steps[first], self.steps[back].ends_at())
            {
                return None;
            }
            let after_way_back = || {
                if count < 4 {
                    return None;
                }
                let Exchanged {
                    shooting,
                    guess,
                    numbers,
                    ..
                } = self.exchanged(at, back).ok()?;
                let first = *numbers.get(first)?;
                (shooting.comes_back(first)).then_some((shooting, guess, first))
            };
            // What only a state on that side asks for is not met after it.
            let without = || self.stay_without_corner(at, first);
            after_way_back().or_else(without)
        })
    }

    /// Whether such a stay, which this event is part of, takes no time any more but for rounding.
    pub(super) fn stay_with_corner_vanishes(&self, at: &[f64], event: usize) -> bool {
        let known = self.with_corner_after_stay(at, event);
        known.is_some_and(|(stays, at, _)| stays.stay_that_vanishes(&at).is_some())
    }

    /// The same orbit without a corner within the stay after a crossing: of no time, with which it is nothing.
    fn stay_without_corner(&self, at: &[f64], first: usize) -> Option<(Self, Vec<f64>, usize)> {
        let mut steps = self.current_steps(at);
        let (corner, first) = self.take_out_after(at, &mut steps, first).ok()?;
        let stay = around(first, 1, steps.len());
        steps[stay].duration = steps[stay].duration.abs() + corner.duration.abs();
        steps[stay].start = corner.start;
        let (mut shooting, guess) = self.like(steps, at).ok()?;
        shooting.evaluate(&guess).ok()?;
        shooting
            .comes_back(first)
            .then_some((shooting, guess, first))
    }

    /// The same orbit that only touches where it crosses at the end of a step and comes back, and the step that ends there.
    pub(in crate::analysis::periodic) fn without_way_back(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let (stay, index) = self.take_out_after(at, &mut steps, index)?;
        steps[index].duration += 0.5 * stay.duration;
        steps[index].closed = stay.closed;
        let next = around(index, 1, steps.len());
        steps[next].start.clone_from(&stay.start);
        steps[next].duration += 0.5 * stay.duration;
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// Whether a step begins on the surface of a guard, which it has just crossed.
    pub(in crate::analysis::periodic) fn begins_at(&self, index: usize, guard: GuardKind) -> bool {
        let before = self.steps[self.before(index)].ends_at();
        guard.opposite().is_some() && before == guard.opposite()
    }

    /// The mode across a surface from where a step came to it, where it slides along it.
    pub(super) fn mode_across(&self, index: usize, guard: GuardKind) -> Option<usize> {
        let GuardKind::Switch(surface) = guard else {
            return None;
        };
        let system = &self.workshop.system;
        let (_, came, _) = system.origin_of(self.steps[self.before(index)].mode())?;
        let (grip, sides, _) = system.origin_of(self.steps[index].mode())?;
        let across = match (came.get(surface), sides.get(surface)) {
            (Side::Above, Side::Sliding) => Side::Below,
            (Side::Below, Side::Sliding) => Side::Above,
            _ => return None,
        };
        Some(system.meet(grip, sides.with(surface, across)))
    }

    /// Whether a step leads back to the surface that it has just crossed, to slide along it.
    fn leads_back_onto(&self, index: usize) -> bool {
        let Some(guard @ GuardKind::Switch(surface)) = self.steps[index].ends_at() else {
            return false;
        };
        let next = &self.steps[self.after(index)];
        self.slides_along(next, surface) && self.begins_at(index, guard)
    }

    /// Whether a step leads back to the surface that it has just crossed, to slide along it, and takes no time any more, but for rounding:
    /// its equations have a second solution there, of no time at all.
    pub(in crate::analysis::periodic) fn has_come_back(&self, at: &[f64], index: usize) -> bool {
        self.comes_back_within(at, (index, VANISHED))
    }

    /// The same of one that takes no more than such a part of the period.
    pub(in crate::analysis::periodic::branch) fn comes_back_within(
        &self,
        at: &[f64],
        (index, part): (usize, f64),
    ) -> bool {
        let place = self.duration_place(index);
        let duration = place.and_then(|place| at.get(place));
        self.leads_back_onto(index)
            && duration.is_some_and(|&duration| duration < part * self.period())
    }

    /// Of the steps that do so, and come to take no time along a curve, the shortest, if it takes no more than such a part of the period.
    pub(in crate::analysis::periodic::branch) fn way_onto_that_shrinks(
        &self,
        station: &Station,
        part: f64,
    ) -> Option<usize> {
        let shrinks = |index: &usize| {
            let place = self.duration_place(*index);
            place.is_some_and(|place| station.tangent[place] < 0.0)
        };
        let lasts = |index: usize| self.duration_place(index).map(|place| station.at[place]);
        let within = |index: &usize| self.comes_back_within(&station.at, (*index, part));
        let all = (0..self.steps.len()).filter(within).filter(shrinks);
        all.min_by(|&a, &b| {
            lasts(a)
                .partial_cmp(&lasts(b))
                .unwrap_or(core::cmp::Ordering::Equal)
        })
    }

    /// The same of any step.
    pub(in crate::analysis::periodic::branch) fn comes_back_at_once(&self, at: &[f64]) -> bool {
        (0..self.steps.len()).any(|index| self.has_come_back(at, index))
    }

    /// The same orbit with the rate of that guard where the step begins for a function that may vanish: beyond, the flow of both sides
    /// leads to the surface, and slides. The step that it belongs to.
    pub(in crate::analysis::periodic::branch) fn with_turn_at_start(
        &self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let mode = self.mode_across(index, guard);
        let begins = Step {
            passage: Passage::AtOnce(LegKind {
                mode: mode.unwrap_or(steps[index].mode()),
                ends_at: Some(guard),
                jump: Jump::None,
            }),
            duration: 0.0,
            closed: self.closed_before(index),
            told: Vec::new(),
            ..steps[index].clone()
        };
        steps.insert(index, begins);
        let (shooting, at) = self.like(steps, at)?;
        Ok((shooting, at, index))
    }

    /// The same orbit without such a step, and the step that slides from there.
    pub(in crate::analysis::periodic) fn without_way_onto(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        steps.remove(index);
        let index = if index < steps.len() { index } else { 0 };
        let (shorter, at) = self.like(steps, at)?;
        Ok((shorter, at, index))
    }

    /// The same orbit without such a step, and where that takes no time at all: the flow on the other side of the surface that is slid along
    /// from there turns back to it.
    pub(in crate::analysis::periodic::branch) fn without_stay(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<Touched, String> {
        let told = |error: PeriodicError| error.to_string();
        let guard = self.steps[index].ends_at().ok_or("a stay without end")?;
        if let Some(touched) = self.without_stays(at, (index, guard)) {
            return Ok(touched);
        }
        let (shorter, at, index) = self.without_way_onto(at, index).map_err(told)?;
        shorter.turned_at_start(&at, (index, guard))
    }

    /// Where the flow turns back to a surface that is crossed as a step begins: the rate of its guard vanishes there.
    pub(in crate::analysis::periodic::branch) fn turned_at_start(
        &self,
        at: &[f64],
        begins: (usize, GuardKind),
    ) -> Result<Touched, String> {
        let turn = self.with_turn_at_start(at, begins);
        let turn = turn.map_err(|error| error.to_string())?;
        let (start, scales) = (turn.1.clone(), turn.0.scales().to_vec());
        let touched = Touched::solve(turn)?;
        if moved(&touched.at, &start, &scales) > THERE {
            return Err("where a flow turns back only another place is found".to_owned());
        }
        Ok(touched)
    }

    /// Where the least value of a guard on a step vanishes: as the step begins if that is just beyond its surface, where with the way to that value for an
    /// unknown the root would be twofold. The flow may turn back there elsewhere, too, which is another touch.
    pub(in crate::analysis::periodic::branch) fn touched_or_turned(
        &self,
        at: &[f64],
        (index, least): (usize, &Least),
    ) -> Result<Touched, String> {
        let touched = self.touched(at, (index, least));
        if !self.begins_at(index, least.guard) {
            return touched;
        }
        let Ok(turned) = self.turned_at_start(at, (index, least.guard)) else {
            return touched;
        };
        let off = |found: &Touched| found.at.last().zip(at.last()).map(|(a, b)| (a - b).abs());
        let is_farther = |touched: &Touched| off(&turned) > off(touched).map(|off| FARTHER * off);
        match touched {
            Ok(touched) if is_farther(&touched) => Ok(touched),
            _ => Ok(turned),
        }
    }

    /// Where the least value that a guard has on a step vanishes.
    pub(super) fn touched(
        &self,
        at: &[f64],
        (index, least): (usize, &Least),
    ) -> Result<Touched, String> {
        let longer = self.with_event(at, index, least);
        Touched::solve(longer.map_err(|error| error.to_string())?)
    }

    /// The same without another that is over as well, and where both take no time at all at once.
    fn without_stays(&self, at: &[f64], (index, guard): (usize, GuardKind)) -> Option<Touched> {
        let lasts = |index: usize| self.duration_place(index).map(|place| at[place]);
        let most = TOGETHER * lasts(index)?;
        let mut others = (0..self.steps.len()).filter(|&other| {
            let as_long = lasts(other).is_some_and(|duration| duration <= most);
            other != index && as_long && self.leads_back_onto(other)
        });
        let other = others.next().filter(|_| others.next().is_none())?;
        let (first, last) = (index.min(other), index.max(other));
        let (fewer, guess, _) = self.without_way_onto(at, last).ok()?;
        let (fewer, guess, _) = fewer.without_way_onto(&guess, first).ok()?;
        // The step after each is where it was, less those that have gone before it.
        let slides = around(index - usize::from(other < index), 0, fewer.steps.len());
        let turn = fewer.with_turn_at_start(&guess, (slides, guard)).ok()?;
        Touched::solve_turn(turn)
            .ok()
            .filter(|touched| touched.together.is_some())
    }

    /// The same orbit with a stay of this duration at the surface that the end of a step touches, and where its duration stands among
    /// the unknowns.
    pub(in crate::analysis::periodic) fn with_stay(
        &self,
        at: &[f64],
        (index, stay, duration): (usize, Stay, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let Passage::Leg(kind) = steps[index].passage else {
            return Err(unfollowed("a touch that ends no leg"));
        };
        let guard = (kind.ends_at).ok_or_else(|| unfollowed("a touch of nothing"))?;
        let next = self.after(index);
        let parameters = self.workshop.parameters(self.free(at));
        let model = &self.workshop.model;
        let touch = steps[next].start.clone();
        let (mode, pieces) = self.other_side(at, (&steps[index], guard, stay), &touch)?;
        let ends_at = match (stay, guard) {
            (Stay::On, GuardKind::Switch(surface)) => {
                let origin = self.workshop.system.origin_of(kind.mode);
                origin.map(|(_, sides, _)| GuardKind::Leave(surface, sides.get(surface)))
            }
            _ => guard.opposite(),
        };
        // A moment before, and after: the field is continuous.
        let moved = |by: f64| -> Vec<f64> {
            let rate = |state: &crate::model::State| {
                model.graph.evaluate(state.derivative, &touch, &parameters)
            };
            (touch.iter().zip(&model.states))
                .map(|(x, state)| x + by * rate(state))
                .collect()
        };
        // After the last step it is a turn later than the first node.
        let before = moved(-0.5 * duration);
        let before = match next {
            0 => {
                let turns = self.workshop.closure.turns::<f64>(&parameters)?;
                Closure::later(&turns, &self.counts, &before)
            }
            _ => before,
        };
        let stay = Step {
            passage: Passage::Leg(LegKind {
                mode,
                ends_at,
                jump: Jump::None,
            }),
            pieces,
            start: before,
            duration,
            ..steps[index].clone()
        };
        steps[next].start = moved(0.5 * duration);
        steps[index].duration -= 0.5 * duration;
        steps[next].duration -= 0.5 * duration;
        steps.insert(index + 1, stay);
        let (shooting, at) = self.like(steps, at)?;
        let place = shooting.duration_place(index + 1);
        let place = place.ok_or_else(|| unfollowed("a stay without duration"))?;
        Ok((shooting, at, place))
    }

    /// The same orbit with whatever else touches a surface where the step before this one's end does, as on an orbit with a symmetry, and the steps
    /// that end with a touch, the later ones first.
    fn with_all_touches(self, (at, index): (Vec<f64>, usize)) -> (Self, Vec<f64>, Vec<usize>) {
        let (mut shooting, mut at, mut all) = (self, at, vec![index]);
        for _ in 0..shooting.steps.len() {
            let known = shooting.evaluate(&at).and_then(|_| shooting.least(&at));
            let least = known.unwrap_or_default().into_iter().enumerate();
            let mut others = least.flat_map(|(k, of)| of.into_iter().map(move |least| (k, least)));
            let other = others.find(|(k, least)| {
                let is_kind = Some(least.guard) == shooting.steps[all[0]].ends_at();
                let lasts = shooting.latest[*k].duration;
                let is_inside =
                    least.time > NO_TIME * lasts && least.time < (1.0 - NO_TIME) * lasts;
                let is_zero = least.value.abs() <= TOUCHES * least.size.abs();
                is_kind && !least.at_end && is_inside && is_zero
            });
            let longer = other.map(|(k, least)| shooting.with_event(&at, k, &least));
            let Some(Ok((longer, guess, k))) = longer else {
                break;
            };
            for known in &mut all {
                *known += usize::from(*known >= k);
            }
            all.push(k);
            (shooting, at) = (longer, guess);
        }
        all.sort_unstable_by(|a, b| b.cmp(a));
        (shooting, at, all)
    }

    /// The same orbit with stays of this duration at all such touches, and where that of the first in the cycle stands among the unknowns.
    fn with_stays(
        &self,
        at: &[f64],
        (touches, stay, duration): (&[usize], Stay, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut found = None;
        for &index in touches {
            let (shooting, at) = found
                .as_ref()
                .map_or((self, at), |(shooting, at, _): &(Self, Vec<f64>, usize)| {
                    (shooting, at)
                });
            found = Some(shooting.with_stay(at, (index, stay, duration))?);
        }
        found.ok_or_else(|| unfollowed("a touch of nothing"))
    }
}

/// Where a guard has a least value of zero: the equations with that for an event, and their solution.
#[derive(Clone)]
pub(in crate::analysis::periodic::branch) struct Touched {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
    /// The same as well as it is known.
    pub told: Vec<f64>,
    /// The step that ends there.
    pub index: usize,
    pub residual: f64,
    pub correction: f64,
    /// Of the parameter.
    pub error: f64,
    /// With the other one, where two come at once.
    pub together: Option<Together>,
}

impl Touched {
    /// Its equations, their solution, and the step that ends at the touch.
    pub(in crate::analysis::periodic::branch) fn place(&self) -> (&Shooting<f64>, &[f64], usize) {
        (&self.shooting, &self.told, self.index)
    }

    /// The orbit there, beside a station.
    pub(in crate::analysis::periodic::branch) fn point(&mut self, beside: &Station) -> Point {
        let station = Station {
            at: self.at.clone(),
            residual: self.residual,
            correction: self.correction,
            ..beside.clone()
        };
        Point::new(&mut self.shooting, &station)
    }

    /// From a guess of where the event at the end of a step only touches.
    pub(in crate::analysis::periodic::branch) fn solve(
        (mut shooting, guess, index): (Shooting<f64>, Vec<f64>, usize),
    ) -> Result<Self, String> {
        let found = shooting.solved(&Bordered::Monitor(index), &guess);
        let found = found.map_err(|error| error.to_string())?;
        Ok(Self {
            shooting,
            at: found.at,
            told: found.told,
            index,
            residual: found.residual,
            correction: found.correction,
            error: found.error,
            together: None,
        })
    }
}

impl Walker {
    /// Notes a touch that the branch has passed, with its own equations.
    pub(in crate::analysis::periodic::branch) fn note_passed_touch(
        &mut self,
        there: &Point,
        touched: Touched,
    ) {
        self.note_touch(there, touched);
        if let Some(special) = self.special.last_mut() {
            special.persists = Some(true);
        }
    }

    /// Notes a touch with its own equations: in place of the latest special point, if that is the same touch, which nothing has come of.
    pub(in crate::analysis::periodic::branch) fn note_touch(
        &mut self,
        there: &Point,
        touched: Touched,
    ) {
        if self.has_told(touched.place(), touched.error) {
            self.special.pop();
        }
        let is_slow = self.shooting.crosses_slowly();
        let own = core::mem::replace(&mut self.shooting, touched.shooting);
        self.note(
            SpecialKind::Touch,
            there,
            &touched.told,
            touched.error,
            touched.residual,
        );
        if is_slow {
            self.tell_no_multipliers();
        }
        self.shooting = own;
    }

    /// A flight touches a surface: a stay at it comes in. The new equations, at their first station.
    pub(super) fn crosses(
        &mut self,
        station: &Station,
        (index, touching): (usize, &Least),
        there: &Point,
    ) -> Result<Station, String> {
        let told = |error: &dyn core::fmt::Display| error.to_string();
        let longer = self.shooting.with_event(&station.at, index, touching);
        let longer = longer.map_err(|error| told(&error))?;
        let (guess, scales) = (longer.1.clone(), longer.0.scales().to_vec());
        let touched = Touched::solve(longer)?;
        if moved(&touched.at, &guess, &scales) > THERE {
            return Err("where a surface is touched only another place is found".to_owned());
        }
        let (mut touch, at, index) = (touched.shooting.clone(), touched.at.clone(), touched.index);
        self.note_touch(there, touched);
        let there = self.special.last().map(|special| special.point.clone());
        touch.evaluate(&at).map_err(|left| told(&left))?;
        let period = touch.period();
        // Where other places touch at once, as on an orbit with a symmetry, a stay at each of them: with one alone orbits without it may leave there.
        // Or one stay alone.
        let (all_touch, at_all, all) = touch.clone().with_all_touches((at.clone(), index));
        let alone = (&touch, &at, vec![index]);
        let together = (all.len() > 1).then_some((&all_touch, &at_all, all));
        let mut failed: Option<NewtonError> = None;
        let ways = together.into_iter().chain([alone]);
        let ways = ways.flat_map(|way| [Stay::Beyond, Stay::On].map(|stay| (way.clone(), stay)));
        for (((touch, at, touches), stay), part) in
            ways.flat_map(|way| STAYS.map(|part| (way.clone(), part)))
        {
            let with = (&*touches, stay, part * period);
            let Ok((mut longer, guess, place)) = touch.with_stays(at, with) else {
                continue;
            };
            let fixed = Condition::fixed(guess.len(), place, guess[place]);
            let stays = match newton(&mut longer, &guess, core::slice::from_ref(&fixed)) {
                Ok(stays) => stays,
                Err(error) => {
                    failed = Some(error);
                    continue;
                }
            };
            // What is solved elsewhere has nothing to do with the touch, and what is solved by no motion is none.
            let is_there = moved(&stays.at, &guess, longer.scales()) <= THERE
                && sequence_holds(&mut longer, &stays.at);
            if !is_there {
                continue;
            }
            let along = tangent(&mut longer, &stays.at, &fixed.row);
            let next = Station::beginning(stays, along.map_err(|error| told(&error))?);
            self.shooting = longer;
            if let Some(there) = there {
                self.look_back(&next, (place, &there));
            }
            return Ok(next);
        }
        Err(match failed {
            Some(error) => format!("a surface is touched, and beyond {error}"),
            None => "a surface is touched, and no stay at it begins there".to_owned(),
        })
    }

    /// Special points between a touch and the first station beyond it, whose stay shrinks to nothing on the way back.
    fn look_back(&mut self, first: &Station, (stay, touch): (usize, &Point)) {
        let reach = first.at[stay] / first.tangent[stay];
        let back = match reach > 0.0 {
            true => first.clone().reversed(),
            false => first.clone(),
        };
        self.settle(first);
        let here = Point::new(&mut self.shooting, first);
        let mut to = back.clone();
        for (x, by) in to.at.iter_mut().zip(&back.tangent) {
            *x += reach.abs() * by;
        }
        self.between(&back, &to, reach.abs(), (&here, touch));
    }
}
