//! Parameters on whose values it depends what equations are, rather than what they give.
//!
//! A power whose exponent is a whole number is a product, smooth also where its base vanishes. Of one whose exponent is a parameter that
//! is known only once the parameter has its value, when expressions have been derived and compiled for all values. So is what is left
//! under a root where a term of its sum has a factor that is zero: sqrt(x^2 + eps^2) is the size of x then, which has a corner.

use crate::expressions::{Expr, Node, Symbol};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real, Scalar};
use std::collections::BTreeSet;

impl Model {
    /// The model with numbers in place of the parameters that whole exponents, and terms of nothing under roots, are made of, but for those
    /// by index that are `varied`, and for what is defined through them. States, parameters, contacts, sections and corners keep their
    /// places; corners that roots leave behind come after the others.
    #[must_use]
    pub fn with_telling_numbers(&self, varied: &[usize]) -> Self {
        let values = self.parameter_values::<DoubleDouble>(&[]);
        let mut model = self.clone();
        let fixed = model.telling(&self.with_dependents(varied), &values);
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
        model.take_sizes();
        model.surfaces = model.surface_names();
        // A corner that a number takes away would leave the others in other places.
        if model.corners().0.surfaces.starts_with(&before) {
            model
        } else {
            self.clone()
        }
    }

    /// The parameters, without a `varied` one among them, that exponents are made of which are whole and above zero by their values, or
    /// factors that are zero of a term under a root.
    fn telling(&mut self, varied: &[usize], values: &[DoubleDouble]) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for part in self.graph.reachable(&self.expressions()) {
            let &Node::Power(base, exponent) = self.graph.node(part) else {
                continue;
            };
            let exponents = [exponent];
            let (telling, tells): (&[Expr], fn(DoubleDouble) -> bool) =
                match self.graph.as_number(exponent) {
                    None => (&exponents, |value| {
                        value.is_whole() && value > DoubleDouble::ZERO
                    }),
                    Some(number) if number.is_whole() => continue,
                    Some(_) => (&self.graph.constants_in_sum(base), |value| {
                        value == DoubleDouble::ZERO
                    }),
                };
            for &expr in telling {
                let symbols: Option<Vec<usize>> = (self.graph.symbols(expr).into_iter())
                    .map(|symbol| match symbol {
                        Symbol::Parameter(index) if !varied.contains(&index) => Some(index),
                        _ => None,
                    })
                    .collect();
                let Some(symbols) = symbols.filter(|symbols| !symbols.is_empty()) else {
                    continue;
                };
                if tells(self.graph.evaluate(expr, &[], values)) {
                    found.extend(symbols);
                }
            }
        }
        found
    }
}
