//! What a trajectory settles to: the latest return to where it was.

use super::events::single;
use super::itinerary::{Step, around, is_several, read, struck};
use super::left::touched_at_rest;
use super::reread::from_early_on;
use super::rotate::{past_instant, rotate};
use super::trace::{Instant, PAST, Tracer, forget_past, leave_out_crossings};
use crate::analysis::periodic::closure::{Closure, Turn};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Shooting, Workshop, take_in_moves, without_zeros};
use crate::flow::GuardKind;
use crate::numerics::stored::number;
use core::ops::ControlFlow;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A cycle as far as a trajectory shows it.
#[derive(Clone, Debug)]
pub(crate) struct Cycle {
    pub steps: Vec<Step>,
    pub counts: Vec<i64>,
    /// How far from closed it is, against the size of the state.
    pub distance: f64,
    /// The size of each state that tells so: on the motion that led there, which need not be its size on the cycle.
    pub sizes: Vec<f64>,
}

/// A cycle has drifted far if it has gone so many times as far as it goes itself.
const DRIFTED: f64 = 8.0;

impl Cycle {
    /// How long it takes.
    pub(crate) fn duration(&self) -> f64 {
        self.steps.iter().map(|step| step.duration).sum()
    }

    /// Takes the cycle back to where states that nothing depends on are zero, where it has drifted so far from there that what they do on it
    /// is little beside: their sizes are of its motion, not of its way there.
    pub(crate) fn come_back(&mut self, workshop: &Workshop) {
        let Some(first) = self.steps.first().map(|step| step.start.clone()) else {
            return;
        };
        // Counters tell by what they are which side holds.
        let model = &workshop.model;
        let moves = |state: usize| {
            !model
                .graph
                .symbols(model.states[state].derivative)
                .is_empty()
        };
        let is_place = |state: usize| moves(state) && !workshop.closure.is_phase(state);
        let idle = workshop.closure.idle.iter();
        for free in idle.filter(|free| is_place(free.state)) {
            let gone = first[free.state];
            let on = |step: &Step| (step.start[free.state] - gone).abs();
            let span = self.steps.iter().map(on).fold(0.0, f64::max);
            if gone.abs() > DRIFTED * span && span > 0.0 {
                for step in &mut self.steps {
                    free.carry(&mut step.start, -gone);
                }
            }
        }
    }

    /// Begins the cycle at the section, if it is crossed.
    pub(crate) fn begin_at_section(
        &mut self,
        workshop: &Workshop,
        parameters: &[f64],
    ) -> Result<(), PeriodicError> {
        let Some(section) = workshop.section else {
            return Ok(());
        };
        let ends_there = |step: &Step| step.ends_at() == Some(GuardKind::Section(section));
        let Some(index) = self.steps.iter().position(ends_there) else {
            return Ok(());
        };
        let moved = around(index, 1, self.steps.len());
        let cycle = (&mut *self.steps, &*self.counts);
        rotate(workshop, parameters, cycle, moved)
    }
}

/// How long a trajectory is followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patience {
    /// Events, at most.
    pub events: usize,
    /// Periods of the forcing, at most.
    pub periods: usize,
    /// Time, at most; where the motion's own time is longer than one, in units of that.
    #[serde(with = "number")]
    pub time: f64,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            events: 200_000,
            periods: 5_000,
            time: 1e6,
        }
    }
}

/// A return this near is one; others are tried where time runs out.
const NEAR: [f64; 4] = [1e-9, 1e-6, 1e-4, 1e-2];
/// A return that is not as near as the first of these is none after more instants: the equations of so long a cycle take minutes, and
/// what has not settled is nearer to a shorter one.
const MOST_LOOSE: usize = 240;
/// Between looks: events, twice as many from one look to the next, and periods of the forcing.
const FIRST_CHUNK: usize = 16;
const CHUNK: usize = 600;
const PERIODS: usize = 40;
/// A motion whose states have all become so small a part of the greatest goes to rest at zero.
pub(super) const DIED_OUT: f64 = 1e-15;
/// Longer cycles are not looked for, in periods of the forcing.
const LONGEST: usize = 64;

