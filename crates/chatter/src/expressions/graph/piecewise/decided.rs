//! Choices that another choice decides: `clamp(2*sign(v), -1, 1)` is `sign(v)`.
//!
//! Where what a choice is made by takes no values but those that one other surface chooses from, it has no surface of its own: a motion that comes
//! to rest on the other one would find this one crossed at that instant, and by how far is nothing that the motion decides.

use super::Edge;
use crate::expressions::{Expr, Graph, Node};
use crate::numerics::DoubleDouble;

/// An expression is looked into no deeper than this.
const DEPTH: usize = 16;

/// Values this small against the largest terms that they may be sums of are rounding.
const ROUNDING: f64 = 1e-25;

/// What an expression is where one surface is positive, negative and zero; no surface where it is the same everywhere.
#[derive(Clone, Copy)]
struct Sided {
    surface: Option<Expr>,
    values: [DoubleDouble; 3],
    /// The largest term of each.
    sizes: [f64; 3],
}

impl Sided {
    fn with(
        self,
        other: Self,
        of: impl Fn(DoubleDouble, DoubleDouble) -> DoubleDouble,
    ) -> Option<Self> {
        let surface = match (self.surface, other.surface) {
            (Some(a), Some(b)) if a != b => return None,
            (a, b) => a.or(b),
        };
        let values = [0, 1, 2].map(|k| of(self.values[k], other.values[k]));
        let size = |k: usize| {
            let own = self.sizes[k].max(other.sizes[k]);
            own.max(values[k].high().abs())
        };
        Some(Self {
            surface,
            values,
            sizes: [0, 1, 2].map(size),
        })
    }

    /// The sign of each value, as far as it can be told from zero.
    fn signs(&self) -> Option<[f64; 3]> {
        let mut signs = [0.0; 3];
        for (sign, (value, size)) in signs.iter_mut().zip(self.values.iter().zip(self.sizes)) {
            let value = value.high();
            let is_told = value == 0.0 || value.abs() > ROUNDING * size;
            *sign = match is_told && value.is_finite() {
                true if value == 0.0 => 0.0,
                true => value.signum(),
                false => return None,
            };
        }
        Some(signs)
    }
}

impl Graph {
    /// The choice by another surface that a choice comes to, if it does.
    pub(super) fn decided(
        &mut self,
        surface: Expr,
        above: Expr,
        below: Expr,
        edge: Edge,
    ) -> Option<Expr> {
        let by = self.sided(surface, DEPTH)?;
        let other = by.surface?;
        let signs = by.signs()?;
        let pick = |sign: f64| edge.chosen(sign, above, below);
        let [positive, negative] = [pick(signs[0])?, pick(signs[1])?];
        let [positive, negative] = [(positive, 0), (negative, 1)].map(|(piece, side)| {
            let known = self.sided(piece, DEPTH);
            let known = known.filter(|piece| piece.surface == Some(other));
            known.map_or(piece, |known| self.number_exact(known.values[side]))
        });
        // Where the other surface is zero.
        let value = |graph: &Self, piece: Expr, at: usize| {
            let known = graph.sided(piece, DEPTH);
            known
                .filter(|known| known.surface.is_none_or(|surface| surface == other))
                .map(|known| known.values[at])
        };
        let half = DoubleDouble::from(0.5);
        let at_zero = match pick(signs[2]) {
            Some(piece) => value(self, piece, 2),
            None => value(self, above, 2)
                .zip(value(self, below, 2))
                .map(|(above, below)| (above + below) * half),
        };
        let sides = [value(self, positive, 0), value(self, negative, 1)];
        let edge = match (at_zero, sides) {
            (Some(zero), [Some(positive), _]) if zero == positive => Edge::Above,
            (Some(zero), [_, Some(negative)]) if zero == negative => Edge::Below,
            (Some(zero), [Some(positive), Some(negative)])
                if zero == (positive + negative) * half =>
            {
                Edge::Middle
            }
            (None, _) if pick(signs[2]) == pick(signs[0]) => Edge::Above,
            (None, _) if pick(signs[2]) == pick(signs[1]) => Edge::Below,
            _ => return None,
        };
        Some(self.switch(other, positive, negative, edge))
    }

    fn sided(&self, expr: Expr, depth: usize) -> Option<Sided> {
        let depth = depth.checked_sub(1)?;
        let all = |value: DoubleDouble| Sided {
            surface: None,
            values: [value; 3],
            sizes: [value.high().abs(); 3],
        };
        match self.node(expr) {
            Node::Number(number) => Some(all(number.value())),
            Node::Pi => Some(all(DoubleDouble::PI)),
            Node::Sum(terms) => {
                let mut terms = terms.iter().map(|&term| self.sided(term, depth));
                let first = terms.next()??;
                terms.try_fold(first, |sum, term| sum.with(term?, |a, b| a + b))
            }
            Node::Product(factors) => {
                let mut factors = factors.iter().map(|&factor| self.sided(factor, depth));
                let first = factors.next()??;
                factors.try_fold(first, |product, factor| product.with(factor?, |a, b| a * b))
            }
            &Node::Switch {
                surface,
                above,
                below,
                edge,
            } => self.sided_choice((surface, edge), [above, below], depth),
            _ => None,
        }
    }

