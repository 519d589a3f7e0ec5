//! Expressions as fractions with a sign, the way formulas are written.

use super::number_text::{NumberText, number_text};
use crate::expressions::{Expr, Graph, Node};
use crate::numerics::DoubleDouble;

/// How tightly a formula holds together, loosest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::expressions) enum Binding {
    Sum,
    Product,
    Power,
    Atom,
}

/// A factor above or below the line.
pub(in crate::expressions) enum Piece {
    Number(String),
    /// A base with an exponent above zero.
    Power(Expr, DoubleDouble),
    Whole(Expr),
}

/// A term: its sign, and what stands above and below the line.
#[derive(Default)]
pub(in crate::expressions) struct Fraction {
    pub negative: bool,
    pub above: Vec<Piece>,
    pub below: Vec<Piece>,
}

impl Graph {
    /// The sign of `expr` and what stands above and below the line.
    pub(in crate::expressions) fn fraction(&self, expr: Expr) -> Fraction {
        let mut fraction = Fraction::default();
        let factors = match self.node(expr) {
            Node::Product(factors) => &factors[..],
            _ => core::slice::from_ref(&expr),
        };
        for &factor in factors {
            match self.node(factor) {
                Node::Number(number) => {
                    let value = number.value();
                    let negative = value.high() < 0.0;
                    let size = if negative { -value } else { value };
                    fraction.negative ^= negative;
                    match number_text(size) {
                        NumberText::Decimal(text) if text == "1" => {}
                        NumberText::Decimal(text) => fraction.above.push(Piece::Number(text)),
                        NumberText::Ratio(above, below) => {
                            if above != 1 {
                                fraction.above.push(Piece::Number(above.to_string()));
                            }
                            fraction.below.push(Piece::Number(below.to_string()));
                        }
                    }
                }
                &Node::Power(base, exponent) => match self.as_number(exponent) {
                    Some(weight) if weight.high() < 0.0 => {
                        fraction.below.push(Piece::Power(base, -weight));
                    }
                    Some(weight) => fraction.above.push(Piece::Power(base, weight)),
                    None => fraction.above.push(Piece::Whole(factor)),
                },
                _ => fraction.above.push(Piece::Whole(factor)),
            }
        }
        if fraction.above.is_empty() {
            fraction.above.push(Piece::Number("1".to_string()));
        }
        fraction
    }

    /// How tightly the formula of `expr` holds together.
    pub(in crate::expressions) fn binding(&self, expr: Expr) -> Binding {
        match self.node(expr) {
            Node::Sum(_) => Binding::Sum,
            Node::Pi
            | Node::Symbol(_)
            | Node::Call(..)
            | Node::Switch { .. }
            | Node::Floor(_)
            | Node::Curve(..) => Binding::Atom,
            Node::Number(_) | Node::Product(_) | Node::Power(..) => {
                let fraction = self.fraction(expr);
                if fraction.negative {
                    return Binding::Sum;
                }
                match (&fraction.above[..], &fraction.below[..]) {
                    ([Piece::Number(_)], []) => Binding::Atom,
                    ([Piece::Power(_, weight)], []) if is_root(*weight) => Binding::Atom,
                    ([Piece::Power(..) | Piece::Whole(_)], []) => Binding::Power,
                    _ => Binding::Product,
                }
            }
        }
    }
}

/// Whether a power is written as a square root.
pub(in crate::expressions) fn is_root(weight: DoubleDouble) -> bool {
    weight == DoubleDouble::from(0.5)
}
