//! Replacing symbols by expressions, and asking which symbols an expression has.

use super::graph::{Expr, Graph, Node, Symbol};
use std::collections::BTreeSet;

impl Graph {
    /// `expr` with every symbol for which `replacement` gives an expression replaced by it, all at once, and simplified
    /// again. Shared subexpressions are rebuilt once.
    pub fn substitute(&mut self, expr: Expr, replacement: &dyn Fn(Symbol) -> Option<Expr>) -> Expr {
        let mut known = vec![expr; expr.index() + 1];
        for old in self.reachable(&[expr]) {
            known[old.index()] = match self.node(old).clone() {
                Node::Number(_) | Node::Pi => old,
                Node::Symbol(symbol) => replacement(symbol).unwrap_or(old),
                Node::Sum(terms) => {
                    let terms: Vec<Expr> = terms.iter().map(|term| known[term.index()]).collect();
                    self.sum(&terms)
                }
                Node::Product(factors) => {
                    let factors: Vec<Expr> = factors.iter().map(|f| known[f.index()]).collect();
                    self.product(&factors)
                }
                Node::Power(base, exponent) => {
                    self.power(known[base.index()], known[exponent.index()])
                }
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
            };
        }
        known[expr.index()]
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
    use super::super::Folding;
    use super::*;

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
