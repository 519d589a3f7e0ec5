//! What forces hold: fields by which it is kept to the last digit, and what is zero because of it.

use super::Mechanics;
use crate::expressions::{Expr, Graph, Symbol};
use crate::numerics::Real;

impl Mechanics {
    /// Writes a field that keeps functions, each by a force along a direction, so that nothing of their rates is left to rounding: what is
    /// left of several forces that cancel would move what rests, as the square of the time.
    ///
    /// By L_f h = 0 the component of a state on which h depends by a number is a sum of the others, of all functions at once by
    /// elimination. The field is the same function as before.
    pub(super) fn keep_exactly(&mut self, held: &[(Expr, Vec<Expr>)], field: &mut [Expr]) {
        let graph = &mut self.graph;
        let zero = graph.number(0.0);
        if (held.iter()).all(|(function, _)| graph.lie_derivative(*function, field) == zero) {
            return;
        }
        let states = 0..field.len();
        let is_pushed = |state: usize| held.iter().any(|(_, along)| along[state] != zero);
        let pushed: Vec<usize> = states.clone().filter(|&state| is_pushed(state)).collect();
        let symbols: Vec<Symbol> = states.clone().map(Symbol::State).collect();
        let mut rows: Vec<Vec<Expr>> = (held.iter())
            .map(|(function, _)| graph.gradient(*function, &symbols))
            .collect();
        let mut pivots: Vec<(usize, usize)> = Vec::new();
        for row in 0..rows.len() {
            let mut best: Option<(usize, f64)> = None;
            for &state in &pushed {
                let number = graph.as_number(rows[row][state]);
                let size = number.map_or(0.0, |number| number.to_f64().abs());
                let is_free = pivots.iter().all(|&(_, taken)| taken != state);
                if is_free && size > best.map_or(0.0, |(_, most)| most) {
                    best = Some((state, size));
                }
            }
            let Some((state, _)) = best else { continue };
            let own = rows[row].clone();
            for (index, other) in rows.iter_mut().enumerate() {
                if index == row || other[state] == zero {
                    continue;
                }
                let factor = graph.div(other[state], own[state]);
                for (entry, &own) in other.iter_mut().zip(&own) {
                    let product = graph.mul(factor, own);
                    *entry = graph.sub(*entry, product);
                }
            }
            pivots.push((row, state));
        }
        for &(row, state) in &pivots {
            let others = states.clone().filter(|&i| pivots.iter().all(|p| p.1 != i));
            let terms: Vec<Expr> = others.map(|i| graph.mul(rows[row][i], field[i])).collect();
            let sum = graph.sum(&terms);
            let rate = graph.div(sum, rows[row][state]);
            field[state] = graph.neg(rate);
        }
    }

    /// Which of some functions are zero wherever these contacts are closed, for the gaps, rates of contacts and of sliding, and surfaces
    /// that are held at zero with them. Each of those, as far as it has a state by a number, tells that state by others.
    pub(crate) fn held_at_zero(&mut self, closed: &[usize], functions: &[Expr]) -> Vec<bool> {
        let contacts = closed.iter().map(|&contact| &self.contacts[contact]);
        let mut held: Vec<Expr> = contacts.flat_map(|c| [c.gap, c.rate]).collect();
        let sticks = self.sticks.iter();
        held.extend({ sticks }.filter_map(|s| closed.contains(&s.contact).then_some(s.rate)));
        let slides = self.slides.iter().filter(|slide| !slide.is_component);
        held.extend(
            slides.flat_map(|slide| [Some(slide.surface), slide.rate].into_iter().flatten()),
        );
        if held.is_empty() {
            return vec![false; functions.len()];
        }
        let mut told: Vec<(usize, Expr)> = Vec::new();
        for function in held {
            let graph = &mut self.graph;
            let rest = by(graph, function, &told);
            let found = (0..self.field.len()).find_map(|state| {
                let slope = graph.derivative(rest, Symbol::State(state));
                let is_number = graph.as_number(slope)?.to_f64() != 0.0;
                is_number.then_some((state, slope))
            });
            let Some((state, slope)) = found else {
                continue;
            };
            let own = graph.state(state);
            let off = graph.div(rest, slope);
            let value = graph.sub(own, off);
            for (_, before) in &mut told {
                *before = by(graph, *before, &[(state, value)]);
            }
            told.push((state, value));
        }
        functions
            .iter()
            .map(|&function| {
                let left = by(&mut self.graph, function, &told);
                self.vanishes(left)
            })
            .collect()
    }
}

/// A function where states are told by others.
fn by(graph: &mut Graph, function: Expr, told: &[(usize, Expr)]) -> Expr {
    graph.substitute(function, &|symbol| match symbol {
        Symbol::State(index) => told.iter().find(|(state, _)| *state == index).map(|t| t.1),
        Symbol::Parameter(_) => None,
    })
}
