//! An expression made ready to be evaluated at many points.

use crate::expressions::curve::Curve;
use crate::expressions::graph::eval::power;
use crate::expressions::graph::piecewise::{Edge, floor};
use crate::expressions::graph::{Expr, Function, Graph, Node, Symbol};
use crate::numerics::{DoubleDouble, Real};
use core::ops::Range;
use std::sync::Arc;

/// One value, from constants, inputs and values of earlier steps.
#[derive(Clone, Debug)]
enum Step<R> {
    Number(R),
    State(usize),
    Parameter(usize),
    Sum(Range<usize>),
    Product(Range<usize>),
    Power(usize, usize),
    Call(Function, usize),
    Switch([usize; 3], Edge),
    Floor(usize),
    Curve(Arc<Curve>, usize, u8),
}

/// Gives the same value as [`Graph::evaluate`], to the bit, without looking anything up.
#[derive(Clone, Debug)]
pub struct Formula<R> {
    steps: Vec<Step<R>>,
    /// Operands of sums and products.
    operands: Vec<usize>,
}

impl<R: Real> Formula<R> {
    /// Prepares `expr`.
    pub fn new(graph: &Graph, expr: Expr) -> Self {
        let parts = graph.reachable(&[expr]);
        let place = |operand: &Expr| parts.binary_search(operand).unwrap_or(usize::MAX);
        let mut formula = Self {
            steps: Vec::with_capacity(parts.len()),
            operands: Vec::new(),
        };
        for &part in &parts {
            let mut range = |operands: &[Expr]| {
                let first = formula.operands.len();
                formula.operands.extend(operands.iter().map(place));
                first..formula.operands.len()
            };
            let step = match graph.node(part) {
                Node::Number(number) => Step::Number(R::from_double_double(number.value())),
                Node::Pi => Step::Number(R::from_double_double(DoubleDouble::PI)),
                Node::Symbol(Symbol::State(index)) => Step::State(*index),
                Node::Symbol(Symbol::Parameter(index)) => Step::Parameter(*index),
                Node::Sum(terms) => Step::Sum(range(terms)),
                Node::Product(factors) => Step::Product(range(factors)),
                Node::Power(base, exponent) => Step::Power(place(base), place(exponent)),
                Node::Call(function, argument) => Step::Call(*function, place(argument)),
                Node::Switch {
                    surface,
                    above,
                    below,
                    edge,
                } => Step::Switch([surface, above, below].map(place), *edge),
                Node::Floor(argument) => Step::Floor(place(argument)),
                Node::Curve(id, argument, derivative) => {
                    Step::Curve(graph.curve(*id).clone(), place(argument), *derivative)
                }
            };
            formula.steps.push(step);
        }
        formula
    }

    /// Its value. `values` is scratch space, of any content.
    pub fn evaluate(&self, states: &[R], parameters: &[R], values: &mut Vec<R>) -> R {
        let missing = R::splat(f64::NAN);
        values.clear();
        for step in &self.steps {
            let value = match step {
                Step::Number(number) => *number,
                Step::State(index) => states.get(*index).copied().unwrap_or(missing),
                Step::Parameter(index) => parameters.get(*index).copied().unwrap_or(missing),
                Step::Power(base, exponent) => power(values[*base], values[*exponent]),
                Step::Call(function, argument) => function.of(values[*argument]),
                Step::Switch(places, edge) => {
                    let [surface, above, below] = places.map(|place| values[place]);
                    edge.choose(surface, above, below)
                }
                Step::Floor(argument) => floor(values[*argument]),
                Step::Curve(curve, argument, derivative) => {
                    curve.value(values[*argument], *derivative)
                }
                Step::Sum(range) => {
                    let terms = &self.operands[range.clone()];
                    terms[1..]
                        .iter()
                        .fold(values[terms[0]], |sum, &term| sum + values[term])
                }
                Step::Product(range) => {
                    let factors = &self.operands[range.clone()];
                    factors[1..]
                        .iter()
                        .fold(values[factors[0]], |product, &factor| {
                            product * values[factor]
                        })
                }
            };
            values.push(value);
        }
        values.last().copied().unwrap_or(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formula_gives_the_value_of_its_expression() {
        let mut graph = Graph::default();
        let texts = [
            "a",
            "2*x - sqrt(y)/(1 + a^2)",
            "sin(x*y)^3 + exp(-a)*pi",
            "x^a - log(y + 1)",
            "7",
        ];
        let names = ["x", "y", "a"];
        let symbols = [graph.state(0), graph.state(1), graph.parameter(0)];
        let resolve = |name: &str| names.iter().position(|&n| n == name).map(|k| symbols[k]);
        let mut scratch = Vec::new();
        for text in texts {
            let expr = graph.parse(text, &resolve, &names).unwrap();
            let formula = Formula::<f64>::new(&graph, expr);
            for (x, y, a) in [(0.3, 2.0, 1.5), (1.1, 0.7, -0.25), (2.0, 5.0, 0.0)] {
                let value = formula.evaluate(&[x, y], &[a], &mut scratch);
                let expected = graph.evaluate(expr, &[x, y], &[a]);
                assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            }
        }
    }
}
