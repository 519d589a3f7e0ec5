//! A cycle told from another of its steps on.

use super::itinerary::{Passage, Step};
use crate::analysis::periodic::closure::{Closure, Turn};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{LONGEST, Workshop};
use crate::analysis::return_map::translations::Translation;
use crate::flow::Settings;
use crate::numerics::DoubleDouble;

/// A place on the way of a step, in parts of it, at which nothing happens.
const ON_THE_WAY: f64 = 0.4142;

/// Tells a cycle from step `by` on: what was before it comes a turn later.
pub(crate) fn rotate(
    workshop: &Workshop,
    parameters: &[f64],
    (steps, counts): (&mut [Step], &[i64]),
    by: usize,
) -> Result<(), PeriodicError> {
    let next = a_turn_later(workshop, parameters, (steps, counts))?;
    steps[..by].clone_from_slice(&next[..by]);
    steps.rotate_left(by);
    Ok(())
}

/// Tells a cycle from where the instant that it begins in is over: what a jump brings about comes with it.
pub(super) fn past_instant(
    workshop: &Workshop,
    parameters: &[f64],
    (steps, counts): (&mut [Step], &[i64]),
) -> Result<(), PeriodicError> {
    match steps.iter().position(|step| !step.is_at_once()) {
        None | Some(0) => Ok(()),
        Some(by) => rotate(workshop, parameters, (steps, counts), by),
    }
}

/// How far a period takes the states that nothing depends on, as far as its last step can be followed.
fn drifts(workshop: &Workshop, parameters: &[f64], steps: &[Step]) -> Vec<f64> {
    let idle = &workshop.closure.idle;
    let none = || vec![0.0; idle.len()];
    let (Some(first), Some(last), false) = (steps.first(), steps.last(), idle.is_empty()) else {
        return none();
    };
    let all = workshop.system.with_pieces(parameters, &last.pieces);
    let settings = Settings::default();
    let landing = match last.passage {
        Passage::Leg(kind) | Passage::Timed(kind) | Passage::Around(kind) => {
            workshop.leg(kind).and_then(|leg| {
                let flyer = &mut leg.flyer(&settings);
                leg.fly(flyer, &all, &last.start, last.duration).ok()
            })
        }
        Passage::AtOnce(kind) | Passage::Together(kind) => (workshop.leg(kind))
            .map(|leg| leg.at_once(&mut leg.flyer(&settings), &all, &last.start)),
        Passage::Stretch(kind) => workshop.stretch(kind).and_then(|stretch| {
            let longest = LONGEST * last.duration;
            let follower = &mut stretch.follower(&settings);
            let before = steps.iter().rev().cycle().nth(1).and_then(Step::ends_at);
            let start = (&*last.start, before);
            stretch.follow(follower, &all, start, longest).ok()
        }),
    };
    landing.map_or_else(none, |landing| {
        let drift = |free: &Translation| match workshop.closure.is_phase(free.state) {
            true => 0.0,
            false => landing.image[free.state] - first.start[free.state],
        };
        idle.iter().map(drift).collect()
    })
}

/// The cycle's next time around: by `counts` turns of each phase later, by what a period takes states along that nothing depends on, and in
/// pieces of lookups that many further.
pub(crate) fn a_turn_later(
    workshop: &Workshop,
    parameters: &[f64],
    (steps, counts): (&[Step], &[i64]),
) -> Result<Vec<Step>, PeriodicError> {
    let turns = workshop.closure.turns::<f64>(parameters)?;
    let drifts = drifts(workshop, parameters, steps);
    let later = |state: &[f64]| {
        let mut later = Closure::later(&turns, counts, state);
        for (free, drift) in workshop.closure.idle.iter().zip(&drifts) {
            free.carry(&mut later, *drift);
        }
        later
    };
    Ok(elsewhere((workshop, parameters), steps, [&later, &later]))
}

/// The cycle so many turns of each phase later, and in pieces of lookups that many further.
pub(super) fn turned(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    (steps, counts): (&[Step], &[i64]),
    by: &[i64],
) -> Vec<Step> {
    let later = |state: &[f64]| Closure::later(turns, counts, state);
    let moved = |state: &[f64]| Closure::later(turns, by, state);
    elsewhere((workshop, parameters), steps, [&later, &moved])
}

/// Where a state is led.
type Leads<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// The cycle with its states elsewhere, as its forces are the same there: where a period leads from a state, and where a state is then.
fn elsewhere(
    (workshop, parameters): (&Workshop, &[f64]),
    steps: &[Step],
    [later, moved]: [Leads<'_>; 2],
) -> Vec<Step> {
    let ends = (steps.iter().skip(1).map(|next| next.start.clone()))
        .chain(steps.first().map(|first| later(&first.start)));
    let moved = steps.iter().zip(ends).map(|(step, end)| {
        let between = step.start.iter().zip(&end);
        let state: Vec<f64> = between.map(|(a, b)| a + ON_THE_WAY * (b - a)).collect();
        let way = (&*state, &*moved(&state));
        let pieces = step.pieces.iter().enumerate();
        Step {
            start: moved(&step.start),
            pieces: pieces
                .map(|known| further(workshop, parameters, known, way))
                .collect(),
            ..step.clone()
        }
    });
    moved.collect()
}

/// The piece of a lookup in which a state is, when another is in this piece of it.
fn further(
    workshop: &Workshop,
    parameters: &[f64],
    (lookup, &piece): (usize, &i64),
    (from, to): (&[f64], &[f64]),
) -> i64 {
    let system = &workshop.system;
    let (graph, corners) = (&system.model().graph, system.corners());
    let argument =
        |state: &[f64]| graph.evaluate(corners.lookups[lookup].argument, state, parameters);
    let Some(slots) = corners.slots_of::<f64>(graph, lookup, piece) else {
        return piece;
    };
    let way = argument(to) - argument(from);
    // From the middle of a piece it is to the middle of another.
    let middle = 0.5 * (slots[0] + slots[1]) + way;
    corners.piece_at(graph, lookup, DoubleDouble::from(middle))
}
