//! Derivatives of a flow: the variational equation as further states of the same system.
//!
//! A column m = dx/d(something) obeys m' = Df m + df/dp between events (MATH.md 6), and jumps where the trajectory does.
//! With the derivative of any function along a column,
//!
//! ```text
//! D g = sum_i dg/dx_i m_i  (+ dg/dp in a parameter's column)
//! ```
//!
//! an impact x+ = R(x-) on the surface h = 0, with the field f on both sides, takes the column to
//!
//! ```text
//! m+ = D R + (f(x+) - L_f R) D h / L_f h                                                     saltation
//! ```
//!
//! and coming to rest, x+ = x - v W / b at h = v = 0, takes it to D (x - v W / b): the event's time drops out because
//! the contact force makes up the whole difference of the fields. Release is continuous in the column as in the field.
//!
//! All of it is written down as expressions in (x, m), so one trajectory carries its derivatives through every mode
//! with the same tapes, steps and error control.

use super::modes::equations::ModeExprs;
use super::occurrence::Occurrence;
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Contact, Mechanics, Model};
use crate::numerics::Real;

/// What a column of derivatives is taken with respect to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Column {
    /// A displacement of the initial state; where the trajectory starts the column says which.
    State,
    /// A parameter, by its number. Where the trajectory starts the column holds the derivative of the initial state.
    Parameter(usize),
}

/// Derivatives by so many states, then by parameters.
pub(crate) fn columns(states: usize, parameters: &[usize]) -> Vec<Column> {
    (core::iter::repeat_n(Column::State, states))
        .chain(parameters.iter().map(|&p| Column::Parameter(p)))
        .collect()
}

/// A state followed by so many columns of derivatives by itself: unit vectors, then zeros for parameters.
pub(crate) fn with_identity<R: Real>(state: &[R], columns: usize) -> Vec<R> {
    let n = state.len();
    let mut start = state.to_vec();
    start.resize(n * (1 + columns), R::ZERO);
    for i in 0..n.min(columns) {
        start[n * (i + 1) + i] = R::ONE;
    }
    start
}

/// A displacement that shrinks by this part where something happened that [may forget](may_forget) it is nothing but rounding.
pub(crate) const FORGOTTEN: f64 = 1e-11;

/// Whether an event may take displacements that differ to ones that do not: also a surface that is crossed, where what was on its way stands still, as the
/// current of a diode does.
pub(crate) fn may_forget(model: &Model, told: &Occurrence<f64>) -> bool {
    match *told {
        Occurrence::Impact {
            contact, closes, ..
        } => closes || impacts_may_forget(&model.contacts[contact]),
        Occurrence::Accumulation { .. }
        | Occurrence::Cascade { .. }
        | Occurrence::Capture { .. }
        | Occurrence::Slide { .. }
        | Occurrence::Stick { .. }
        | Occurrence::Switch { .. }
        | Occurrence::Reset { .. } => true,
        _ => false,
    }
}

/// Whether even impacts after which a contact is open may do so.
pub(crate) fn impacts_may_forget(contact: &Contact) -> bool {
    contact.friction.is_some() || contact.reset.is_some()
}

/// One column of a variational system: where its components lie, and how parameters change along it.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    /// First state that holds the column.
    offset: usize,
    /// Rate of each parameter along the column; empty for a displacement of the state.
    parameters: Vec<Expr>,
}

impl Direction {
    pub(crate) fn new(offset: usize, parameters: Vec<Expr>) -> Self {
        Self { offset, parameters }
    }

    /// That of a column which begins at this state.
    pub(crate) fn of(column: Column, model: &Model, graph: &mut Graph, offset: usize) -> Self {
        let parameters = match column {
            Column::State => Vec::new(),
            Column::Parameter(index) => model.parameter_rates(graph, index),
        };
        Self::new(offset, parameters)
    }

    /// The states that hold the column of this many coordinates.
    pub(crate) fn components(&self, graph: &mut Graph, dimension: usize) -> Vec<Expr> {
        (0..dimension)
            .map(|i| graph.state(self.offset + i))
            .collect()
    }

    /// The derivative of each of `exprs` along the column; `dimension` states have a component in it.
    pub(crate) fn along(&self, graph: &mut Graph, dimension: usize, exprs: &[Expr]) -> Vec<Expr> {
        let components = self.components(graph, dimension);
        graph.directional_derivatives(exprs, &|symbol| match symbol {
            Symbol::State(i) => components.get(i).copied(),
            Symbol::Parameter(i) => self.parameters.get(i).copied(),
        })
    }

    /// The derivatives of functions from event to event, where a surface is met: fixed in time, a column does not keep to the
    /// surface, and its event comes later by the time that the field takes there (MATH.md 10).
    pub(crate) fn at_event(
        &self,
        graph: &mut Graph,
        (field, surface): (&[Expr], Expr),
        exprs: &[Expr],
    ) -> Vec<Expr> {
        let off = self.along(graph, field.len(), &[surface])[0];
        let rate = graph.lie_derivative(surface, field);
        let early = graph.div(off, rate);
        let along = self.along(graph, field.len(), exprs);
        (exprs.iter().zip(along))
            .map(|(&expr, along)| {
                let drift = graph.lie_derivative(expr, field);
                let moved = graph.mul(drift, early);
                graph.sub(along, moved)
            })
            .collect()
    }
}

/// Extends the field, the impacts, the rests and the chatter sequences of a mode by the columns.
pub(crate) fn extend(mode: &mut ModeExprs, mechanics: &mut Mechanics, directions: &[Direction]) {
    let dimension = mode.field.len();
    let field = mode.field.clone();
    let graph = &mut mechanics.graph;
    for direction in directions {
        let rates = direction.along(graph, dimension, &field);
        mode.field.extend(rates);
    }
    for (contact, sequence) in mechanics.contacts.iter().zip(&mut mode.sequences) {
        sequence.extend(graph, contact, &field, directions);
    }
    for (contact, (after, rest)) in mechanics
        .contacts
        .iter()
        .zip(mode.impacts.iter_mut().zip(&mut mode.rests))
    {
        let map = after.clone();
        let approach = graph.lie_derivative(contact.gap, &field);
        let jumps: Vec<Expr> = field
            .iter()
            .zip(&map)
            .map(|(&component, &image)| {
                let leaving = graph.substitute(component, &|symbol| match symbol {
                    Symbol::State(i) => map.get(i).copied(),
                    Symbol::Parameter(_) => None,
                });
                let arriving = graph.lie_derivative(image, &field);
                let jump = graph.sub(leaving, arriving);
                graph.div(jump, approach)
            })
            .collect();
        let at_rest = rest.clone();
        for direction in directions {
            let gap = direction.along(graph, dimension, &[contact.gap])[0];
            let image = direction.along(graph, dimension, &map);
            for (&image, &jump) in image.iter().zip(&jumps) {
                let late = graph.mul(jump, gap);
                after.push(graph.add(image, late));
            }
            rest.extend(direction.along(graph, dimension, &at_rest));
        }
    }
}
