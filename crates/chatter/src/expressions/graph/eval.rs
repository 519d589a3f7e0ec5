//! Plain evaluation of an expression at a point.

use super::piecewise::floor;
use crate::expressions::{Expr, Function, Graph, Node, Symbol};
use crate::numerics::{DoubleDouble, Real};

/// Largest integer exponent taken by repeated multiplication; past it the logarithm is more accurate.
pub(in crate::expressions) const LARGEST_MULTIPLIED_EXPONENT: i32 = 1024;

impl Graph {
    /// The value of `expr`, each shared subexpression computed once. NaN outside the domain; a symbol past the end of
    /// `states` or `parameters` is NaN.
    pub fn evaluate<R: Real>(&self, expr: Expr, states: &[R], parameters: &[R]) -> R {
        self.evaluate_all(&[expr], states, parameters)[0]
    }

    /// The values of several expressions, what they share computed once.
    pub fn evaluate_all<R: Real>(&self, exprs: &[Expr], states: &[R], parameters: &[R]) -> Vec<R> {
        self.evaluate_parts(&self.reachable(exprs), exprs, (states, parameters))
    }

    /// As [`evaluate_all`](Self::evaluate_all), given all that the expressions are made of.
    pub(crate) fn evaluate_parts<R: Real>(
        &self,
        parts: &[Expr],
        exprs: &[Expr],
        (states, parameters): (&[R], &[R]),
    ) -> Vec<R> {
        let missing = R::splat(f64::NAN);
        let size = exprs.iter().map(|expr| expr.index() + 1).max();
        let mut known = vec![missing; size.unwrap_or(0)];
        for part in parts {
            let value = |operand: &Expr| known[operand.index()];
            known[part.index()] = match self.node(*part) {
                Node::Number(number) => R::from_double_double(number.value()),
                Node::Pi => R::from_double_double(DoubleDouble::PI),
                Node::Symbol(Symbol::State(index)) => {
                    states.get(*index).copied().unwrap_or(missing)
                }
                Node::Symbol(Symbol::Parameter(index)) => {
                    parameters.get(*index).copied().unwrap_or(missing)
                }
                Node::Sum(terms) => terms[1..]
                    .iter()
                    .fold(value(&terms[0]), |sum, term| sum + value(term)),
                Node::Product(factors) => factors[1..]
                    .iter()
                    .fold(value(&factors[0]), |product, factor| {
                        product * value(factor)
                    }),
                Node::Power(base, exponent) => power(value(base), value(exponent)),
                Node::Call(function, argument) => function.of(value(argument)),
                Node::Switch {
                    surface,
                    above,
                    below,
                    edge,
                } => edge.choose(value(surface), value(above), value(below)),
                Node::Floor(argument) => floor(value(argument)),
                Node::Curve(id, argument, derivative) => {
                    self.curve(*id).value(value(argument), *derivative)
                }
            };
        }
        exprs.iter().map(|expr| known[expr.index()]).collect()
    }
}

impl Function {
    /// The value of the function at `argument`; NaN outside its domain.
    pub fn of<R: Real>(self, argument: R) -> R {
        match self {
            Self::Exp => argument.exp(),
            Self::Ln => argument.ln(),
            Self::Sin => argument.sin_cos().0,
            Self::Cos => argument.sin_cos().1,
            Self::Tan => argument.tan(),
            Self::Asin => argument.asin(),
            Self::Acos => argument.acos(),
            Self::Atan => argument.atan(),
            Self::Sinh => argument.sinh(),
            Self::Cosh => argument.cosh(),
            Self::Tanh => argument.tanh(),
        }
    }
}

/// `base ^ exponent`: any base for an integer exponent, NaN for a negative base otherwise; `0^0` is 1.
pub fn power<R: Real>(base: R, exponent: R) -> R {
    let wide = exponent.to_double_double();
    let whole = wide.low() == 0.0 && libm::rint(wide.high()) == wide.high();
    if whole && wide.high().abs() <= f64::from(LARGEST_MULTIPLIED_EXPONENT) {
        return integer_power(base, wide.high() as i32);
    }
    if wide.high().abs() == 0.5 && wide.low() == 0.0 {
        let root = base.sqrt();
        return if wide.high() > 0.0 {
            root
        } else {
            R::ONE / root
        };
    }
    if base < R::ZERO {
        if !whole {
            return R::splat(f64::NAN);
        }
        let size = base.abs().powf(exponent);
        return if libm::fmod(wide.high(), 2.0) == 0.0 {
            size
        } else {
            -size
        };
    }
    base.powf(exponent)
}

pub(in crate::expressions) fn integer_power<R: Real>(base: R, exponent: i32) -> R {
    let mut result = R::ONE;
    let mut square = base;
    let mut left = exponent.unsigned_abs();
    while left > 0 {
        if left & 1 == 1 {
            result *= square;
        }
        left >>= 1;
        if left > 0 {
            square *= square;
        }
    }
    if !result.is_finite() {
        // A double-double past the range is NaN, where a double knows infinity and its reciprocal.
        return R::splat(libm::pow(base.to_f64(), f64::from(exponent)));
    }
    if exponent < 0 {
        R::ONE / result
    } else {
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_take_the_bases_they_can() {
        let check = |base: f64, exponent: f64, expected: f64| {
            let value = power(base, exponent);
            assert!(
                value == expected || (value.is_nan() && expected.is_nan()),
                "{base}^{exponent} = {value}, not {expected}"
            );
            let wide = power(DoubleDouble::from(base), DoubleDouble::from(exponent)).to_f64();
            assert!(
                (wide - expected).abs() <= 1e-15 * expected.abs()
                    || wide == expected
                    || (wide.is_nan() && expected.is_nan()),
                "{base}^{exponent} = {wide}, not {expected}"
            );
        };
        check(-2.0, 3.0, -8.0);
        check(-2.0, -2.0, 0.25);
        check(-1.0, 1025.0, -1.0);
        check(-1.0, 1e9, 1.0);
        check(-4.0, 0.5, f64::NAN);
        check(-4.0, 1.5, f64::NAN);
        check(4.0, -0.5, 0.5);
        check(0.0, 1.5, 0.0);
        check(0.0, -1.5, f64::INFINITY);
        check(0.0, 0.0, 1.0);
        check(12.5, -1000.0, 0.0);
        check(-12.5, 1001.0, f64::NEG_INFINITY);
        check(f64::NAN, 3.0, f64::NAN);
        check(f64::NAN, 1.5, f64::NAN);
        check(2.0, f64::NAN, f64::NAN);
    }
}
