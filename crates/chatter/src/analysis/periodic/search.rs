//! Every periodic orbit that Newton's method finds from many starts, stable or not.

use super::branch::{Broken, broken, sequence_holds};
use super::cycle::reread::reread;
use super::cycle::settle::Patience;
use super::cycle::settle::loops::loops;
use super::cycle::trace::Tracer;
use super::error::PeriodicError;
use super::margins::MarginKind;
use super::orbit::{Orbit, as_told, close, settled};
use super::shooting::Workshop;
use crate::analysis::diagram::Generator;
use crate::flow::GuardKind;
use crate::numerics::Real;
use core::ops::ControlFlow;
use std::sync::Arc;

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Orbits of up to so many periods of the forcing, or returns to the section or, without both, to that of the events with resets which
    /// happens most seldom; in models with contacts and none of these so many returns of each trajectory are tried.
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

/// A state that is less than this part of what the settled motion covers has no size of its own.
const NOTHING: f64 = 1e-3;
/// Starts are drawn from what the settled motion covers, and so much more to each side.
const ROOM: f64 = 1.0;
/// Periods that are passed over before a loop: a different number for each start.
const PASSED: usize = 4;
/// Two orbits are one if a state of one comes this near to one of the other, against their size.
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
    let mut found = Found::new();
    // What the motion from the initial state covers; it need not settle.
    let extent = extent(workshop, state, &parameters)?;
    let patience = Patience::default();
    let mut quiet = |_: f64| ControlFlow::Continue(());
    let forcing = workshop.closure.forcing(&parameters);
    // Newton's method may close a loop by an orbit that goes around more often, and the motion lead to one that does.
    let is_wanted = |orbit: &mut Orbit| match forcing {
        Some(period) => (orbit.period.to_f64() / period).round() as usize <= search.periods,
        None => orbit.shooting.returns(&orbit.at) <= search.periods,
    };
    let wanted: Wanted<'_> = (&extent, &is_wanted);
    if let Ok(orbit) = settled(workshop, &[], state, patience, &mut quiet) {
        add(workshop, wanted, &mut found, orbit);
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
        let Ok(loops) = loops(workshop, &[], &point, (passed, search.periods)) else {
            continue;
        };
        let quiet = loops.quiet(workshop, &[], search.periods);
        for cycle in loops.cycles.into_iter().chain(quiet) {
            if let Ok(orbit) = close(workshop, cycle, &[]) {
                add(workshop, wanted, &mut found, orbit);
            }
        }
    }
    let mut found: Vec<Orbit> = found.into_iter().map(|(orbit, _)| orbit).collect();
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
    // Closed from a return that is not near, equations may have a solution that is no motion.
    let settled = settled.and_then(|mut orbit| {
        let no_motion = match flies_through_a_wall(&orbit) {
            true => "a flight of what was found goes through a wall",
            false if sticks_too_long(&mut orbit) => {
                "friction would have to hold too much where what was found sticks"
            }
            false => return Ok(orbit),
        };
        motion(workshop, orbit).ok_or_else(|| PeriodicError::NoConvergence {
            how: no_motion.to_owned(),
        })
    });
    let (start, longest) = match &settled {
        Ok(orbit) if orbit.is_stable() => return settled,
        Ok(orbit) => {
            let start: Vec<f64> = orbit.start.iter().map(|x| x.to_f64()).collect();
            (start, SHORTER * orbit.period.to_f64())
        }
        Err(
            PeriodicError::NotSettled { .. }
            | PeriodicError::NotRepeated { .. }
            | PeriodicError::NoConvergence { .. }
            | PeriodicError::Boundless,
        ) => (state.to_vec(), f64::INFINITY),
        Err(_) => return settled,
    };
    let mut best: Option<(usize, Orbit)> = None;
    for passed in (0..LOOPS).map(|k| APART * k) {
        let most = best.as_ref().map_or(LONGEST, |(periods, _)| periods - 1);
        if most == 0 {
            break;
        }
        let Ok(loops) = loops(workshop, free, &start, (passed, most)) else {
            break;
        };
        // What nothing happens to need not settle, as where no force damps it.
        let quiet = match loops.nothing_happens {
            true => loops.quiet(workshop, free, most),
            false => Vec::new(),
        };
        for (index, cycle) in loops.cycles.into_iter().chain(quiet).enumerate() {
            if cycle.duration() >= TWICE * longest {
                continue;
            }
            let other = close(workshop, cycle, free).ok();
            let shorter = other.filter(|other| other.period.to_f64() < longest);
            if let Some(other) = shorter.and_then(|other| motion(workshop, other)) {
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

/// Gaps below zero by more than this part of the largest state are no rounding.
const INSIDE: f64 = 1e-9;

fn flies_through_a_wall(orbit: &Orbit) -> bool {
    let sizes = orbit.shooting.state_sizes();
    let inside = INSIDE * sizes.into_iter().fold(0.0, f64::max);
    let mut gaps = (orbit.margins.iter()).filter(|margin| margin.kind == MarginKind::LeastGap);
    gaps.any(|gap| gap.value < -inside)
}

/// Whether a step slides from where the force is beyond what holds it there: the motion that it was closed from, which settled slowly, may have
/// slid at once where that which it settles to does not.
fn sticks_too_long(orbit: &mut Orbit) -> bool {
    let Ok(least) = orbit.shooting.least(&orbit.at) else {
        return false;
    };
    let beyond = |broken: &Broken| matches!(broken, Broken::Beyond(_, GuardKind::Leave(..)));
    broken(&orbit.shooting, &least).iter().any(beyond)
}

/// An orbit of fewer periods is shorter than this part of another.
const SHORTER: f64 = 0.75;
/// A loop may go around a shorter orbit so often. To close a longer one takes seconds, in chaos where nothing marks a period, and
/// leads to no shorter orbit.
const TWICE: f64 = 2.0;

/// Orbits that were found, each with the states that it is known by.
type Found = Vec<(Orbit, Vec<Vec<f64>>)>;

/// A motion that ends so far from where an orbit does, against the size of the state, is another one; beside an unstable orbit so
/// much farther as its greatest multiplier tells, …
const ELSEWHERE: f64 = 1e-6;
/// … up to this.
const FARTHEST: f64 = 1e-3;
/// The event at the end of a period is passed by so much of it.
const LATE: f64 = 1e-9;
/// Beyond this multiplier rounding takes a motion away from its orbit within a period.
const BLURRED: f64 = 1e9;

/// Whether a solution is a motion of the system: its events in their order, and, where a period is short enough to tell, the motion
/// from its start comes back there. A jump may take a state across a surface where no leg of the cycle looks.
fn is_motion(workshop: &Workshop, orbit: &mut Orbit) -> bool {
    if !sequence_holds(&mut orbit.shooting, &orbit.at) {
        return false;
    }
    let largest = (orbit.multipliers.iter()).fold(0.0, |most: f64, m| most.max(m.modulus()));
    if largest > BLURRED {
        return true;
    }
    let near = (ELSEWHERE * largest.max(1.0)).min(FARTHEST);
    comes_back(workshop, orbit).is_none_or(|distance| distance < near)
}

/// The orbit if it is a motion of the system; otherwise the orbit that the motion from its start is near to. A loop that begins and
/// ends in two pieces of a table has one of them wrong.
fn motion(workshop: &Arc<Workshop>, mut orbit: Orbit) -> Option<Orbit> {
    if is_motion(workshop, &mut orbit) {
        return Some(orbit);
    }
    let free = orbit.shooting.free(&orbit.at).to_vec();
    let state = orbit.shooting.node(&orbit.at, 0).to_vec();
    let cycle = reread(workshop, &free, (&state, orbit.period.to_f64())).ok()?;
    let mut other = close(workshop, cycle, &free).ok()?;
    is_motion(workshop, &mut other).then_some(other)
}

/// How far from its start the motion from there is after a period, if it can be followed.
fn comes_back(workshop: &Workshop, orbit: &Orbit) -> Option<f64> {
    let shooting = &orbit.shooting;
    let parameters = workshop.parameters(shooting.free(&orbit.at));
    let turns = workshop.closure.turns(&parameters).ok()?;
    let start = shooting.node(&orbit.at, 0).to_vec();
    let clock = workshop.model.time.map_or(0.0, |index| start[index]);
    let mut tracer = Tracer::new(&workshop.system, &parameters, &start, None).ok()?;
    let until = (clock + orbit.period.to_f64() * (1.0 + LATE), usize::MAX / 2);
    let mut quiet = |_: f64| ControlFlow::Continue(());
    tracer.follow(until, &mut Vec::new(), &mut quiet).ok()?;
    let states = (&*start, tracer.trajectory.state());
    let difference = (workshop.closure).difference(&turns, states, &shooting.state_sizes());
    Some(difference.distance)
}

/// What the settled motion covers, and which orbits are looked for.
type Wanted<'a> = (&'a [(f64, f64)], &'a dyn Fn(&mut Orbit) -> bool);

/// Adds an orbit, or that which the motion from it is near to, if it is wanted and not known.
fn add(workshop: &Arc<Workshop>, (extent, is_wanted): Wanted<'_>, found: &mut Found, orbit: Orbit) {
    let Some(mut orbit) = motion(workshop, orbit) else {
        return;
    };
    if !is_wanted(&mut orbit) {
        return;
    }
    let Ok(turns) = workshop.closure.turns::<f64>(&workshop.parameters(&[])) else {
        return;
    };
    // Of rest at zero nothing but rounding is left, which is no size.
    let own = orbit.shooting.state_sizes();
    let covered = extent.iter().map(|(low, high)| high - low);
    let sizes: Vec<f64> = (own.iter().zip(covered))
        .map(|(&own, covered)| {
            if own < NOTHING * covered {
                covered
            } else {
                own
            }
        })
        .collect();
    let states = orbit.shooting.landmarks(&orbit.at);
    let is_same = |(other, known): &(Orbit, Vec<Vec<f64>>)| {
        // A loop that goes twice around a shorter orbit shares its states.
        let longer = other.period.to_f64() > LONGER * orbit.period.to_f64();
        let shares = workshop
            .closure
            .share(&turns, (known, &states), &sizes, SAME);
        (shares, longer)
    };
    if found.iter().any(|known| is_same(known) == (true, false)) {
        return;
    }
    found.retain(|known| is_same(known) != (true, true));
    found.push((as_told(orbit), states));
}

/// Loops around one orbit that are so many times as long go around it more often.
const LONGER: f64 = 1.5;

/// Least and greatest value of each state on the motion from a state, with room.
fn extent(
    workshop: &Workshop,
    state: &[f64],
    parameters: &[f64],
) -> Result<Vec<(f64, f64)>, PeriodicError> {
    let period = workshop.closure.forcing(parameters);
    let mut tracer = Tracer::new(&workshop.system, parameters, state, None)?;
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
