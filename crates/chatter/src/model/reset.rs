//! Impacts given by what they make of the state.

use super::identically_zero::is_identically_zero;
use super::{Contact, State};
use crate::expressions::{Expr, Graph, Node, Symbol};

impl Contact {
    /// Finds impulse and restitution behind a reset.
    ///
    /// A reset x+ = x + v w that changes nothing where there is no rate v is an impulse: chatter along it comes to its end, and
    /// persistent contact follows. Any other is kept as it is, and the impulse is one that stops the rate.
    pub(super) fn as_impulse(&mut self, graph: &mut Graph, states: &[State], parameters: usize) {
        let Some(reset) = self.reset.clone() else {
            return;
        };
        let field: Vec<Expr> = states.iter().map(|state| state.derivative).collect();
        let rate = graph.lie_derivative(self.gap, &field);
        let zero = graph.number(0.0);
        let slopes: Vec<Expr> = (0..states.len())
            .map(|i| graph.derivative(rate, Symbol::State(i)))
            .collect();
        let changes: Vec<Expr> = (reset.iter().enumerate())
            .map(|(i, &after)| {
                let before = graph.state(i);
                graph.sub(after, before)
            })
            .collect();
        let Some(along) = slopes.iter().position(|&slope| slope != zero) else {
            self.impulse = slopes;
            self.restitution = zero;
            return;
        };
        let parts: Vec<Expr> = (changes.iter())
            .map(|&change| {
                let part = graph.derivative(change, Symbol::State(along));
                graph.div(part, slopes[along])
            })
            .collect();
        let smooth = graph
            .reachable(&[&reset[..], &[rate]].concat())
            .iter()
            .all(|&part| {
                !matches!(
                    graph.node(part),
                    Node::Switch { .. } | Node::Floor(_) | Node::Curve(..)
                )
            });
        let is_impulse = smooth
            && (changes.iter().zip(&parts)).all(|(&change, &part)| {
                let whole = graph.mul(rate, part);
                let rest = graph.sub(change, whole);
                is_identically_zero(graph, rest, states.len(), parameters)
            });
        if is_impulse {
            // The rate after is v (1 + L_w v).
            let gain = graph.lie_derivative(rate, &parts);
            let one = graph.number(1.0);
            let sum = graph.add(one, gain);
            self.restitution = graph.neg(sum);
            self.impulse = parts;
            self.reset = None;
            return;
        }
        // Nothing follows from it for ever smaller rates: as with a restitution of one.
        self.restitution = graph.number(1.0);
        self.impulse = vec![zero; states.len()];
        self.impulse[along] = graph.number(1.0);
    }
}