/// Sizes of states.
pub(super) fn sizes<'s>(
    states: impl IntoIterator<Item = &'s Vec<f64>>,
    turns: &[Turn<f64>],
) -> Vec<f64> {
    let mut sizes: Vec<f64> = Vec::new();
    for state in states {
        sizes.resize(state.len(), 0.0);
        for (size, x) in sizes.iter_mut().zip(state) {
            *size = size.max(x.abs());
        }
    }
    for turn in turns {
        sizes[turn.state] = turn.period;
    }
    without_zeros(sizes)
}

/// The states of instants.
pub(super) fn states(instants: &[Instant]) -> impl Iterator<Item = &Vec<f64>> {
    instants.iter().map(|instant| &instant.state)
}

/// Events whose times differ by so many roundoffs may share an instant.
const ONE_INSTANT: f64 = 8.0;

/// The instants that may tell returns, the best first: the latest crossing of the section, the latest release, the fastest impact of
/// late, and, without any of the latter two, the latest of all others that shares its time with none.
fn landmarks(instants: &[Instant], section: Option<usize>) -> Vec<usize> {
    let late = instants.len() / 2;
    let crossed = section.and_then(|section| {
        instants
            .iter()
            .rposition(|instant| instant.crosses(section))
    });
    // Where a release shares its instant with something else, no step ends.
    let released = (instants.iter())
        .rposition(|instant| instant.is_release() && single(instant).is_some())
        .or_else(|| instants.iter().rposition(Instant::is_release));
    // Where several contacts collide may be the middle of their chatter.
    let several = |at: &Instant| is_several(struck(core::slice::from_ref(at), at.time));
    let by_itself = |at: &Instant| at.impact().is_some() && !several(at);
    let is_known = instants[late..].iter().any(by_itself);
    let rate = |at: &Instant| {
        let (_, rate) = at.impact()?;
        (!is_known || by_itself(at)).then_some(rate)
    };
    let fastest = (instants.iter().enumerate().skip(late))
        .filter_map(|(index, instant)| Some((index, rate(instant)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .and_then(|(_, fastest)| {
            // The latest that is as fast.
            instants.iter().rposition(|instant| {
                rate(instant).is_some_and(|other| other <= fastest * (1.0 - 1e-6))
            })
        });
    let mut found: Vec<usize> = [crossed, released, fastest].into_iter().flatten().collect();
    found.dedup();
    if released.or(fastest).is_none() {
        let crosses = |index: usize| section.is_some_and(|s| instants[index].crosses(s));
        let shares = |(a, b): (usize, usize)| match (instants.get(a), instants.get(b)) {
            (Some(a), Some(b)) => {
                (a.time - b.time).abs() <= ONE_INSTANT * f64::EPSILON * b.time.abs()
            }
            _ => false,
        };
        let is_last = |index: &usize| !shares((index + 1, *index));
        let is_alone = |index: &usize| {
            !crosses(*index)
                && is_last(index)
                && !index
                    .checked_sub(1)
                    .is_some_and(|before| shares((before, *index)))
        };
        let latest = instants.len().checked_sub(1);
        // Of those that share an instant the last, which what comes after it tells.
        let whole = (0..latest.unwrap_or(0)).rev().find(is_last);
        let alone = (0..instants.len())
            .rev()
            .find(is_alone)
            .or(whole)
            .or(latest);
        found.extend(alone.filter(|alone| !found.contains(alone)));
    }
    found
}

/// What one landmark tells as a return is none where another tells one in less than this part of the time: where events share an instant, which
/// of them comes first is rounding, and differs from turn to turn.
const SOONER: f64 = 0.75;
/// The others may be so many times as far apart.
const LOOSER: f64 = 10.0;

/// The instants of the latest return nearer than `near`; otherwise how near the nearest is. The last instant may have more to tell, such
/// as the surface that a reset takes the state across, and then is like none before it.
fn latest_return(
    workshop: &Workshop,
    turns: &[Turn<f64>],
    (instants, section): (&[Instant], Option<usize>),
    near: (&[f64], f64),
) -> Result<(usize, usize), f64> {
    let found = return_among(workshop, turns, (instants, section), near);
    match (&found, instants) {
        (Err(nearest), [complete @ .., _]) if nearest.is_infinite() => {
            return_among(workshop, turns, (complete, section), near)
        }
        _ => found,
    }
}

fn return_among(
    workshop: &Workshop,
    turns: &[Turn<f64>],
    (instants, section): (&[Instant], Option<usize>),
    (sizes, near): (&[f64], f64),
) -> Result<(usize, usize), f64> {
    let mut nearest = f64::INFINITY;
    let mut found: Option<(usize, usize)> = None;
    let time = |(first, last): (usize, usize)| instants[last].time - instants[first].time;
    for last in landmarks(instants, section) {
        // What is settling is no nearer after one turn than after several.
        let near = if found.is_some() { LOOSER * near } else { near };
        let earliest = if near > NEAR[0] {
            last.saturating_sub(MOST_LOOSE)
        } else {
            0
        };
        for first in (earliest..last).rev() {
            let (a, b) = (&instants[first], &instants[last]);
            let is_alike =
                a.guard == b.guard && a.mode_after == b.mode_after && a.told.len() == b.told.len();
            if !is_alike {
                continue;
            }
            let difference = (workshop.closure).difference(turns, (&a.state, &b.state), sizes);
            // What dies out comes back to nothing, and not to where it was. Where states that nothing depends on have got to says nothing.
            let held = |index: usize| !workshop.closure.is_carried(index);
            let [before, now] = [a, b].map(|instant| size(&instant.state, held));
            let shrinks = turns.is_empty() && (before / now - 1.0).abs() > near.sqrt();
            if difference.distance <= near && !shrinks {
                if found.is_none_or(|known| time((first, last)) < SOONER * time(known)) {
                    found = Some((first, last));
                }
                break;
            }
            nearest = nearest.min(difference.distance);
        }
    }
    found.ok_or(nearest)
}

/// Tells steps from the first turn of each phase, where phases have most digits and change least with their rate; a phase that goes
/// round no times from the turn nearest to zero. Pieces of lookups are numbered on from turn to turn: where there are any,
/// phases stay what they are.
pub(crate) fn from_first_turn(steps: &mut [Step], turns: &[Turn<f64>], counts: &[i64]) {
    if steps.iter().any(|step| !step.pieces.is_empty()) {
        return;
    }
    for (turn, &count) in turns.iter().zip(counts) {
        let first = steps.first().map_or(0.0, |step| step.start[turn.state]) / turn.period;
        let whole = if count == 0 {
            first.round()
        } else {
            first.floor()
        };
        for step in &mut *steps {
            step.start[turn.state] -= whole * turn.period;
        }
    }
}

/// Whether a state is a phase.
pub(super) fn is_phase(turns: &[Turn<f64>], index: usize) -> bool {
    turns.iter().any(|turn| turn.state == index)
}

/// The largest entry of a state among those that count.
fn size(state: &[f64], counts: impl Fn(usize) -> bool) -> f64 {
    let all = state.iter().enumerate();
    all.filter(|(index, _)| counts(*index))
        .fold(0.0, |size, (_, x)| size.max(x.abs()))
}

/// The most that each state has been on a motion.
pub(super) struct Most(pub Vec<f64>);

impl Most {
    fn take_in<'s>(&mut self, states: impl IntoIterator<Item = &'s Vec<f64>>) {
        for state in states {
            for (most, x) in self.0.iter_mut().zip(state) {
                *most = most.max(x.abs());
            }
        }
    }

    /// Sizes of states on what may be a cycle: of what has died out there is nothing left that would tell how near two states are.
    fn sizes<'s>(
        &self,
        states: impl IntoIterator<Item = &'s Vec<f64>>,
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let mut sizes = sizes(states, turns);
        for (size, most) in sizes.iter_mut().zip(&self.0) {
            *size = size.max(DIED_OUT * most);
        }
        sizes
    }

    /// The same: a state that is zero at all of them has the size of how far it moves in the time from each to the next.
    fn sizes_along(
        &self,
        (workshop, parameters): (&Workshop, &[f64]),
        ways: &[(&Vec<f64>, f64)],
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let mut sizes = self.sizes(ways.iter().map(|(state, _)| *state), turns);
        let ways = ways.iter().map(|&(state, time)| (&**state, time));
        take_in_moves(&mut sizes, (&workshop.model, parameters), ways);
        for turn in turns {
            sizes[turn.state] = turn.period;
        }
        sizes
    }

    /// The same at instants.
    fn sizes_at(
        &self,
        known: (&Workshop, &[f64]),
        instants: &[Instant],
        turns: &[Turn<f64>],
    ) -> Vec<f64> {
        let times = instants.windows(2).map(|pair| pair[1].time - pair[0].time);
        let ways = instants.iter().zip(times.chain([0.0]));
        let ways: Vec<_> = ways.map(|(at, time)| (&at.state, time)).collect();
        self.sizes_along(known, &ways, turns)
    }
}

/// Whether the latest of these states is next to nothing, against the most that states have been, and phases go round no more; as far
/// as what happens depends on them.
fn is_next_to_nothing(
    instants: &[Instant],
    (turns, matters): (&[Turn<f64>], &[bool]),
    most: &Most,
) -> bool {
    let [.., before, latest] = instants else {
        return false;
    };
    let stands = |turn: &Turn<f64>| {
        let turned = latest.state[turn.state] - before.state[turn.state];
        turned.abs() <= DIED_OUT * turn.period
    };
    let size_seen = |state: &[f64]| size(state, |index| matters[index] && !is_phase(turns, index));
    // Zero itself is what a reset makes of a state.
    let here = size_seen(&latest.state);
    let mut seen = turns.iter().filter(|turn| matters[turn.state]);
    here > 0.0 && here <= DIED_OUT * size_seen(&most.0) && seen.all(stands)
}

/// The cycle between two instants, where states have these sizes.
fn cycle(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    instants: &[Instant],
    sizes: &[f64],
) -> Result<Cycle, PeriodicError> {
    let mut steps = read((&workshop.system, parameters), instants)?;
    let (first, last) = (&instants[0].state, &instants[instants.len() - 1].state);
    let difference = workshop.closure.difference(turns, (first, last), sizes);
    past_instant(workshop, parameters, (&mut steps, &difference.turns))?;
    from_first_turn(&mut steps, turns, &difference.turns);
    Ok(Cycle {
        steps,
        counts: difference.turns,
        distance: difference.distance,
        sizes: sizes.to_vec(),
    })
}

/// The cycle between two instants, where only it says what sizes states have.
fn alone(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    instants: &[Instant],
) -> Result<Cycle, PeriodicError> {
    let sizes = sizes(states(instants), turns);
    cycle((workshop, parameters), turns, instants, &sizes)
}

/// What the trajectory from a state settles to. Crossings of the section count as events where nothing else happens and nothing else says how
/// long a period is.
pub(crate) fn settle(
    workshop: &Workshop,
    free: &[f64],
    state: &[f64],
    patience: Patience,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Cycle, PeriodicError> {
    let parameters = workshop.parameters(free);
    let turns = workshop.closure.turns(&parameters)?;
    let forcing = workshop.closure.forcing(&parameters);
    let section = workshop.section_as_event(&parameters);
    let start = workshop.model.time.map_or(0.0, |index| state[index]);
    let mut tracer = Tracer::new(&workshop.system, &parameters, state, section)?;
    let returned = |instants: &[Instant], (first, last): (usize, usize), sizes: &[f64]| {
        let found = cycle(
            (workshop, &parameters),
            &turns,
            &instants[first..=last],
            sizes,
        )?;
        Ok(from_early_on(workshop, free, &turns, found))
    };
    let mut instants: Vec<Instant> = Vec::new();
    let mut strobes: Vec<Vec<f64>> = vec![state.to_vec()];
    let mut total = 0;
    let mut most = Most(state.iter().map(|x| x.abs()).collect());
    let mut chunk = FIRST_CHUNK;
    // Since the latest event.
    let mut quiet = 1;
    let mut nearest = f64::INFINITY;
    let mut limit = start + patience.time;
    let end = loop {
        match forcing {
            Some(period) => {
                // A look at whole periods, whatever happens between.
                for _ in 0..PERIODS {
                    let until = start + period * strobes.len() as f64;
                    let before = instants.len();
                    tracer.follow((until, usize::MAX / 2), &mut instants, observer)?;
                    total += instants.len() - before;
                    if instants.len() > before {
                        quiet = 0;
                    }
                    most.take_in(states(&instants[before..]));
                    strobes.push(tracer.trajectory.state().to_vec());
                    most.take_in(strobes.last());
                    quiet += 1;
                }
            }
            None => {
                let before = instants.len();
                tracer.follow((limit, chunk), &mut instants, observer)?;
                if chunk == FIRST_CHUNK {
                    limit = start + patience.time * tracer.trajectory.pace();
                    let missing = (before + chunk).saturating_sub(instants.len());
                    if missing > 0 && tracer.trajectory.time() < limit {
                        tracer.follow((limit, missing), &mut instants, observer)?;
                    }
                }
                total += instants.len() - before;
                most.take_in(states(&instants[before..]));
                if is_next_to_nothing(&instants[before..], (&turns, &workshop.matters), &most) {
                    let time = tracer.trajectory.time();
                    let rest = workshop.matters.iter().map(|matters| !matters);
                    let others_move =
                        tracer.moves((NEAR[1], &rest.collect::<Vec<_>>()), observer)?;
                    return Err(comes_to_rest(time, !others_move));
                }
                let quiet = instants.last().map_or(start, |instant| instant.time);
                let all = tracer.trajectory.time() - start;
                let is_past = tracer.trajectory.time() - quiet > PAST * all;
                if instants.len() - before < chunk && is_past {
                    let all = vec![true; state.len()];
                    let goes_on = tracer.moves((NEAR[1], &all), observer)?;
                    return Err(comes_to_rest(quiet, !goes_on));
                }
                chunk = (2 * chunk).min(CHUNK);
            }
        }
        if let (Some(_), Some(latest)) = (forcing, strobes.last()) {
            let around = (latest, &*instants);
            let touched = touched_at_rest((workshop, &parameters), &turns, around, &most);
            if let Some(contact) = touched {
                return Err(PeriodicError::DiesOut {
                    contact: workshop.model.contacts[contact].name.clone(),
                });
            }
        }
        forget_past(&mut instants, section, (start, tracer.trajectory.time()));
        leave_out_crossings(&mut instants, section);
        let keep = instants.len().saturating_sub(4 * CHUNK);
        instants.drain(..keep);
        // What happened before motion came to rest, or left all contacts, is of the past.
        let is_quiet = forcing.is_some() && quiet > PERIODS;
        if is_quiet {
            let strobes = &strobes[strobes.len() - quiet..];
            if let Some(found) = timed(
                (workshop, &parameters, &turns),
                &tracer,
                strobes,
                (&most, NEAR[0]),
            ) {
                return Ok(found);
            }
        } else if !instants.is_empty() {
            let sizes = most.sizes_at((workshop, &parameters), &instants, &turns);
            // What happens just where a look ends may have more to tell.
            let now = tracer.trajectory.time();
            let is_over = |i: &Instant| now - i.time > ONE_INSTANT * f64::EPSILON * now.abs();
            let complete = match instants.iter().rposition(is_over) {
                Some(latest) if forcing.is_some() => &instants[..=latest],
                _ => &instants[..],
            };
            match latest_return(workshop, &turns, (complete, section), (&sizes, NEAR[0])) {
                Ok(ends) => return returned(&instants, ends, &sizes),
                Err(distance) => nearest = nearest.min(distance),
            }
        }
        let over = total >= patience.events
            || strobes.len() > patience.periods
            || (forcing.is_none() && tracer.trajectory.time() >= limit);
        if over || (forcing.is_none() && instants.is_empty()) {
            break tracer.trajectory.time();
        }
    };
    let is_quiet = forcing.is_some() && quiet > PERIODS;
    for near in &NEAR[1..] {
        if is_quiet {
            let strobes = &strobes[strobes.len() - quiet..];
            if let Some(found) = timed(
                (workshop, &parameters, &turns),
                &tracer,
                strobes,
                (&most, *near),
            ) {
                return Ok(found);
            }
        } else {
            let sizes = most.sizes_at((workshop, &parameters), &instants, &turns);
            let found = latest_return(workshop, &turns, (&instants, section), (&sizes, *near));
            if let Ok(ends) = found {
                return returned(&instants, ends, &sizes);
            }
        }
    }
    if forcing.is_none() && instants.len() < 2 {
        return Err(PeriodicError::Equilibrium {
            time: instants.last().map_or(start, |instant| instant.time),
        });
    }
    Err(PeriodicError::NotSettled { time: end, nearest })
}

/// Why a motion on which nothing happens from a time on has no period.
fn comes_to_rest(time: f64, rests: bool) -> PeriodicError {
    match rests {
        true => PeriodicError::Equilibrium { time },
        false => PeriodicError::Eventless { time },
    }
}

/// A cycle of so many periods of the forcing on which nothing happens.
fn timed(
    (workshop, parameters, turns): (&Workshop, &[f64], &[Turn<f64>]),
    tracer: &Tracer<'_>,
    strobes: &[Vec<f64>],
    (most, near): (&Most, f64),
) -> Option<Cycle> {
    let (last, earlier) = strobes.split_last()?;
    let period = workshop.closure.forcing(parameters)?;
    let latest = strobes.iter().rev().take(LONGEST);
    let ways: Vec<_> = latest.map(|state| (state, period)).collect();
    let sizes = most.sizes_along((workshop, parameters), &ways, turns);
    let mut candidates = earlier.iter().rev().take(LONGEST);
    candidates.find_map(|state| {
        let difference = (workshop.closure).difference(turns, (state, last), &sizes);
        let lap = Closure::time_of(turns, &difference.turns)?;
        let mut steps = vec![Step::timed(&tracer.trajectory, state.clone(), lap.time)];
        from_first_turn(&mut steps, turns, &difference.turns);
        (difference.distance <= near).then(|| Cycle {
            steps,
            counts: difference.turns.clone(),
            distance: difference.distance,
            sizes: sizes.clone(),
        })
    })
}

/// The cycles of up to so many periods of the forcing, or returns to the section or, without both, to an event, that a trajectory from a state would have if
/// they closed. Those `passed` over before are left out.
pub(crate) fn loops(
    workshop: &Workshop,
    free: &[f64],
    state: &[f64],
    (passed, periods): (usize, usize),
) -> Result<Loops, PeriodicError> {
    let parameters = workshop.parameters(free);
    let turns = workshop.closure.turns(&parameters)?;
    let forcing = workshop.closure.forcing(&parameters);
    let start = workshop.model.time.map_or(0.0, |index| state[index]);
    let section = workshop.section_as_event(&parameters);
    let mut tracer = Tracer::new(&workshop.system, &parameters, state, section)?;
    let mut instants = Vec::new();
    let mut quiet = |_: f64| ControlFlow::Continue(());
    let mut found = Vec::new();
    let standing = |tracer: &Tracer<'_>| {
        Step::timed(&tracer.trajectory, tracer.trajectory.state().to_vec(), 0.0)
    };
    let begins = standing(&tracer);
    match (forcing, section) {
        (Some(period), _) => {
            let until = start + period * (passed + 2 * periods + 1) as f64;
            tracer.follow((until, usize::MAX / 2), &mut instants, &mut quiet)?;
            let begin = start + period * passed as f64;
            for count in 1..=periods {
                let ends = (begin, begin + period * count as f64, period);
                if let Some((first, last)) = lap(&instants, ends) {
                    let mut cycle =
                        alone((workshop, &parameters), &turns, &instants[first..=last])?;
                    for (turns, turn) in cycle.counts.iter_mut().zip(&turns) {
                        if Some(turn.state) == workshop.closure.time {
                            *turns = count as i64;
                        }
                    }
                    found.push(cycle);
                }
            }
        }
        (None, Some(section)) => {
            let most = (passed + periods + 2) * CHUNK;
            let crossings = |instants: &[Instant]| -> Vec<usize> {
                (0..instants.len())
                    .filter(|&index| instants[index].crosses(section))
                    .collect()
            };
            // No longer than it takes: a motion that comes to rest crosses a section for ever.
            let mut chunk = FIRST_CHUNK;
            while instants.len() < most && crossings(&instants).len() <= passed + periods {
                let enough = instants.len() + chunk;
                tracer.follow((f64::MAX, chunk), &mut instants, &mut quiet)?;
                if instants.len() < enough {
                    break;
                }
                chunk = (2 * chunk).min(CHUNK);
            }
            let crossings = crossings(&instants);
            for count in 1..=periods {
                if let (Some(&first), Some(&last)) =
                    (crossings.get(passed), crossings.get(passed + count))
                {
                    let is_end = |index: &usize| [first, last].contains(index);
                    let happens =
                        |index: &usize| is_end(index) || !instants[*index].only_crosses(section);
                    let way = (first..=last).filter(happens);
                    let way: Vec<Instant> = way.map(|index| instants[index].clone()).collect();
                    found.push(alone((workshop, &parameters), &turns, &way)?);
                }
            }
        }
        (None, None) if workshop.is_map_by_events() => {
            // Events mark periods, each of its own: those that happen most seldom on an orbit.
            let most = (passed + periods + 2) * workshop.model.sections.len();
            tracer.follow((f64::MAX, most), &mut instants, &mut quiet)?;
            for event in 0..workshop.model.sections.len() {
                let met: Vec<usize> = (0..instants.len())
                    .filter(|&index| instants[index].crosses(event))
                    .collect();
                for count in 1..=periods {
                    if let (Some(&first), Some(&last)) = (met.get(passed), met.get(passed + count))
                    {
                        let between = &instants[first..=last];
                        found.push(alone((workshop, &parameters), &turns, between)?);
                    }
                }
            }
        }
        (None, None) => {
            // Nothing marks a period: the nearest returns of each passage, short ones first.
            let time = start + LOOSE_TIME * (passed + 1) as f64;
            tracer.follow((time, CHUNK), &mut instants, &mut quiet)?;
            for (first, last) in near_returns(workshop, &turns, &instants, periods) {
                found.push(alone(
                    (workshop, &parameters),
                    &turns,
                    &instants[first..=last],
                )?);
            }
        }
    }
    Ok(Loops {
        cycles: found,
        nothing_happens: instants.is_empty(),
        ends: [begins, standing(&tracer)],
    })
}

/// What a trajectory shows of cycles.
pub(crate) struct Loops {
    /// Those that it would go through if they closed.
    pub cycles: Vec<Cycle>,
    /// Whether nothing happens on it.
    pub nothing_happens: bool,
    /// Where it begins and ends, as steps on which nothing happens.
    ends: [Step; 2],
}

impl Loops {
    /// Cycles of up to so many periods of the forcing on which nothing happens, in the modes that the trajectory begins and ends in.
    pub(crate) fn quiet(
        &self,
        workshop: &Arc<Workshop>,
        free: &[f64],
        periods: usize,
    ) -> Vec<Cycle> {
        let parameters = workshop.parameters(free);
        let (Some(period), Ok(turns)) = (
            workshop.closure.forcing(&parameters),
            workshop.closure.turns(&parameters),
        ) else {
            return Vec::new();
        };
        let [begins, ends] = &self.ends;
        let differs = ends.mode() != begins.mode();
        let steps = core::iter::once(begins).chain(Some(ends).filter(|_| differs));
        let all = steps.flat_map(|step| (1..=periods).map(move |count| (step, count)));
        all.filter_map(|(step, count)| quiet(workshop, (free, &turns), step, period * count as f64))
            .collect()
    }
}

/// A cycle of this length on which nothing happens, as the smooth flow would have it.
fn quiet(
    workshop: &Arc<Workshop>,
    (free, turns): (&[f64], &[Turn<f64>]),
    step: &Step,
    length: f64,
) -> Option<Cycle> {
    let mut steps = vec![Step {
        duration: length,
        ..step.clone()
    }];
    let none = vec![0; turns.len()];
    let mut shooting = Shooting::<f64>::new(workshop, steps.clone(), none).ok()?;
    let image = shooting.flown_on(&shooting.guess(free), length)?;
    let sizes = sizes([&step.start, &image], turns);
    let difference = (workshop.closure).difference(turns, (&step.start, &image), &sizes);
    from_first_turn(&mut steps, turns, &difference.turns);
    Some(Cycle {
        steps,
        counts: difference.turns,
        distance: difference.distance,
        sizes,
    })
}

/// A loop that is to be closed comes back this near, against the size of the state.
const LOOSE: f64 = 0.2;
/// How long a trajectory is followed for loops where nothing says how long a period is.
const LOOSE_TIME: f64 = 100.0;

/// The nearest returns of the latest part of a trajectory to an instant of the same kind, no more than so many.
fn near_returns(
    workshop: &Workshop,
    turns: &[Turn<f64>],
    instants: &[Instant],
    most: usize,
) -> Vec<(usize, usize)> {
    let Some(&last) = landmarks(instants, None).first() else {
        return Vec::new();
    };
    let sizes = sizes(states(instants), turns);
    let end = &instants[last];
    let mut found: Vec<(usize, f64)> = (last.saturating_sub(MOST_LOOSE)..last)
        .filter(|&first| {
            let begin = &instants[first];
            begin.guard == end.guard && begin.mode_after == end.mode_after
        })
        .map(|first| {
            let pair = (&*instants[first].state, &*end.state);
            (
                first,
                workshop.closure.difference(turns, pair, &sizes).distance,
            )
        })
        .filter(|(_, distance)| *distance <= LOOSE)
        .collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found.truncate(most);
    found.into_iter().map(|(first, _)| (first, last)).collect()
}

/// The fastest impact between two times, or else the first other event, and the one that would be it a lap later.
fn lap(instants: &[Instant], (begin, end, period): (f64, f64, f64)) -> Option<(usize, usize)> {
    let events = |from: f64, to: f64| {
        (instants.iter().enumerate())
            .filter(move |(_, i)| i.time >= from && i.time < to && i.guard.is_some())
    };
    let rate = |instant: &Instant| instant.impact().map_or(0.0, |(_, rate)| rate);
    let first = events(begin, end)
        .min_by(|a, b| rate(a.1).total_cmp(&rate(b.1)))?
        .0;
    let due = instants[first].time + (end - begin);
    let slack = 0.45 * period;
    let (last, _) = events(due - slack, due + slack)
        .filter(|(_, instant)| {
            let is_impact = instant.impact().is_some();
            instant.guard == instants[first].guard
                && is_impact == instants[first].impact().is_some()
                && (is_impact || instant.mode_after == instants[first].mode_after)
        })
        .min_by(|a, b| {
            let late = |instant: &Instant| (instant.time - due).abs();
            late(a.1).total_cmp(&late(b.1))
        })?;
    (last > first).then_some((first, last))
}
