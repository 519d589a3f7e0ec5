//! A cycle told from another of its steps on.

use super::itinerary::Step;
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use crate::numerics::DoubleDouble;

/// A place on the way of a step, in parts of it, at which nothing happens.
const ON_THE_WAY: f64 = 0.4142;

/// Tells a cycle from step `by` on: what was before it comes a turn later, by `counts` turns of each phase, in pieces of lookups
/// that many further.
pub(crate) fn rotate(
    workshop: &Workshop,
    parameters: &[f64],
    (steps, counts): (&mut [Step], &[i64]),
    by: usize,
) -> Result<(), PeriodicError> {
    let turns = workshop.closure.turns::<f64>(parameters)?;
    let later = |state: &[f64]| Closure::later(&turns, counts, state);
    for index in 0..by {
        let ends = (&steps[index].start, &steps[index + 1].start);
        let between = ends.0.iter().zip(ends.1);
        let state: Vec<f64> = between.map(|(a, b)| a + ON_THE_WAY * (b - a)).collect();
        let pieces = steps[index].pieces.iter().enumerate();
        let pieces: Vec<i64> = pieces
            .map(|(lookup, &piece)| {
                further(
                    workshop,
                    parameters,
                    (lookup, piece),
                    (&state, &later(&state)),
                )
            })
            .collect();
        let step = &mut steps[index];
        (step.start, step.pieces) = (later(&step.start), pieces);
    }
    steps.rotate_left(by);
    Ok(())
}

/// The piece of a lookup in which a state is, when another is in this piece of it.
fn further(
    workshop: &Workshop,
    parameters: &[f64],
    (lookup, piece): (usize, i64),
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
