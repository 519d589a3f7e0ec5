//! Roots of squares and of products: written as sizes, which have a corner where those have no series.

use super::number::{Number, folded_power, folded_product};
use crate::expressions::{Expr, Graph, Node};
use crate::numerics::{DoubleDouble, Real, Scalar};

/// A factor of a product.
#[derive(Clone, Copy)]
struct Factor {
    /// What the product changes its sign with, or an even power is taken of.
    of: Expr,
    exponent: DoubleDouble,
}

impl Factor {
    fn changes_sign(self) -> bool {
        libm::fmod(self.exponent.high(), 2.0) != 0.0
    }
}

impl Graph {
    /// Expressions in which roots of squares are sizes, and roots of what is known to be the size of a product, as `max(x*y, 0)^1.5` and
    /// `sqrt(abs(x*y))` take them, are products of roots of the sizes of its factors. Where such a product vanishes one of its factors does:
    /// choices by its sign are made by those of the factors, so that what vanishes with a root is one surface, with a sign.
    pub(crate) fn with_sizes(&mut self, exprs: &[Expr]) -> Vec<Expr> {
        let mut products = Vec::new();
        let mut sized = Vec::with_capacity(exprs.len());
        for &expr in exprs {
            sized.push(
                self.rebuilt(expr, |graph, old, known| match *graph.node(old) {
                    Node::Power(base, exponent) => {
                        let [base, exponent] = [base, exponent].map(|part| known[part.index()]);
                        graph
                            .root_of_square(base, exponent)
                            .or_else(|| graph.root_of_choice((base, exponent), &mut products))
                    }
                    Node::Product(_) => {
                        let product = graph.with_parts(old, known);
                        graph.with_directions(product)
                    }
                    Node::Switch { .. } => {
                        let choice = graph.with_parts(old, known);
                        graph.with_roots_of_factors(choice, &mut products)
                    }
                    _ => None,
                }),
            );
        }
        if products.is_empty() {
            return sized;
        }
        (sized.into_iter())
            .map(|expr| {
                self.rebuilt(expr, |graph, old, known| match *graph.node(old) {
                    Node::Switch {
                        surface,
                        above,
                        below,
                        edge,
                    } if products.contains(&surface) => {
                        let [mut above, mut below] = [above, below].map(|part| known[part.index()]);
                        let changing: Vec<Expr> = (graph.factors_of(surface)?.into_iter())
                            .filter(|factor| factor.changes_sign())
                            .map(|factor| factor.of)
                            .collect();
                        for factor in changing {
                            let [positive, negative] = [(above, below), (below, above)]
                                .map(|(above, below)| graph.switch(factor, above, below, edge));
                            (above, below) = (positive, negative);
                        }
                        Some(above)
                    }
                    _ => None,
                })
            })
            .collect()
    }

    /// The constant factors of the terms of a sum; none of anything else.
    pub(crate) fn constants_in_sum(&mut self, sum: Expr) -> Vec<Expr> {
        match self.node(sum) {
            Node::Sum(_) => (self.terms_of(sum).into_iter())
                .map(|term| term.constant)
                .collect(),
            _ => Vec::new(),
        }
    }

    /// The root, or another power that is none, of an even power of something, maybe times a constant: a power of its size.
    fn root_of_square(&mut self, base: Expr, exponent: Expr) -> Option<Expr> {
        let weight = self.as_number(exponent)?;
        if Number::new(weight).as_integer().is_some() {
            return None;
        }
        let one = self.number(1.0);
        let (coefficient, square) = self.split_coefficient(base, one);
        let &Node::Power(inner, inner_exponent) = self.node(square) else {
            return None;
        };
        let inner_weight = self.as_number(inner_exponent)?;
        let half = Number::new(folded_product(inner_weight, DoubleDouble::from(0.5))?);
        if half.as_integer().is_none() || coefficient.high() < 0.0 {
            return None;
        }
        let merged = folded_product(inner_weight, weight)?;
        let outside = match coefficient == DoubleDouble::ONE {
            true => DoubleDouble::ONE,
            false => folded_power(coefficient, weight)?,
        };
        let outside = self.number_exact(outside);
        let size = self.power_of_size(inner, merged);
        Some(self.product(&[outside, size]))
    }

    /// `|x|^exponent`, with as few sizes in it as there may be.
    fn power_of_size(&mut self, x: Expr, exponent: DoubleDouble) -> Expr {
        let whole = Number::new(exponent).as_integer();
        let of = match whole {
            Some(whole) if whole % 2 == 0 => x,
            Some(whole) if whole > 1 => {
                let rest = self.number(f64::from(whole - 1));
                let (rest, size) = (self.power(x, rest), self.abs(x));
                return self.product(&[rest, size]);
            }
            _ => self.abs(x),
        };
        let exponent = self.number_exact(exponent);
        self.power(of, exponent)
    }

