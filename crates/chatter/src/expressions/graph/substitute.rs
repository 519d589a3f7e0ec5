//! Replacing symbols by expressions, and asking which symbols an expression has.

use crate::expressions::{Expr, Function, Graph, Node, Symbol};
use std::collections::BTreeSet;

/// Multiples of it, without their whole parts, have no simple relation.
const BLEND: f64 = 0.618_033_988_749_894_9;

impl Graph {
    /// `expr` with every symbol for which `replacement` gives an expression replaced by it, all at once, and simplified
    /// again. Shared subexpressions are rebuilt once.
    pub fn substitute(&mut self, expr: Expr, replacement: &dyn Fn(Symbol) -> Option<Expr>) -> Expr {
        self.rebuilt(expr, |graph, old, _| match *graph.node(old) {
            Node::Symbol(symbol) => replacement(symbol),
            _ => None,
        })
    }

    /// `expr` from its parts upwards: each as it is said to become, by what those before it have become, or else with these simplified again.
    pub(super) fn rebuilt(
        &mut self,
        expr: Expr,
        mut becomes: impl FnMut(&mut Self, Expr, &[Expr]) -> Option<Expr>,
    ) -> Expr {
        let mut known = vec![expr; expr.index() + 1];
        for old in self.reachable(&[expr]) {
            known[old.index()] = match becomes(self, old, &known) {
                Some(other) => other,
                None => self.with_parts(old, &known),
            };
        }
        known[expr.index()]
    }

    /// `expr` with parts of it replaced by others, and simplified again.
    pub(crate) fn with_replaced(&mut self, expr: Expr, replaced: &[(Expr, Expr)]) -> Expr {
        self.rebuilt(expr, |_, old, _| {
            let other = replaced.iter().find(|&&(part, _)| part == old);
            other.map(|&(_, other)| other)
        })
    }

    /// The node `old` with what has become of its parts.
    pub(super) fn with_parts(&mut self, old: Expr, known: &[Expr]) -> Expr {
        match self.node(old).clone() {
            Node::Number(_) | Node::Pi | Node::Symbol(_) => old,
            Node::Sum(terms) => {
                let terms: Vec<Expr> = terms.iter().map(|term| known[term.index()]).collect();
                self.sum(&terms)
            }
            Node::Product(factors) => {
                let factors: Vec<Expr> = factors.iter().map(|f| known[f.index()]).collect();
                self.product(&factors)
            }
            Node::Power(base, exponent) => self.power(known[base.index()], known[exponent.index()]),
            Node::Call(function, argument) => self.call(function, known[argument.index()]),
            Node::Switch {
                surface,
                above,
                below,
                edge,
            } => {
                let [surface, above, below] =
                    [surface, above, below].map(|part| known[part.index()]);
                self.switch(surface, above, below, edge)
            }
            Node::Floor(argument) => self.floor(known[argument.index()]),
            Node::Curve(id, argument, derivative) => {
                self.curve_at(id, known[argument.index()], derivative)
            }
        }
    }

    /// What an expression is where another one is negative: choices by the sign of that one, or of minus it, are made.
    pub fn where_negative(&mut self, expr: Expr, negative: Expr) -> Expr {
        let positive = self.neg(negative);
        self.rebuilt(expr, |graph, old, known| match *graph.node(old) {
            Node::Switch { surface, below, .. } if surface == negative => {
                Some(known[below.index()])
            }
            Node::Switch { surface, above, .. } if surface == positive => {
                Some(known[above.index()])
            }
            _ => None,
        })
    }

