//! What a mode computes at each contact: impacts, chatter, rest.

use super::closed::Closed;
use super::equations::ModeExprs;
use super::limits::Limits;
use crate::expressions::{Expr, Graph, Symbol, Tape};
use crate::flow::chatter::SequenceTapes;
use crate::model::{ContactMechanics, Section};

/// What an impact at one contact does, as a tape of order zero on the state before it.
#[derive(Clone, Debug)]
pub struct ImpactTape {
    pub(crate) tape: Tape,
    /// Components that change; their new values are the outputs after the scalars.
    pub(crate) changed: Vec<usize>,
}

/// Outputs of an impact tape before the changed components: rate before and after, acceleration and jerk after, the
/// restitution here and that of an impact of vanishing rate.
pub(crate) const IMPACT_SCALARS: usize = 6;

/// Gap, rate, acceleration and jerk of a contact at a state, in a program's field.
pub(crate) const LOCAL_SCALARS: usize = 4;

/// The tapes of all contacts, in order.
#[derive(Default)]
pub(super) struct AtContacts {
    pub locals: Vec<Tape>,
    pub captures: Vec<Tape>,
    /// None of contacts that are closed.
    pub impacts: Vec<Option<ImpactTape>>,
    pub sequences: Vec<Option<SequenceTapes>>,
    /// Contacts whose impulse leaves the rates of all closed ones as they are, and where there are columns of derivatives the side of all
    /// that these go by.
    pub alone: Closed,
}

impl AtContacts {
    pub fn new(
        graph: &mut Graph,
        mode: &ModeExprs,
        contacts: &[ContactMechanics],
        (sections, limits): (&[Section], &Limits),
        (coordinates, time): (usize, Option<usize>),
    ) -> Self {
        let dimension = mode.field.len();
        let closed = mode.grip.closed;
        let has_columns = dimension > coordinates;
        let mut all = Self::default();
        for (index, contact) in contacts.iter().enumerate() {
            let derivatives = gap_derivatives(graph, contact, &mode.field);
            all.locals
                .push(Tape::new(graph, dimension, &[], &derivatives));
            let onto_surface = surface_correction(graph, contact.gap, dimension, time);
            let at_rest: Vec<Expr> = (mode.rests[index].iter().zip(&onto_surface))
                .map(|(&rest, &correction)| graph.add(rest, correction))
                .collect();
            all.captures
                .push(Tape::new(graph, dimension, &[], &at_rest));
            if closed.contains(index) {
                all.impacts.push(None);
                all.sequences.push(None);
                continue;
            }
            let sequence = SequenceTapes::new(graph, dimension, &mode.sequences[index]);
            all.sequences.push(Some(sequence));
            let after = &mode.impacts[index];
            let states = (&after[..], &at_rest[..], &onto_surface[..]);
            let impact = ImpactTape::new(graph, contact, derivatives, states);
            let is_alone = (!has_columns || keeps_sides(graph, contact, after, (sections, limits)))
                && (closed.contacts())
                    .all(|other| keeps(graph, contacts[other].rate, &contact.jump));
            if is_alone {
                all.alone = all.alone.with(index);
            }
            all.impacts.push(Some(impact));
        }
        all
    }
}

impl ImpactTape {
    fn new(
        graph: &mut Graph,
        contact: &ContactMechanics,
        [_, rate, acceleration, jerk]: [Expr; LOCAL_SCALARS],
        (after, at_rest, onto_surface): (&[Expr], &[Expr], &[Expr]),
    ) -> Self {
        let scalars: [Expr; IMPACT_SCALARS] = [
            contact.rate,
            at(graph, rate, after),
            at(graph, acceleration, after),
            at(graph, jerk, after),
            contact.restitution,
            at(graph, contact.restitution, at_rest),
        ];
        let mut outputs = scalars.to_vec();
        let mut changed = Vec::new();
        for (i, (&after, &onto_surface)) in after.iter().zip(onto_surface).enumerate() {
            let value = graph.add(after, onto_surface);
            if value != graph.state(i) {
                changed.push(i);
                outputs.push(value);
            }
        }
        Self {
            tape: Tape::new(graph, after.len(), &[], &outputs),
            changed,
        }
    }
}

/// Gap, rate, acceleration and jerk of a contact.
fn gap_derivatives(
    graph: &mut Graph,
    contact: &ContactMechanics,
    field: &[Expr],
) -> [Expr; LOCAL_SCALARS] {
    let rate = graph.lie_derivative(contact.gap, field);
    let acceleration = graph.lie_derivative(rate, field);
    let jerk = graph.lie_derivative(acceleration, field);
    [contact.gap, rate, acceleration, jerk]
}

/// A function at another state.
fn at(graph: &mut Graph, function: Expr, state: &[Expr]) -> Expr {
    graph.substitute(function, &|symbol| match symbol {
        Symbol::State(i) => Some(state[i]),
        Symbol::Parameter(_) => None,
    })
}

/// Whether a function stays what it is along a displacement.
fn keeps(graph: &mut Graph, function: Expr, displacement: &[Expr]) -> bool {
    let change = graph.lie_derivative(function, displacement);
    let change = graph.as_number(change);
    change.is_some_and(|value| value.high() == 0.0)
}

/// Whether impacts leave the state on its side of every surface, and of those of events. Else columns of derivatives go by the event.
fn keeps_sides(
    graph: &mut Graph,
    contact: &ContactMechanics,
    after: &[Expr],
    (sections, limits): (&[Section], &Limits),
) -> bool {
    let corners = limits.corners.iter();
    let surfaces =
        corners.flat_map(|limit| [Some(limit.surface), limit.rate.map(|[rate, ..]| rate)]);
    let mut surfaces = surfaces.flatten();
    let mut resets = sections.iter().filter(|section| section.reset.is_some());
    surfaces.all(|surface| keeps(graph, surface, &contact.jump))
        && resets.all(|section| at(graph, section.surface, after) == section.surface)
}

/// What to add to a state within rounding of the contact surface so that it lies on it: otherwise the gap would drift
/// by a rounding error an impact.
///
/// Along one coordinate where the gap is linear in it (positions, in mechanics), else along the gradient; never in time.
fn surface_correction(
    graph: &mut Graph,
    gap: Expr,
    dimension: usize,
    time: Option<usize>,
) -> Vec<Expr> {
    let gradient: Vec<Expr> = (0..dimension)
        .map(|i| graph.derivative(gap, Symbol::State(i)))
        .collect();
    let mut correction = vec![graph.number(0.0); dimension];
    let linear = gradient.iter().position(|&slope| {
        graph
            .as_number(slope)
            .is_some_and(|value| value.high() != 0.0)
    });
    if let Some(i) = linear.filter(|&i| Some(i) != time) {
        let ratio = graph.div(gap, gradient[i]);
        correction[i] = graph.neg(ratio);
        return correction;
    }
    let spatial: Vec<usize> = (0..dimension).filter(|&i| Some(i) != time).collect();
    let two = graph.number(2.0);
    let squares: Vec<Expr> = spatial
        .iter()
        .map(|&i| graph.power(gradient[i], two))
        .collect();
    let norm = graph.sum(&squares);
    for i in spatial {
        let along = graph.mul(gap, gradient[i]);
        let share = graph.div(along, norm);
        correction[i] = graph.neg(share);
    }
    correction
}
