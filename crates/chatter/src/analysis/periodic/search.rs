//! Every periodic orbit that Newton's method finds from many starts, stable or not.

use super::branch::is_broken;
use super::cycle::itinerary::Step;
use super::cycle::settle::{Patience, loops, settle};
use super::error::PeriodicError;
use super::orbit::{Orbit, close};
use super::shooting::Workshop;
use crate::analysis::diagram::Generator;
use crate::flow::GuardKind;
use crate::numerics::Real;
use core::ops::ControlFlow;
use std::sync::Arc;

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Orbits of up to so many periods of the forcing, or returns to the section; without either so many returns of each
    /// trajectory are tried.
    pub periods: usize,
    /// From so many starts.
    pub starts: u64,
    /// Other seeds draw other starts.
    pub seed: u64,
}

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Searched {
    /// Starts that are done with.
    pub starts: u64,
    /// Orbits found.
    pub orbits: usize,
}

/// Starts are drawn from what the settled motion covers, and so much more to each side.
const ROOM: f64 = 1.0;
/// Periods that are passed over before a loop: a different number for each start.
const PASSED: usize = 4;
/// Two orbits are one if a node of one comes this near to the start of the other.
const SAME: f64 = 1e-7;

/// The orbits, those of short period first.
pub(crate) fn search(
    workshop: &Arc<Workshop>,
    state: &[f64],
    search: &Search,
    observer: &mut dyn FnMut(Searched) -> ControlFlow<()>,
) -> Result<Vec<Orbit>, PeriodicError> {
    let model = &workshop.model;
    let parameters = workshop.parameters::<f64>(&[]);
    let turns = workshop.closure.turns(&parameters)?;
    let mut found: Vec<Orbit> = Vec::new();
    // What the motion from the initial state covers; it need not settle.
    let extent = extent(workshop, state, &parameters)?;
    let patience = Patience {
        events: 4_000,
        periods: 200,
        time: 1e4,
    };
    let mut quiet = |_: f64| ControlFlow::Continue(());
    if let Ok(cycle) = settle(workshop, &[], state, patience, &mut quiet)
        && let Ok(orbit) = close(workshop, cycle, &[])
    {
        let laps = match (workshop.closure.forcing(&parameters), workshop.section) {
            (Some(period), _) => (orbit.period.to_f64() / period).round() as usize,
            (None, Some(section)) => {
                let crosses = |step: &&Step| step.ends_at() == Some(GuardKind::Section(section));
                orbit.shooting.steps.iter().filter(crosses).count()
            }
            (None, None) => 1,
        };
        if laps <= search.periods {
            add(workshop, &mut found, orbit);
        }
    }
    for start in 0..search.starts {
        let told = Searched {
            starts: start,
            orbits: found.len(),
        };
        if observer(told).is_break() {
            return Err(PeriodicError::Interrupted);
        }
        let mut generator = Generator::of_row(search.seed, start);
        let mut point: Vec<f64> = Vec::new();
        for _ in 0..100 {
            point = (extent.iter())
                .map(|&(low, high)| generator.between(low, high))
                .collect();
            for turn in &turns {
                point[turn.state] = generator.between(0.0, turn.period);
            }
            let open = model
                .contacts
                .iter()
                .all(|contact| model.graph.evaluate(contact.gap, &point, &parameters) >= 0.0);
            if open {
                break;
            }
        }
        let passed = (start % PASSED as u64) as usize;
        let Ok(cycles) = loops(workshop, &[], &point, (passed, search.periods)) else {
            continue;
        };
        for cycle in cycles {
            if let Ok(orbit) = close(workshop, cycle, &[]) {
                add(workshop, &mut found, orbit);
            }
        }
    }
    found.sort_by(|a, b| {
        (a.period.to_f64().total_cmp(&b.period.to_f64())).then(a.impacts.cmp(&b.impacts))
    });
    Ok(found)
}

/// Loops that are tried where nothing settles, each of up to so many periods, after so many more of them.
const LOOPS: usize = 16;
const LONGEST: usize = 4;
const APART: usize = 3;

