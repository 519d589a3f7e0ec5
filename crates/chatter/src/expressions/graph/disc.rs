//! Directions: vectors divided by their length, as dry friction in the plane takes that of sliding, `v/hypot(u, v)`.
//!
//! Where such a vector vanishes its direction has no value. Beside that point each of the unit disc is one that motion there may
//! have in the mean, as between 1 and -1 each number is a sign of zero.

use crate::expressions::{Expr, Graph, Node};
use crate::numerics::{DoubleDouble, Real, Scalar};

/// A vector whose direction is asked for, as the sum of the squares of its components.
#[derive(Clone, Debug)]
pub(crate) struct Disc {
    /// That sum.
    pub square: Expr,
    /// Of each component what is squared, and the positive number that its square is multiplied by.
    parts: Vec<(Expr, DoubleDouble)>,
}

impl Disc {
    /// The components of the vector: the sum is that of their squares.
    pub fn components(&self, graph: &mut Graph) -> Vec<Expr> {
        let scaled = |&(part, weight): &(Expr, DoubleDouble)| {
            let scale = graph.number_exact(weight.sqrt());
            graph.mul(scale, part)
        };
        self.parts.iter().map(scaled).collect()
    }

    /// What each component of the direction adds to a field, where the vector vanishes; none if that is not told.
    pub fn columns(&self, graph: &mut Graph, field: &[Expr]) -> Option<Vec<Vec<Expr>>> {
        let free = self.along(graph, field, |_| 0.0)?;
        let mut by = Vec::with_capacity(self.parts.len());
        for place in 0..self.parts.len() {
            let with = self.along(graph, field, |i| if i == place { 1.0 } else { 0.0 })?;
            let added = with.iter().zip(&free);
            by.push(added.map(|(&with, &free)| graph.sub(with, free)).collect());
        }
        Some(by)
    }

    /// Expressions where the vector vanishes, its direction having these components; none if they ask for more than that.
    pub fn along(
        &self,
        graph: &mut Graph,
        exprs: &[Expr],
        direction: impl Fn(usize) -> f64,
    ) -> Option<Vec<Expr>> {
        let direction: Vec<f64> = (0..self.parts.len()).map(direction).collect();
        graph.in_direction(exprs, self, &direction)
    }
}

impl Graph {
    /// What expressions are multiplied by the inverse root of.
    pub(crate) fn squares_of_directions(&self, exprs: &[Expr]) -> Vec<Expr> {
        let mut found: Vec<Expr> = Vec::new();
        for expr in self.reachable(exprs) {
            if let Some((square, _)) = self.inverse_root(expr)
                && !found.contains(&square)
            {
                found.push(square);
            }
        }
        found
    }

    /// What an expression is the inverse root of, and what else it is divided by, as `1/(R*s)` is with a length s.
    pub(crate) fn inverse_root(&self, expr: Expr) -> Option<(Expr, Vec<Expr>)> {
        let Node::Power(base, exponent) = *self.node(expr) else {
            return None;
        };
        let exponent = self.as_number(exponent)?;
        if exponent == DoubleDouble::from(-0.5) {
            return Some((base, Vec::new()));
        }
        let Node::Product(factors) = self.node(base) else {
            return None;
        };
        let square = |&factor: &Expr| match *self.node(factor) {
            Node::Power(square, half) => {
                (self.as_number(half) == Some(DoubleDouble::from(0.5))).then_some(square)
            }
            _ => None,
        };
        let place = factors.iter().position(|factor| square(factor).is_some())?;
        let mut others = factors.to_vec();
        let root = others.remove(place);
        (exponent == -DoubleDouble::ONE).then_some((square(&root)?, others))
    }

    /// The vector that an expression is the squared length of; none if it is not the sum of two squares or more that change with the
    /// state.
    pub(crate) fn disc_of(&mut self, square: Expr) -> Option<Disc> {
        let Node::Sum(terms) = self.node(square).clone() else {
            return None;
        };
        let one = self.number(1.0);
        let mut parts = Vec::with_capacity(terms.len());
        for &term in terms.iter() {
            let (weight, rest) = self.split_coefficient(term, one);
            let Node::Power(part, exponent) = *self.node(rest) else {
                return None;
            };
            let is_squared = self.as_number(exponent) == Some(DoubleDouble::from(2.0));
            if !(is_squared && weight > DoubleDouble::ZERO && self.depends_on_state(part)) {
                return None;
            }
            parts.push((part, weight));
        }
        Some(Disc { square, parts })
    }

