//! What is left of a motion that dies out under a forcing.

use super::settle::sizes::{DIED_OUT, Most, is_phase, states};
use super::trace::Instant;
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::shooting::Workshop;
use crate::expressions::Expr;

/// The contact that is touched by what is left of a motion under a forcing, where that is next to nothing: at rest, without a force that would
/// hold the contact or open it.
pub(super) fn touched_at_rest(
    (workshop, parameters): (&Workshop, &[f64]),
    turns: &[Turn<f64>],
    (latest, instants): (&Vec<f64>, &[Instant]),
    most: &Most,
) -> Option<usize> {
    let (model, matters) = (&workshop.model, &workshop.matters);
    let is_place = |index: usize| matters[index] && !is_phase(turns, index);
    let size = |state: &[f64]| {
        let all = state
            .iter()
            .enumerate()
            .filter(|(index, _)| is_place(*index));
        all.fold(0.0_f64, |size, (_, x)| size.max(x.abs()))
    };
    if size(latest) > DIED_OUT * size(&most.0) {
        return None;
    }
    let nothing = |state: &Vec<f64>| -> Vec<f64> {
        let all = state.iter().enumerate();
        all.map(|(index, x)| if is_place(index) { 0.0 } else { *x })
            .collect()
    };
    let places: Vec<Vec<f64>> = [latest]
        .into_iter()
        .chain(states(instants))
        .map(nothing)
        .collect();
    let is_zero = |expr: Expr| {
        let value = |state: &Vec<f64>| model.graph.evaluate(expr, state, parameters);
        places.iter().all(|state| value(state) == 0.0)
    };
    let mut rates = (model.states.iter().enumerate()).filter(|(index, _)| is_place(*index));
    if !rates.all(|(_, state)| is_zero(state.derivative)) {
        return None;
    }
    (model.contacts.iter()).position(|contact| is_zero(contact.gap))
}
