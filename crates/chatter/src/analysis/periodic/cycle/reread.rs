//! An orbit read once more, from a state that it goes through.

use super::itinerary::{Passage, Step, read};
use super::rotate::past_instant;
use super::settle::cycle::{Cycle, from_first_turn};
use super::settle::sizes::{sizes, states};
use super::trace::{Instant, Tracer, leave_out_crossings};
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Workshop, take_in_moves};
use core::ops::ControlFlow;

/// A period may be off by this part.
const LATE: f64 = 1e-6;

/// The cycle of an orbit that goes through a state and has this period.
pub(crate) fn reread(
    workshop: &Workshop,
    free: &[f64],
    (state, period): (&Vec<f64>, f64),
) -> Result<Cycle, PeriodicError> {
    let parameters = workshop.parameters(free);
    let turns = workshop.closure.turns(&parameters)?;
    let section = workshop.section_as_event(&parameters);
    let mut tracer = Tracer::new(&workshop.system, &parameters, state, section)?;
    let mut instants = vec![tracer.start(state)];
    let mut quiet = |_: f64| ControlFlow::Continue(());
    let until = instants[0].time + period * (1.0 + LATE);
    tracer.follow((until, usize::MAX / 2), &mut instants, &mut quiet)?;
    leave_out_crossings(&mut instants, section);
    let last = match instants.last() {
        Some(last) if instants.len() > 1 => last.state.clone(),
        _ => tracer.trajectory.state().to_vec(),
    };
    let known = (workshop, &*parameters);
    let sizes = sizes_along(known, (&instants, &last, period), &turns);
    let mut ends = (state.clone(), last);
    let a_period =
        |from: &Instant, to: &Instant| (to.time - from.time - period).abs() <= 2.0 * LATE * period;
    let closes = |instants: &[Instant]| match instants {
        [first, .., last] => a_period(first, last),
        _ => true,
    };
    // Where it begins just before the event that it ends with, from that on.
    if let [first, second, .., last] = &*instants
        && second.time - first.time <= 2.0 * LATE * period
        && second.guard == last.guard
        && a_period(second, last)
    {
        ends = (second.state.clone(), last.state.clone());
        instants.remove(0);
    }
    if !closes(&instants) {
        // Nothing happens where it begins: from the first event on that comes again.
        let (there, known) = (tracer.trajectory.state().to_vec(), instants.len());
        tracer.follow((until + period, usize::MAX / 2), &mut instants, &mut quiet)?;
        leave_out_crossings(&mut instants, section);
        if instants.len() == known && workshop.closure.forcing(&parameters).is_some() {
            // What happened was on the way to where nothing does, as onto the surface that a mass sticks to.
            let steps = vec![Step::timed(&tracer.trajectory, there.clone(), period)];
            let ends = (&*there, tracer.trajectory.state());
            return from_to((workshop, &parameters), (&turns, sizes), steps, ends);
        }
        let again = (1..instants.len()).find_map(|from| {
            let comes_again = |to: &usize| {
                instants[*to].guard == instants[from].guard
                    && a_period(&instants[from], &instants[*to])
            };
            Some((from, (from + 1..instants.len()).find(comes_again)?))
        });
        if let Some((from, to)) = again {
            instants = instants[from..=to].to_vec();
            ends = (instants[0].state.clone(), instants[to - from].state.clone());
        }
    }
    let mut steps = read((&workshop.system, &parameters), &instants)?;
    if steps.is_empty() {
        steps.push(Step::timed(&tracer.trajectory, state.clone(), period));
    }
    from_to(
        (workshop, &parameters),
        (&turns, sizes),
        steps,
        (&ends.0, &ends.1),
    )
}

