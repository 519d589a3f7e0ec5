//! Where an expression has a value, as far as its form says so.
//!
//! Folding keeps to it: `x/x` is not 1, since it has no value at zero, nor is `0*log(x)` zero or `sqrt(x)^2` plainly x.

use super::number::{Number, folded_sum};
use crate::expressions::{Expr, Function, Graph, Node};
use crate::numerics::{DoubleDouble, Real};

/// What a simplification may do to the set of points where an expression has a value.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Folding {
    /// Nothing: for what somebody wrote.
    #[default]
    Exact,
    /// Fill it up where the values on all sides agree: for what is derived from equations that are themselves evaluated
    /// as they were written, so that `(1/m)/(1/m)` is exactly 1.
    Continued,
}

/// The sign of an expression wherever it has a value.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(in crate::expressions) enum Sign {
    Unknown,
    NotNegative,
    Positive,
}

/// What the form of an expression says of its values.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::expressions) struct Domain {
    /// It has a value at every point.
    pub total: bool,
    pub sign: Sign,
}

/// What a power with a numeric exponent asks of its base.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(in crate::expressions) struct Demands {
    pub not_zero: bool,
    pub not_negative: bool,
}

impl Demands {
    pub fn of(exponent: DoubleDouble) -> Self {
        Self {
            not_zero: exponent.high() < 0.0,
            not_negative: Number::new(exponent).as_integer().is_none()
                && libm::rint(exponent.high()) != exponent.high()
                || exponent.low() != 0.0,
        }
    }

    pub fn and(self, other: Self) -> Self {
        Self {
            not_zero: self.not_zero || other.not_zero,
            not_negative: self.not_negative || other.not_negative,
        }
    }
}

impl Graph {
    /// What `node` says of its values, given the same of its operands.
    pub(in crate::expressions) fn domain_of(&self, node: &Node) -> Domain {
        match node {
            Node::Number(number) => {
                let sign = match number.value().high() {
                    value if value > 0.0 => Sign::Positive,
                    0.0 => Sign::NotNegative,
                    _ => Sign::Unknown,
                };
                Domain { total: true, sign }
            }
            Node::Pi => Domain {
                total: true,
                sign: Sign::Positive,
            },
            Node::Symbol(_) => Domain {
                total: true,
                sign: Sign::Unknown,
            },
            Node::Sum(terms) => {
                let parts = || terms.iter().map(|&term| self.domain(term));
                let least = parts().map(|part| part.sign).min();
                let most = parts().map(|part| part.sign).max();
                Domain {
                    total: parts().all(|part| part.total),
                    sign: match (least, most) {
                        (Some(Sign::NotNegative), Some(most)) => most,
                        (Some(least), _) => least,
                        (None, _) => Sign::Unknown,
                    },
                }
            }
            Node::Product(factors) => {
                let parts = || factors.iter().map(|&factor| self.domain(factor));
                Domain {
                    total: parts().all(|part| part.total),
                    sign: (parts().map(|part| part.sign).min()).unwrap_or(Sign::Unknown),
                }
            }
            &Node::Power(base, exponent) => self.domain_of_power(base, exponent),
            &Node::Switch {
                surface,
                above,
                below,
                ..
            } => {
                let parts = [surface, above, below].map(|part| self.domain(part));
                // Where a piece is the surface itself it has the surface's sign there, as in |x| and max(x, 0).
                let sign_above = if above == surface {
                    Sign::NotNegative
                } else {
                    parts[1].sign
                };
                let sign_below = if self.is_negative_of(below, surface) {
                    Sign::NotNegative
                } else {
                    parts[2].sign
                };
                Domain {
                    total: parts.iter().all(|part| part.total),
                    sign: sign_above.min(sign_below),
                }
            }
            &Node::Floor(argument) => Domain {
                total: self.domain(argument).total,
                sign: Sign::Unknown,
            },
            Node::Curve(..) => Domain {
                total: false,
                sign: Sign::Unknown,
            },
            &Node::Call(function, argument) => Domain {
                total: self.domain(argument).total
                    && !matches!(
                        function,
                        Function::Ln | Function::Tan | Function::Asin | Function::Acos
                    ),
                sign: match function {
                    Function::Exp | Function::Cosh => Sign::Positive,
                    Function::Acos => Sign::NotNegative,
                    _ => Sign::Unknown,
                },
            },
        }
    }

    fn domain_of_power(&self, base: Expr, exponent: Expr) -> Domain {
        let (below, above) = (self.domain(base), self.domain(exponent));
        let Some(number) = self.as_number(exponent) else {
            let positive = below.sign == Sign::Positive;
            return Domain {
                total: positive && below.total && above.total,
                sign: if positive {
                    Sign::Positive
                } else {
                    Sign::Unknown
                },
            };
        };
        let asked = self.demands(base, Demands::of(number));
        let even = Number::new(number)
            .as_integer()
            .is_some_and(|integer| integer % 2 == 0);
        let sign = match below.sign {
            Sign::Unknown if even || Demands::of(number).not_negative => Sign::NotNegative,
            sign => sign,
        };
        Domain {
            total: below.total && asked == Demands::default(),
            sign,
        }
    }

    /// Whether one expression is minus one times another, by its form.
    pub(super) fn is_negative_of(&self, a: Expr, b: Expr) -> bool {
        match self.node(a) {
            Node::Product(factors) => {
                factors.len() == 2
                    && factors[1] == b
                    && self.as_number(factors[0]) == Some(DoubleDouble::from(-1.0))
            }
            _ => false,
        }
    }

    /// What is left to ask of a base whose sign is known.
    pub(in crate::expressions) fn demands(&self, base: Expr, asked: Demands) -> Demands {
        let sign = self.domain(base).sign;
        Demands {
            not_zero: asked.not_zero && sign < Sign::Positive,
            not_negative: asked.not_negative && sign < Sign::NotNegative,
        }
    }

    /// What must not be negative for expressions to have a value, as far as their form does not say that it is not: radicands, and bases of powers
    /// whose exponents are no whole numbers.
    pub(crate) fn radicands(&self, of: &[Expr]) -> Vec<Expr> {
        let mut found = Vec::new();
        for part in self.reachable(of) {
            let Node::Power(base, exponent) = *self.node(part) else {
                continue;
            };
            let own = self.as_number(exponent).map_or(
                Demands {
                    not_zero: false,
                    not_negative: true,
                },
                Demands::of,
            );
            if self.demands(base, own).not_negative && !found.contains(&base) {
                found.push(base);
            }
        }
        found
    }

    /// Exponents that add up to `exponent` and together ask of `base` exactly what is asked: one, if it does by itself.
    ///
    /// `None` stands for no factor at all.
    pub(in crate::expressions) fn exponents(
        &self,
        base: Expr,
        exponent: DoubleDouble,
        asked: Demands,
    ) -> [Option<DoubleDouble>; 2] {
        let vanishes = exponent == DoubleDouble::ZERO;
        let mut asked = self.demands(base, asked);
        if self.folding() == Folding::Continued {
            asked = Demands::default();
        } else if vanishes && !self.domain(base).total {
            asked.not_zero = true;
        }
        let own = self.demands(base, Demands::of(exponent));
        if own.and(asked) == own {
            return [(!vanishes).then_some(exponent), None];
        }
        let part = match (asked.not_negative && !own.not_negative, asked.not_zero) {
            (true, false) => 0.5,
            (true, true) => -0.5,
            (false, _) => -1.0,
        };
        let part = DoubleDouble::from(part);
        match folded_sum(exponent, -part) {
            Some(rest) => [Some(rest), Some(part)],
            None => [Some(exponent), None],
        }
    }
}