    /// A product in which something is divided by its own size, as the sign of that.
    fn with_directions(&mut self, product: Expr) -> Option<Expr> {
        let Node::Product(factors) = self.node(product).clone() else {
            return None;
        };
        for &divisor in factors.iter() {
            let (size, exponent) = self.split_exponent(divisor);
            let Some(of) = self
                .size_of(size)
                .filter(|_| exponent == -DoubleDouble::ONE)
            else {
                continue;
            };
            let is_whole_power = |graph: &Self, factor| {
                let (base, exponent) = graph.split_exponent(factor);
                base == of && exponent.is_whole() && exponent > DoubleDouble::ZERO
            };
            let Some(&divided) = factors.iter().find(|&&f| is_whole_power(self, f)) else {
                continue;
            };
            let rest = self.split_exponent(divided).1 - DoubleDouble::ONE;
            let rest = self.number_exact(rest);
            let (rest, direction) = (self.power(of, rest), self.sign(of));
            let others = factors.iter().filter(|&&f| f != divided && f != divisor);
            let parts: Vec<Expr> = others.copied().chain([rest, direction]).collect();
            return Some(self.product(&parts));
        }
        None
    }

    /// The power of a choice by the sign of a product, as the choice between powers.
    fn root_of_choice(
        &mut self,
        (base, exponent): (Expr, Expr),
        products: &mut Vec<Expr>,
    ) -> Option<Expr> {
        let &Node::Switch {
            surface,
            above,
            below,
            edge,
        } = self.node(base)
        else {
            return None;
        };
        self.factors_of(surface)?;
        let [above, below] = [above, below].map(|piece| self.power(piece, exponent));
        let choice = self.switch(surface, above, below, edge);
        self.with_roots_of_factors(choice, products)
    }

    /// A choice by the sign of a product, with roots of the product's multiples on each side as roots of the sizes of its factors;
    /// none where there are no such roots.
    fn with_roots_of_factors(&mut self, choice: Expr, products: &mut Vec<Expr>) -> Option<Expr> {
        let &Node::Switch {
            surface,
            above,
            below,
            edge,
        } = self.node(choice)
        else {
            return None;
        };
        let factors = self.factors_of(surface)?;
        let negative = self.neg(surface);
        let pieces = [(above, surface), (below, negative)].map(|(piece, positive)| {
            let new = |graph: &mut Self, factor, _: (Expr, Expr), exponent| {
                graph.root_of_factors((factor, &factors), exponent)
            };
            self.with_powers(&[piece], &[positive], new)[0]
        });
        if pieces == [above, below] {
            return None;
        }
        if !products.contains(&surface) {
            products.push(surface);
        }
        Some(self.switch(surface, pieces[0], pieces[1], edge))
    }

    /// The power of a constant times the size of a product.
    fn root_of_factors(
        &mut self,
        (constant, factors): (Expr, &[Factor]),
        exponent: Expr,
    ) -> Option<Expr> {
        let mut parts = vec![self.power(constant, exponent)];
        for factor in factors {
            parts.push(match self.as_number(exponent) {
                Some(weight) => {
                    self.power_of_size(factor.of, folded_product(factor.exponent, weight)?)
                }
                None => {
                    let own = self.number_exact(factor.exponent);
                    let (size, exponent) = (self.abs(factor.of), self.mul(own, exponent));
                    self.power(size, exponent)
                }
            });
        }
        Some(self.product(&parts))
    }

    /// What a product of several moving factors vanishes with: the bases of whole powers in it, constant factors in the first that
    /// is no power.
    fn factors_of(&mut self, product: Expr) -> Option<Vec<Factor>> {
        let Node::Product(all) = self.node(product).clone() else {
            return None;
        };
        let moves = self.depend_on_state(&all);
        let mut constants = Vec::new();
        let mut factors = Vec::new();
        for (&factor, moves) in all.iter().zip(moves) {
            if !moves {
                constants.push(factor);
                continue;
            }
            let (of, exponent) = self.split_exponent(factor);
            if !exponent.is_whole() {
                return None;
            }
            factors.push(Factor { of, exponent });
        }
        if factors.len() < 2 {
            return None;
        }
        if !constants.is_empty() {
            let first = (factors.iter_mut()).find(|factor| factor.exponent == DoubleDouble::ONE)?;
            constants.push(first.of);
            first.of = self.product(&constants);
        }
        Some(factors)
    }
}
