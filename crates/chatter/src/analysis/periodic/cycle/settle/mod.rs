//! What a trajectory settles to: the latest return to where it was.

pub mod cycle;
pub mod loops;
mod returns;
pub mod sizes;

use super::itinerary::Step;
use super::left::touched_at_rest;
use super::reread::from_early_on;
use super::trace::{Instant, PAST, Tracer, forget_past, leave_out_crossings};
use crate::analysis::periodic::closure::{Closure, Turn};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use crate::numerics::stored::number;
use core::ops::ControlFlow;
use cycle::{Cycle, cycle, from_first_turn};
use returns::{NEAR, ONE_INSTANT, latest_return};
use serde::{Deserialize, Serialize};
use sizes::{Most, is_next_to_nothing, states};

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

/// Between looks: events, twice as many from one look to the next, and periods of the forcing.
pub(super) const FIRST_CHUNK: usize = 16;
pub(super) const CHUNK: usize = 600;
const PERIODS: usize = 40;

/// Longer cycles are not looked for, in periods of the forcing.
const LONGEST: usize = 64;

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
        from_first_turn((workshop, parameters), &mut steps, turns, &difference.turns);
        (difference.distance <= near).then(|| Cycle {
            steps,
            counts: difference.turns.clone(),
            distance: difference.distance,
            sizes: sizes.clone(),
        })
    })
}
