//! A sampled quantity, made ready.

use crate::analysis::map::{Passage, Scope};
use crate::expressions::{Formula, Node, ParseError, Symbol};

/// An expression of a point, the parameters and the way since the sample before. A bare coordinate costs nothing.
#[derive(Clone, Debug)]
pub struct Observable(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Coordinate(usize),
    Formula(Formula<f64>),
}

impl Observable {
    /// Reads an expression. `dimension` is the number of coordinates of a point; names of the scope hide those of
    /// [`Passage::NAMES`].
    pub(in crate::analysis::diagram) fn new(
        scope: &Scope,
        dimension: usize,
        text: &str,
    ) -> Result<Self, ParseError> {
        let mut scope = scope.clone();
        for (place, name) in Passage::NAMES.iter().enumerate() {
            let quantity = scope.graph.state(dimension + place);
            scope.names.push(((*name).to_owned(), quantity));
        }
        let expr = scope.parse(text)?;
        Ok(Self(match scope.graph.node(expr) {
            Node::Symbol(Symbol::State(index)) if *index < dimension => Kind::Coordinate(*index),
            _ => Kind::Formula(Formula::new(&scope.graph, expr)),
        }))
    }

    /// Its value.
    #[inline]
    pub(in crate::analysis::diagram) fn value(
        &self,
        point: &[f64],
        passage: &Passage,
        parameters: &[f64],
        scratch: &mut Scratch,
    ) -> f64 {
        match &self.0 {
            Kind::Coordinate(index) => point[*index],
            Kind::Formula(formula) => {
                scratch.inputs.clear();
                scratch.inputs.extend_from_slice(point);
                scratch.inputs.extend(passage.values());
                formula.evaluate(&scratch.inputs, parameters, &mut scratch.values)
            }
        }
    }
}

/// Space for the evaluation of observables.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Scratch {
    inputs: Vec<f64>,
    values: Vec<f64>,
}
