//! The field of a mode and the functions that end it, on one tape.

use super::equations::{ModeExprs, guard_functions, kept_by_contacts};
use super::guard::{Guard, GuardKind, Transition};
use super::limits::Limits;
use crate::expressions::{Expr, Graph, Node, Symbol, Tape};
use crate::model::{ContactMechanics, Mechanics, Section};
use crate::numerics::roots::Crossing;

/// The field with what ends it.
pub(super) struct Guarded {
    pub tape: Tape,
    listed: Vec<(GuardKind, Crossing, Expr)>,
    /// What is positive on the sides of the mode.
    positive: Vec<Expr>,
}

impl Guarded {
    pub fn new(
        mechanics: &mut Mechanics,
        contacts: &[ContactMechanics],
        (sections, limits): (&[Section], &Limits),
        mode: &ModeExprs,
    ) -> Self {
        let (closed, dimension) = (mode.grip.closed, mode.field.len());
        let graph = &mut mechanics.graph;
        let listed = guard_functions(graph, contacts, (sections, limits), mode);
        let mut held = sections_held(mechanics, &listed, (sections, mode));
        let graph = &mut mechanics.graph;
        let functions: Vec<Expr> = listed.iter().map(|&(.., function)| function).collect();
        let positive: Vec<Expr> = (listed.iter())
            .filter(|(kind, ..)| matches!(kind, GuardKind::Switch(_)))
            .map(|&(.., function)| function)
            .collect();
        // Roots of multiples of what ends a side vanish where it ends.
        let rewritten =
            graph.with_powers_of(&[&mode.field[..], &functions[..]].concat(), &positive);
        let (rates, functions) = rewritten.split_at(dimension);
        let mut tape = Tape::new(graph, dimension, rates, functions);
        // Roots say where motion has a series: what they are taken of stays a guard.
        let mut kept = kept_by_contacts(graph, contacts, closed, &listed);
        kept.retain(|&(guard, _)| !tape.takes_root_of(tape.outputs[guard]));
        held.retain(|guard| kept.iter().all(|(other, _)| other != guard));
        if !kept.is_empty() || !held.is_empty() {
            let mut functions = functions.to_vec();
            for &(guard, sign) in &kept {
                functions[guard] = sign;
            }
            for &guard in &held {
                functions[guard] = graph.number(0.0);
            }
            tape = Tape::new(graph, dimension, rates, &functions);
        }
        for (guard, (kind, ..)) in listed.iter().enumerate() {
            // What is constant here may be another constant beyond a corner; and which sign a parameter has is asked as of all else.
            let is_asked = matches!(kind, GuardKind::Section(_)) && !held.contains(&guard);
            if is_asked || kept.iter().any(|&(k, _)| k == guard) {
                tape.as_series(guard);
            }
        }
        Self {
            tape,
            listed,
            positive,
        }
    }

    /// What ends the mode, in the order of the tape, with what each of them leads to.
    pub fn guards(
        &self,
        graph: &mut Graph,
        transition: impl Fn(GuardKind) -> Transition,
    ) -> Vec<Guard> {
        let dimension = self.tape.dimension();
        (self.listed.iter().zip(&self.tape.outputs))
            .map(|(&(kind, crossing, function), &series)| Guard {
                kind,
                transition: transition(kind),
                crossing,
                series,
                is_affine: is_affine(graph, function, dimension),
                side: if self.positive.contains(&function) {
                    1.0
                } else if self.positive.contains(&graph.neg(function)) {
                    -1.0
                } else {
                    0.0
                },
                is_expanded: match kind {
                    GuardKind::Gap(_) => !is_state(graph, function),
                    _ => !is_affine(graph, function, dimension),
                },
            })
            .collect()
    }
}

/// The guards that are sections in which contacts at rest hold the motion. It crosses them where it leaves, if to the other side: what
/// rounding leaves beside them says nothing.
fn sections_held(
    mechanics: &mut Mechanics,
    listed: &[(GuardKind, Crossing, Expr)],
    (sections, mode): (&[Section], &ModeExprs),
) -> Vec<usize> {
    let is_look = |&(kind, ..): &(GuardKind, Crossing, Expr)| match kind {
        GuardKind::Section(section) => sections[section].reset.is_none(),
        _ => false,
    };
    let looks: Vec<usize> = (0..listed.len())
        .filter(|&guard| is_look(&listed[guard]))
        .collect();
    let surfaces: Vec<Expr> = looks.iter().map(|&guard| listed[guard].2).collect();
    let closed: Vec<usize> = mode.grip.closed.contacts().collect();
    let rests = mechanics.held_at_zero(&closed, &surfaces);
    let held = looks.into_iter().zip(rests).filter(|(_, rests)| *rests);
    held.map(|(guard, _)| guard).collect()
}

fn is_state(graph: &Graph, function: Expr) -> bool {
    matches!(graph.node(function), Node::Symbol(Symbol::State(_)))
}

/// Whether a function is a combination of states with coefficients that no state changes: resolved wherever they are.
fn is_affine(graph: &mut Graph, function: Expr, dimension: usize) -> bool {
    let states: Vec<Symbol> = (0..dimension).map(Symbol::State).collect();
    let slopes = graph.gradient(function, &states);
    let mut parts = graph.reachable(&slopes).into_iter();
    parts.all(|part| !is_state(graph, part))
}
