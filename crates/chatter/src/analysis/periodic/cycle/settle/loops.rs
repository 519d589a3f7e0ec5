//! The cycles that a trajectory would go through if they closed.

use super::cycle::{Cycle, alone, from_first_turn};
use super::returns::{MOST_LOOSE, landmarks};
use super::sizes::{sizes, states};
use super::{CHUNK, FIRST_CHUNK};
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::cycle::itinerary::Step;
use crate::analysis::periodic::cycle::trace::{Instant, Tracer};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Shooting, Workshop};
use core::ops::ControlFlow;
use std::sync::Arc;

/// A loop that is to be closed comes back this near, against the size of the state.
const LOOSE: f64 = 0.2;

/// How long a trajectory is followed for loops where nothing says how long a period is.
const LOOSE_TIME: f64 = 100.0;

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
            // No longer than it takes: a motion that comes to rest crosses a section for ever, and another one never again.
            let mut chunk = FIRST_CHUNK;
            let mut crossings: Vec<usize> = Vec::new();
            while instants.len() < most && crossings.len() <= passed + periods {
                let (begin, known) = (instants.len(), crossings.len());
                tracer.follow((f64::MAX, chunk), &mut instants, &mut quiet)?;
                // The latest instant before may have had more to tell.
                let after = crossings.last().map_or(0, |latest| latest + 1);
                let new = after.max(begin.saturating_sub(1))..instants.len();
                crossings.extend(new.filter(|&index| instants[index].crosses(section)));
                let is_idle = chunk == CHUNK && crossings.len() == known;
                if instants.len() < begin + chunk || is_idle {
                    break;
                }
                chunk = (2 * chunk).min(CHUNK);
            }
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
    let parameters = workshop.parameters(free);
    from_first_turn(
        (workshop, &parameters),
        &mut steps,
        turns,
        &difference.turns,
    );
    Some(Cycle {
        steps,
        counts: difference.turns,
        distance: difference.distance,
        sizes,
    })
}

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
