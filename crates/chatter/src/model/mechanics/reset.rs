//! Impacts given by what they make of the state.

use super::identically_zero::is_identically_zero;
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Contact, State};

impl Contact {
    /// Makes the choices that the sign of the gap rate decides: at an impact it is negative. So `abs(v)` in a restitution is no
    /// corner of the motion.
    pub(in crate::model) fn decide_at_impact(&mut self, graph: &mut Graph, states: &[State]) {
        let field: Vec<Expr> = states.iter().map(|state| state.derivative).collect();
        let rate = graph.lie_derivative(self.gap, &field);
        let parts = (self.impulse.iter_mut()).chain(self.reset.iter_mut().flatten());
        for part in parts.chain([&mut self.restitution]) {
            *part = graph.where_negative(*part, rate);
        }
    }

    /// Finds impulse and restitution behind a reset.
    ///
    /// A reset x+ = x + v w that changes nothing where there is no rate v is an impulse: chatter along it comes to its end, and
    /// persistent contact follows. Any other is kept as it is, and the impulse is one that stops the rate.
    pub(in crate::model) fn as_impulse(
        &mut self,
        graph: &mut Graph,
        states: &[State],
        parameters: usize,
    ) {
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
        if slopes.iter().all(|&slope| slope == zero) {
            self.impulse = slopes;
            self.restitution = zero;
            return;
        }
        // Along the rate's gradient by what the gap leaves out, the velocities: by a position it may vanish in flight.
        let velocities: Vec<usize> = (0..states.len())
            .filter(|&i| slopes[i] != zero && graph.derivative(self.gap, Symbol::State(i)) == zero)
            .collect();
        let along: Vec<usize> = match velocities.is_empty() {
            true => (0..states.len()).filter(|&i| slopes[i] != zero).collect(),
            false => velocities,
        };
        let squares: Vec<Expr> = (along.iter())
            .map(|&i| graph.mul(slopes[i], slopes[i]))
            .collect();
        let square = graph.sum(&squares);
        let parts: Vec<Expr> = (changes.iter())
            .map(|&change| {
                let terms: Vec<Expr> = (along.iter())
                    .map(|&i| {
                        let part = graph.derivative(change, Symbol::State(i));
                        graph.mul(slopes[i], part)
                    })
                    .collect();
                let part = graph.sum(&terms);
                graph.div(part, square)
            })
            .collect();
        let smooth = !graph.has_corner(&[&reset[..], &[rate]].concat());
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
        for i in along {
            self.impulse[i] = slopes[i];
        }
    }
}
