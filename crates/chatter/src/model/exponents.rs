//! Exponents that are parameters.
//!
//! A power whose exponent is a whole number is a product, smooth also where its base vanishes. Of one whose exponent is a parameter that
//! is known only once the parameter has its value, when expressions have been derived and compiled for all values.

use crate::expressions::{Expr, Node, Symbol};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real, Scalar};
use std::collections::BTreeSet;

impl Model {
    /// The model with numbers in place of the parameters that whole exponents are made of, but for those by index that are `varied`, and
    /// for what is defined through them. States, parameters, contacts, sections and corners keep their places.
    #[must_use]
    pub fn with_whole_exponents(&self, varied: &[usize]) -> Self {
        let values = self.parameter_values::<DoubleDouble>(&[]);
        let fixed = self.in_whole_exponents(&self.with_dependents(varied), &values);
        let mut model = self.clone();
        if fixed.is_empty() {
            return model;
        }
        let mut numbers = vec![None; values.len()];
        for index in fixed {
            numbers[index] = Some(model.graph.number_exact(values[index]));
        }
        let number = |symbol: Symbol| match symbol {
            Symbol::Parameter(index) => numbers.get(index).copied().flatten(),
            Symbol::State(_) => None,
        };
        let before: Vec<Expr> = (self.corners().0.surfaces.iter())
            .map(|&surface| model.graph.substitute(surface, &number))
            .collect();
        let (mut graph, mut of) = (core::mem::take(&mut model.graph), Vec::new());
        model.for_each_expression(|expr| of.push(expr));
        for expr in of {
            *expr = graph.substitute(*expr, &number);
        }
        model.graph = graph;
        // A corner that a number takes away would leave the others in other places.
        if model.corners().0.surfaces == before {
            model
        } else {
            self.clone()
        }
    }

    /// The parameters that exponents are made of which are whole and above zero by their values, without a `varied` one among them.
    fn in_whole_exponents(&self, varied: &[usize], values: &[DoubleDouble]) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for part in self.graph.reachable(&self.expressions()) {
            let &Node::Power(_, exponent) = self.graph.node(part) else {
                continue;
            };
            let symbols: Option<Vec<usize>> = (self.graph.symbols(exponent).into_iter())
                .map(|symbol| match symbol {
                    Symbol::Parameter(index) if !varied.contains(&index) => Some(index),
                    _ => None,
                })
                .collect();
            let Some(symbols) = symbols.filter(|symbols| !symbols.is_empty()) else {
                continue;
            };
            let value = self.graph.evaluate(exponent, &[], values);
            if value.is_whole() && value > DoubleDouble::ZERO {
                found.extend(symbols);
            }
        }
        found
    }
}
