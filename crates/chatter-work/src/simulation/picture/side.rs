//! A quantity along a motion: a state, or gap or rate of a contact.

use super::shown::Shown;
use super::{Subject, axis_of};
use crate::refusal::Refusal;
use chatter::expressions::{Expr, Graph, Node, Symbol};
use chatter::model::Mechanics;
use chatter_figures::Axis;

/// What is drawn along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A state.
    State(usize),
    /// The gap of a contact.
    Gap(usize),
    /// Its rate.
    Rate(usize),
}

/// One axis, what is drawn along it, and where accumulations are on it.
pub struct Side {
    /// The axis.
    pub axis: Axis,
    /// The values at the samples.
    pub values: Vec<f64>,
    /// Those at accumulations.
    pub marks: Vec<f64>,
}

impl Side {
    /// Of a quantity.
    pub fn new(subject: &Subject, shown: &Shown, what: Quantity) -> Result<Self, Refusal> {
        let formula = Formula::new(subject, what)?;
        let model = subject.model;
        let parameters = model.parameter_values::<f64>(&[]);
        let mut state = vec![0.0; shown.states.len()];
        let values = (0..shown.times.len()).map(|place| {
            for (x, series) in state.iter_mut().zip(&shown.states) {
                *x = series[place];
            }
            formula.value(&state, &parameters)
        });
        let values = values.collect();
        let accumulations = shown.accumulations.iter();
        let marks = accumulations.map(|(_, state)| formula.value(state, &parameters));
        Ok(Self {
            values,
            marks: marks.collect(),
            axis: formula.axis,
        })
    }
}

/// A quantity as an expression in the states.
pub struct Formula {
    graph: Graph,
    expr: Expr,
    /// Its axis.
    pub axis: Axis,
}

impl Formula {
    /// Of a quantity.
    ///
    /// # Errors
    /// Gaps and rates of the model cannot be derived.
    pub fn new(subject: &Subject, what: Quantity) -> Result<Self, Refusal> {
        let model = subject.model;
        let of_state = |index: usize, mut graph: Graph| {
            let state = &model.states[index];
            Self {
                expr: graph.state(index),
                graph,
                axis: axis_of(&state.name, state.label.as_ref()),
            }
        };
        let (contact, word) = match what {
            Quantity::State(index) => return Ok(of_state(index, model.graph.clone())),
            Quantity::Gap(contact) => (contact, "gap"),
            Quantity::Rate(contact) => (contact, "gap rate"),
        };
        let mechanics = Mechanics::new(model).map_err(|error| Refusal::input(error.to_string()))?;
        let derived = &mechanics.contacts[contact];
        let expr = match what {
            Quantity::Gap(_) => derived.gap,
            _ => derived.rate,
        };
        if let Node::Symbol(Symbol::State(index)) = mechanics.graph.node(expr) {
            return Ok(of_state(*index, mechanics.graph.clone()));
        }
        Ok(Self {
            axis: Axis::new(format!("{word} at {}", model.contacts[contact].name)),
            graph: mechanics.graph,
            expr,
        })
    }

    /// Its value at a state.
    pub fn value(&self, state: &[f64], parameters: &[f64]) -> f64 {
        self.graph.evaluate(self.expr, state, parameters)
    }
}