    /// A smooth expression that depends on all that `expr` does in any of its forms: each choice becomes a sum of what it
    /// chooses from and of what it chooses by, each function that is no formula its argument, in parts without a relation.
    ///
    /// Of each part p it is p + sin(p)/2 that is summed, which has a slope wherever p has and another one in each place: of parts
    /// that are linear a sum of p alone would stay as it is where all change together, which the expression does not.
    pub fn blended(&mut self, expr: Expr) -> Expr {
        let mut count = 0_u32;
        self.rebuilt(expr, |graph, old, known| {
            let parts: Vec<Expr> = match graph.node(old) {
                Node::Switch {
                    surface,
                    above,
                    below,
                    ..
                } => vec![*surface, *above, *below],
                Node::Floor(argument) | Node::Curve(_, argument, _) => vec![*argument],
                _ => return None,
            };
            let terms: Vec<Expr> = parts
                .into_iter()
                .map(|part| {
                    count += 1;
                    let weight = graph.number((f64::from(count) * BLEND).fract() + BLEND);
                    let (part, half) = (known[part.index()], graph.number(0.5));
                    let sine = graph.call(Function::Sin, part);
                    let ripple = graph.mul(half, sine);
                    let blend = graph.add(part, ripple);
                    graph.mul(weight, blend)
                })
                .collect();
            Some(graph.sum(&terms))
        })
    }

    /// The symbols that `expr` is made of, states before parameters, each in order.
    pub fn symbols(&self, expr: Expr) -> BTreeSet<Symbol> {
        self.symbols_of(&[expr])
    }

    /// The symbols that any of `exprs` is made of.
    pub fn symbols_of(&self, exprs: &[Expr]) -> BTreeSet<Symbol> {
        self.reachable(exprs)
            .into_iter()
            .filter_map(|part| match *self.node(part) {
                Node::Symbol(symbol) => Some(symbol),
                _ => None,
            })
            .collect()
    }

    /// Whether each of `exprs` has a state in it, looked at together.
    pub fn depend_on_state(&self, exprs: &[Expr]) -> Vec<bool> {
        self.depend_on(exprs, |symbol| matches!(symbol, Symbol::State(_)))
    }

    /// Whether each of `exprs` has a symbol in it that is asked for, looked at together.
    pub fn depend_on(&self, exprs: &[Expr], is_asked: impl Fn(Symbol) -> bool) -> Vec<bool> {
        let parts = self.reachable(exprs);
        let mut changes = vec![false; parts.last().map_or(0, |last| last.index() + 1)];
        for part in parts {
            let mut changing = match self.node(part) {
                Node::Symbol(symbol) => is_asked(*symbol),
                _ => false,
            };
            self.for_each_operand(part, |operand| changing |= changes[operand.index()]);
            changes[part.index()] = changing;
        }
        exprs.iter().map(|expr| changes[expr.index()]).collect()
    }

    /// Whether `expr` has a state in it, so that it may change along a trajectory.
    pub fn depends_on_state(&self, expr: Expr) -> bool {
        self.symbols(expr)
            .iter()
            .any(|symbol| matches!(symbol, Symbol::State(_)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expressions::Folding;

    #[test]
    fn symbols_are_swapped_at_once_and_the_result_simplified() {
        let mut graph = Graph::default();
        let (x, y, p) = (graph.state(0), graph.state(1), graph.parameter(0));
        let quotient = graph.div(x, y);
        let expr = graph.mul(p, quotient);
        let swapped = graph.substitute(expr, &|symbol| match symbol {
            Symbol::State(0) => Some(y),
            Symbol::State(1) => Some(x),
            _ => None,
        });
        let inverse = graph.div(y, x);
        assert_eq!(swapped, graph.mul(p, inverse));
        graph.set_folding(Folding::Continued);
        let both = graph.substitute(expr, &|symbol| (symbol == Symbol::State(0)).then_some(y));
        assert_eq!(both, p);
        assert!(graph.depends_on_state(expr) && !graph.depends_on_state(both));
        assert_eq!(
            graph.depend_on_state(&[both, expr, p, x]),
            [false, true, false, true]
        );
        let symbols: Vec<Symbol> = graph.symbols(expr).into_iter().collect();
        assert_eq!(
            symbols,
            [Symbol::State(0), Symbol::State(1), Symbol::Parameter(0)]
        );
    }
}