/// Sizes of states at instants, and of one more: none less than how far it moves in the time from each to the next, as that of a foot which is on the
/// ground whenever something happens. Where nothing does that time is the period: on what one rests on it may be zero just there.
fn sizes_along(
    (workshop, parameters): (&Workshop, &[f64]),
    (instants, last, period): (&[Instant], &Vec<f64>, f64),
    turns: &[Turn<f64>],
) -> Vec<f64> {
    let mut sizes = sizes(states(instants).chain([last]), turns);
    let ways = instants
        .windows(2)
        .map(|pair| (&*pair[0].state, pair[1].time - pair[0].time));
    let whole = match instants {
        [alone] => Some((&*alone.state, period)),
        _ => None,
    };
    let ways = ways.chain(whole);
    take_in_moves(&mut sizes, (&workshop.model, parameters), ways);
    for turn in turns {
        sizes[turn.state] = turn.period;
    }
    sizes
}

/// The cycle of steps that lead from one state to another.
fn from_to(
    (workshop, parameters): (&Workshop, &[f64]),
    (turns, sizes): (&[Turn<f64>], Vec<f64>),
    mut steps: Vec<Step>,
    ends: (&[f64], &[f64]),
) -> Result<Cycle, PeriodicError> {
    let difference = workshop.closure.difference(turns, ends, &sizes);
    past_instant(workshop, parameters, (&mut steps, &difference.turns))?;
    from_first_turn((workshop, parameters), &mut steps, turns, &difference.turns);
    Ok(Cycle {
        steps,
        counts: difference.turns,
        distance: difference.distance,
        sizes,
    })
}

/// No orbit takes as long.
const NO_HORIZON: f64 = 1e12;

/// The way from a state up to the last of so many impacts at a contact, as a cycle that need not be nearly closed.
pub(crate) fn through_impacts(
    workshop: &Workshop,
    free: &[f64],
    state: &[f64],
    (contact, count): (usize, usize),
) -> Result<Cycle, PeriodicError> {
    let parameters = workshop.parameters(free);
    let turns = workshop.closure.turns(&parameters)?;
    let mut tracer = Tracer::new(&workshop.system, &parameters, state, None)?;
    let mut instants = vec![tracer.start(state)];
    let mut quiet = |_: f64| ControlFlow::Continue(());
    loop {
        let known = instants.len();
        tracer.follow((NO_HORIZON, count), &mut instants, &mut quiet)?;
        let hits = |&k: &usize| instants[k].impact().is_some_and(|(hit, _)| hit == contact);
        // The latest instant may have more to tell.
        if let Some(end) = (1..instants.len() - 1).filter(hits).nth(count - 1) {
            instants.truncate(end + 1);
            break;
        }
        if instants.len() == known {
            return Err(PeriodicError::Eventless {
                time: instants[known - 1].time,
            });
        }
    }
    let [first, .., last] = &*instants else {
        return Err(PeriodicError::Eventless {
            time: instants[0].time,
        });
    };
    let (way, last) = (last.time - first.time, &last.state);
    let sizes = sizes_along((workshop, &parameters), (&instants, last, way), &turns);
    let steps = read((&workshop.system, &parameters), &instants)?;
    from_to(
        (workshop, &parameters),
        (&turns, sizes),
        steps,
        (state, last),
    )
}

/// A cycle with lookups, whose pieces are numbered on from turn to turn, as it is in the first turn of each phase: there phases have
/// most digits. Where it is not read as the same from there it stays what it is.
pub(super) fn from_early_on(
    workshop: &Workshop,
    free: &[f64],
    turns: &[Turn<f64>],
    cycle: Cycle,
) -> Cycle {
    let Some(first) = cycle.steps.first().filter(|step| !step.pieces.is_empty()) else {
        return cycle;
    };
    let mut state = first.start.clone();
    for turn in turns {
        state[turn.state] -= (state[turn.state] / turn.period).floor() * turn.period;
    }
    if state == first.start {
        return cycle;
    }
    let passages = |steps: &[Step]| -> Vec<Passage> { steps.iter().map(|s| s.passage).collect() };
    let period = cycle.steps.iter().map(|step| step.duration).sum();
    match reread(workshop, free, (&state, period)) {
        Ok(early)
            if passages(&early.steps) == passages(&cycle.steps) && early.counts == cycle.counts =>
        {
            early
        }
        _ => cycle,
    }
}
