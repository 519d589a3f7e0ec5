//! How parameters that are defined through others follow one of them.

use crate::expressions::{Expr, Graph, Symbol};
use crate::model::Model;

impl Model {
    /// The derivative of every parameter with respect to parameter number `index`, in order: one for itself, the chain
    /// rule for those whose value uses it, zero for the rest. `graph` continues the model's own.
    pub fn parameter_rates(&self, graph: &mut Graph, index: usize) -> Vec<Expr> {
        let zero = graph.number(0.0);
        let mut rates = vec![zero; self.parameters.len()];
        for next in self.parameter_order().unwrap_or_default() {
            rates[next] = if next == index {
                graph.number(1.0)
            } else {
                let value = self.parameters[next].value;
                graph.directional_derivatives(&[value], &|symbol| match symbol {
                    Symbol::Parameter(used) => rates.get(used).copied(),
                    Symbol::State(_) => None,
                })[0]
            };
        }
        rates
    }

    /// The derivatives of expressions by parameter number `index`, states held.
    pub(crate) fn derivatives_by_parameter(
        &self,
        graph: &mut Graph,
        exprs: &[Expr],
        index: usize,
    ) -> Vec<Expr> {
        let rates = self.parameter_rates(graph, index);
        graph.directional_derivatives(exprs, &|symbol| match symbol {
            Symbol::Parameter(i) => rates.get(i).copied(),
            Symbol::State(_) => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Parameter;

    #[test]
    fn a_parameter_follows_those_it_is_defined_through() {
        let mut graph = Graph::default();
        let (a, b) = (graph.parameter(0), graph.parameter(1));
        let three = graph.number(3.0);
        let square = graph.mul(b, b);
        let product = graph.mul(a, b);
        // a = b^2, b = 3, c = a b = b^3.
        let values = [square, three, product];
        let model = Model {
            title: None,
            source: None,
            states: Vec::new(),
            time: None,
            parameters: values
                .iter()
                .enumerate()
                .map(|(k, &value)| Parameter {
                    name: format!("p{k}"),
                    value,
                    label: None,
                })
                .collect(),
            simultaneous: crate::model::Simultaneous::Binary,
            contacts: Vec::new(),
            sections: Vec::new(),
            definitions: Vec::new(),
            surfaces: Vec::new(),
            drawing: Vec::new(),
            graph: graph.clone(),
        };
        let rates = model.parameter_rates(&mut graph, 1);
        let values = model.parameter_values::<f64>(&[]);
        let rates: Vec<f64> = rates
            .iter()
            .map(|&rate| graph.evaluate(rate, &[], &values))
            .collect();
        assert_eq!(rates, [6.0, 1.0, 27.0]);
        let zero = graph.number(0.0);
        assert_eq!(model.parameter_rates(&mut graph, 2)[..2], [zero, zero]);
    }
}