    fn sided_choice(
        &self,
        (surface, edge): (Expr, Edge),
        pieces: [Expr; 2],
        depth: usize,
    ) -> Option<Sided> {
        let [above, below] = pieces.map(|piece| self.sided(piece, depth));
        let (above, below) = (above?, below?);
        // Two that are of one surface, or of none, if they are at all.
        let both = above.with(below, |a, _| a)?;
        let chosen = |sign: f64, k: usize| {
            edge.choose(DoubleDouble::from(sign), above.values[k], below.values[k])
        };
        let (own, signs) = match self.sided(surface, depth) {
            Some(by) => (by.surface?, by.signs()?),
            None => (surface, [1.0, -1.0, 0.0]),
        };
        if both.surface.is_some_and(|other| other != own) {
            return None;
        }
        Some(Sided {
            surface: Some(own),
            values: [0, 1, 2].map(|k| chosen(signs[k], k)),
            sizes: both.sizes,
        })
    }

    /// What has the sign of a surface, as the base of an odd power has, and a factor beside its own size.
    pub(super) fn same_sign(&mut self, surface: Expr) -> Expr {
        match self.node(surface).clone() {
            Node::Power(base, exponent) => {
                let whole = self.as_number(exponent).map(DoubleDouble::high);
                let is_odd = whole.is_some_and(|n| n > 0.0 && libm::fmod(n, 2.0) == 1.0);
                if is_odd { base } else { surface }
            }
            Node::Product(factors) => {
                // |x| beside x.
                let is_own_size = |&factor: &Expr| match *self.node(factor) {
                    Node::Switch {
                        surface,
                        above,
                        below,
                        ..
                    } => {
                        let mut others = factors.iter().filter(|&&other| other != factor);
                        surface == above
                            && self.is_negative_of(below, above)
                            && others.any(|&other| other == above)
                    }
                    _ => false,
                };
                match factors.iter().position(is_own_size) {
                    Some(place) => {
                        let mut left = factors.to_vec();
                        left.remove(place);
                        self.product(&left)
                    }
                    None => surface,
                }
            }
            _ => surface,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(graph: &mut Graph, text: &str) -> Expr {
        let (v, w) = (graph.state(0), graph.state(1));
        let resolve = |name: &str| match name {
            "v" => Some(v),
            "w" => Some(w),
            _ => None,
        };
        graph.parse(text, &resolve, &["v", "w"]).unwrap()
    }

    #[test]
    fn what_another_choice_decides_is_that_choice() {
        let mut graph = Graph::default();
        for (text, same) in [
            ("clamp(2*sign(v), -1, 1)", "sign(v)"),
            ("min(1, max(-1, sign(v)*2))", "sign(v)"),
            ("sign(sign(v))", "sign(v)"),
            ("if(sign(v) > 0.5, 1, if(sign(v) < -0.5, -1, 0))", "sign(v)"),
            ("sign(v^3)", "sign(v)"),
            ("sign(v*abs(v))", "sign(v)"),
            ("sign(-2*v*abs(v))", "sign(-v)"),
            ("if(step(v) > 0.5, w, 2*w)", "if(v >= 0, w, 2*w)"),
            ("if(sign(v) >= 0, w, 2*w)", "if(v >= 0, w, 2*w)"),
            ("if(sign(v - w) > 0, w, 2*v)", "if(v > w, w, 2*v)"),
        ] {
            let found = parsed(&mut graph, text);
            let same = parsed(&mut graph, same);
            assert_eq!(found, same, "{text}");
        }
    }

    #[test]
    fn no_choice_changes_its_values() {
        let mut graph = Graph::default();
        for (text, plain) in [
            ("max(0.3*sign(v), 0.7*sign(v))", [0.7, -0.3, 0.0]),
            ("abs(sign(v))*sign(v)", [1.0, -1.0, 0.0]),
            ("clamp(0.4*sign(v), -0.5, 0.5)", [0.4, -0.4, 0.0]),
            ("sign(pi*sign(v) + 1)", [1.0, -1.0, 1.0]),
            ("sign(sign(v) + 1)", [1.0, 0.0, 1.0]),
            ("step(sign(v) - 1)", [1.0, 0.0, 0.0]),
            ("sign(0.1 + 0.2*step(v) - 0.3)", [0.0, -1.0, 0.0]),
            ("sign(sign(v) + sign(w))", [1.0, 0.0, 1.0]),
        ] {
            let found = parsed(&mut graph, text);
            for (v, expected) in [2.0, -1e-9, 0.0].into_iter().zip(plain) {
                let value = graph.evaluate(found, &[v, 1.0], &[]);
                assert_eq!(value, expected, "{text} at {v}");
            }
        }
    }
}