/// What the motion settles to; where that is an unstable orbit, or none, the orbit of fewest periods beside it: nothing settles
/// to an unstable orbit, so that it is one of those of chaos, as a trajectory happened to come near to it.
pub(crate) fn simplest(
    workshop: &Arc<Workshop>,
    settled: Result<Orbit, PeriodicError>,
    state: &[f64],
    free: &[f64],
) -> Result<Orbit, PeriodicError> {
    let (start, longest) = match &settled {
        Ok(orbit) if orbit.is_stable() => return settled,
        Ok(orbit) => {
            let start: Vec<f64> = orbit.start.iter().map(|x| x.to_f64()).collect();
            (start, SHORTER * orbit.period.to_f64())
        }
        Err(PeriodicError::NotSettled { .. } | PeriodicError::NoConvergence { .. }) => {
            (state.to_vec(), f64::INFINITY)
        }
        Err(_) => return settled,
    };
    let mut best: Option<(usize, Orbit)> = None;
    for passed in (0..LOOPS).map(|k| APART * k) {
        let most = best.as_ref().map_or(LONGEST, |(periods, _)| periods - 1);
        if most == 0 {
            break;
        }
        let Ok(cycles) = loops(workshop, free, &start, (passed, most)) else {
            break;
        };
        for (index, cycle) in cycles.into_iter().enumerate() {
            let Ok(mut other) = close(workshop, cycle, free) else {
                continue;
            };
            let shorter = other.period.to_f64() < longest;
            if shorter && is_broken(&mut other.shooting, &other.at).is_ok_and(|broken| !broken) {
                best = Some((index + 1, other));
                break;
            }
        }
    }
    match best {
        Some((_, orbit)) => Ok(orbit),
        None => settled,
    }
}

/// An orbit of fewer periods is shorter than this part of another.
const SHORTER: f64 = 0.75;

/// Adds an orbit unless it is known, or no motion of the system.
fn add(workshop: &Workshop, found: &mut Vec<Orbit>, mut orbit: Orbit) {
    let Ok(broken) = is_broken(&mut orbit.shooting, &orbit.at) else {
        return;
    };
    if broken {
        return;
    }
    let Ok(turns) = workshop.closure.turns::<f64>(&workshop.parameters(&[])) else {
        return;
    };
    let sizes = orbit.shooting.state_sizes();
    let start = orbit.shooting.node(&orbit.at, 0).to_vec();
    let known = found.iter().any(|other| {
        let count = other.shooting.steps.len();
        (0..count).any(|index| {
            let node = other.shooting.node(&other.at, index);
            workshop
                .closure
                .difference(&turns, (node, &start), &sizes)
                .distance
                < SAME
        })
    });
    if !known {
        // A longer loop around a shorter orbit was found before it.
        let start_of_new = |other: &Orbit| {
            let node = other.shooting.node(&other.at, 0);
            let period = orbit.period.to_f64();
            let is_longer = other.period.to_f64() > 1.5 * period;
            is_longer
                && (0..orbit.shooting.steps.len()).any(|index| {
                    let own = orbit.shooting.node(&orbit.at, index);
                    workshop
                        .closure
                        .difference(&turns, (own, node), &sizes)
                        .distance
                        < SAME
                })
        };
        found.retain(|other| !start_of_new(other));
        found.push(orbit);
    }
}

/// Least and greatest value of each state on the motion from a state, with room.
fn extent(
    workshop: &Workshop,
    state: &[f64],
    parameters: &[f64],
) -> Result<Vec<(f64, f64)>, PeriodicError> {
    let period = workshop.closure.forcing(parameters);
    let mut tracer = super::cycle::trace::Tracer::new(&workshop.system, parameters, state, None)?;
    let clock = workshop.model.time.map_or(0.0, |index| state[index]);
    let mut ends: Vec<(f64, f64)> = state.iter().map(|&x| (x, x)).collect();
    let step = period.unwrap_or(1.0) / 64.0;
    let mut instants = Vec::new();
    let mut quiet = |_: f64| ControlFlow::Continue(());
    for k in 1..=64 * 12 {
        let until = clock + step * f64::from(k);
        if tracer
            .follow((until, usize::MAX / 2), &mut instants, &mut quiet)
            .is_err()
        {
            break;
        }
        instants.clear();
        for (end, &x) in ends.iter_mut().zip(tracer.trajectory.state()) {
            *end = (end.0.min(x), end.1.max(x));
        }
    }
    for end in &mut ends {
        let room = ROOM * (end.1 - end.0);
        *end = (end.0 - room, end.1 + room);
    }
    Ok(ends)
}
