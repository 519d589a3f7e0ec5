//! A cycle told from another of its steps on.

use super::itinerary::Step;
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
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

/// The cycle's next time around: by `counts` turns of each phase later, in pieces of lookups that many further.
pub(crate) fn a_turn_later(
    workshop: &Workshop,
    parameters: &[f64],
    (steps, counts): (&[Step], &[i64]),
) -> Result<Vec<Step>, PeriodicError> {
    let turns = workshop.closure.turns::<f64>(parameters)?;
    let later = |state: &[f64]| Closure::later(&turns, counts, state);
    let ends = (steps.iter().skip(1).map(|next| next.start.clone()))
        .chain(steps.first().map(|first| later(&first.start)));
    let moved = steps.iter().zip(ends).map(|(step, end)| {
        let between = step.start.iter().zip(&end);
        let state: Vec<f64> = between.map(|(a, b)| a + ON_THE_WAY * (b - a)).collect();
        let way = (&*state, &*later(&state));
        let pieces = step.pieces.iter().enumerate();
        Step {
            start: later(&step.start),
            pieces: pieces
                .map(|known| further(workshop, parameters, known, way))
                .collect(),
            ..step.clone()
        }
    });
    Ok(moved.collect())
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