    /// Expressions where the vector vanishes and its direction is this one: each component divided by the length is a number, and the
    /// length, where it is not divided by, is zero. None if they ask for more than that.
    fn in_direction(
        &mut self,
        exprs: &[Expr],
        disc: &Disc,
        direction: &[f64],
    ) -> Option<Vec<Expr>> {
        let parts = self.reachable(exprs);
        let mut known = vec![self.number(0.0); parts.last().map_or(0, |last| last.index() + 1)];
        let mut has_value = vec![true; known.len()];
        // What has a component of the direction in it: as a term or a factor, once, and not otherwise.
        let mut directed = vec![false; known.len()];
        for old in parts {
            let mut all = true;
            self.for_each_operand(old, |operand| all &= has_value[operand.index()]);
            let inverse_of = |graph: &Self, expr: Expr| {
                let inverse = graph.inverse_root(expr);
                inverse.filter(|&(square, _)| square == disc.square)
            };
            let new = match self.node(old).clone() {
                Node::Power(..) if inverse_of(self, old).is_some() => None,
                Node::Power(base, exponent) if base == disc.square => {
                    let exponent = self.as_number(exponent).map_or(0.0, |e| e.high());
                    (exponent > 0.0).then(|| self.number(0.0))
                }
                Node::Product(factors) if !all => {
                    let over = |&factor: &Expr| !has_value[factor.index()];
                    let mut lost = factors.iter().filter(|factor| over(factor));
                    let place = lost.next().copied().filter(|_| lost.next().is_none());
                    let inverse = place.and_then(|place| Some((place, inverse_of(self, place)?)));
                    inverse.and_then(|(place, (_, others))| {
                        let rest: Vec<Expr> =
                            factors.iter().copied().filter(|&f| f != place).collect();
                        directed[old.index()] = true;
                        if rest.iter().any(|factor| directed[factor.index()]) {
                            return None;
                        }
                        let minus_one = self.number(-1.0);
                        let mut all =
                            vec![self.one_over_length(&rest, &known, (disc, direction))?];
                        for other in others {
                            all.push(self.power(known[other.index()], minus_one));
                        }
                        Some(self.product(&all))
                    })
                }
                node if all => {
                    let mut count = 0;
                    self.for_each_operand(old, |operand| {
                        count += u8::from(directed[operand.index()])
                    });
                    directed[old.index()] = count > 0;
                    let is_linear = match node {
                        Node::Sum(_) => true,
                        Node::Product(_) => count <= 1,
                        Node::Switch { surface, .. } => !directed[surface.index()],
                        _ => count == 0,
                    };
                    is_linear.then(|| self.with_parts(old, &known))
                }
                _ => None,
            };
            has_value[old.index()] = new.is_some();
            known[old.index()] = new.unwrap_or(old);
        }
        (exprs.iter())
            .map(|expr| has_value[expr.index()].then(|| known[expr.index()]))
            .collect()
    }

    /// A product divided by the length: by one factor that vanishes with that.
    fn one_over_length(
        &mut self,
        factors: &[Expr],
        known: &[Expr],
        by: (&Disc, &[f64]),
    ) -> Option<Expr> {
        for (place, &factor) in factors.iter().enumerate() {
            if let Some(divided) = self.over_length(factor, known, by) {
                let mut all: Vec<Expr> = factors.iter().map(|f| known[f.index()]).collect();
                all[place] = divided;
                return Some(self.product(&all));
            }
        }
        None
    }

    /// An expression divided by the length, if it is made of multiples of components.
    fn over_length(&mut self, expr: Expr, known: &[Expr], by: (&Disc, &[f64])) -> Option<Expr> {
        let (disc, direction) = by;
        let terms = self.terms_of(expr);
        for (&(part, weight), &along) in disc.parts.iter().zip(direction) {
            let of = self.terms_of(part);
            if let Some(factor) = self.factor_between(&terms, &of) {
                let along = self.number_exact(DoubleDouble::from(along) / weight.sqrt());
                return Some(self.mul(factor, along));
            }
        }
        match self.node(expr).clone() {
            Node::Sum(terms) => {
                let divided: Option<Vec<Expr>> = (terms.iter())
                    .map(|&term| self.over_length(term, known, by))
                    .collect();
                divided.map(|terms| self.sum(&terms))
            }
            Node::Product(factors) => self.one_over_length(&factors, known, by),
            Node::Power(base, exponent) => {
                let exponent = self.as_number(exponent)?;
                if !(exponent.is_whole() && exponent.high() >= 2.0) {
                    return None;
                }
                let divided = self.over_length(base, known, by)?;
                let less = self.number_exact(exponent - DoubleDouble::ONE);
                let rest = self.power(known[base.index()], less);
                Some(self.mul(divided, rest))
            }
            _ => None,
        }
    }
}
