//! Expressions as plain trees: random ones, built into a graph, and evaluated without any simplification.

use crate::expressions::{Expr, Function, Graph};
use crate::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;

#[derive(Clone, Debug)]
pub(super) enum Plain {
    Number(f64),
    Decimal(&'static str),
    Pi,
    State(usize),
    Parameter(usize),
    Add(Box<Plain>, Box<Plain>),
    Subtract(Box<Plain>, Box<Plain>),
    Multiply(Box<Plain>, Box<Plain>),
    Divide(Box<Plain>, Box<Plain>),
    Negate(Box<Plain>),
    Power(Box<Plain>, Box<Plain>),
    Root(Box<Plain>),
    Call(Function, Box<Plain>),
}

/// Random expressions with few names, so that terms and bases often meet their like.
pub(super) fn plain() -> impl Strategy<Value = Plain> {
    let leaf = prop_oneof![
        (-3_i32..=3).prop_map(|number| Plain::Number(f64::from(number))),
        prop_oneof![Just("0.5"), Just("0.1"), Just("1.5"), Just("4")].prop_map(Plain::Decimal),
        Just(Plain::Pi),
        (0_usize..3).prop_map(Plain::State),
        (0_usize..3).prop_map(Plain::State),
        (0_usize..3).prop_map(Plain::Parameter),
    ];
    leaf.prop_recursive(6, 40, 2, |inner| {
        let pair = || {
            (
                inner.clone().prop_map(Box::new),
                inner.clone().prop_map(Box::new),
            )
        };
        let exponent = prop_oneof![
            (-3_i32..=3).prop_map(|number| Plain::Number(f64::from(number))),
            prop_oneof![Just("0.5"), Just("-0.5"), Just("1.5")].prop_map(Plain::Decimal),
            inner.clone(),
        ];
        prop_oneof![
            pair().prop_map(|(a, b)| Plain::Add(a, b)),
            pair().prop_map(|(a, b)| Plain::Subtract(a, b)),
            pair().prop_map(|(a, b)| Plain::Multiply(a, b)),
            pair().prop_map(|(a, b)| Plain::Multiply(a, b)),
            pair().prop_map(|(a, b)| Plain::Divide(a, b)),
            inner.clone().prop_map(|a| Plain::Negate(Box::new(a))),
            (inner.clone(), exponent).prop_map(|(a, b)| Plain::Power(Box::new(a), Box::new(b))),
            inner.clone().prop_map(|a| Plain::Root(Box::new(a))),
            (0_usize..Function::ALL.len(), inner.clone())
                .prop_map(|(function, a)| Plain::Call(Function::ALL[function], Box::new(a))),
        ]
    })
}

/// A point to evaluate at: three states and three parameters.
pub(super) fn point() -> impl Strategy<Value = [Vec<DoubleDouble>; 2]> {
    let three = || proptest::collection::vec(-3.0_f64..3.0, 3);
    (three(), three()).prop_map(|(states, parameters)| {
        [states, parameters].map(|values| values.into_iter().map(DoubleDouble::from).collect())
    })
}

/// A value with a bound on how far rounding can have moved it, to first order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded {
    pub value: DoubleDouble,
    pub error: f64,
}

/// Rounding error of one operation, with room for what the elementary functions lose.
const ROUNDING: f64 = 1e-30;

/// Errors above this are not small: first order says nothing of them.
const LARGEST_LINEAR_ERROR: f64 = 1e-10;

impl Bounded {
    fn rounded(value: DoubleDouble, error: f64) -> Self {
        // Constants that were folded away leave errors of their own size: hence the 1.
        let error = error + ROUNDING * (1.0 + value.to_f64().abs());
        Self { value, error }
    }

    /// A function of one argument, its slope from a difference of the argument's error.
    fn through(self, function: impl Fn(DoubleDouble) -> DoubleDouble) -> Self {
        if self.error > LARGEST_LINEAR_ERROR {
            return Self {
                value: function(self.value),
                error: f64::INFINITY,
            };
        }
        let step = DoubleDouble::from(self.error.max(1e-20));
        let value = function(self.value);
        let change = [self.value - step, self.value + step]
            .map(|moved| (function(moved) - value).abs().to_f64())
            .into_iter()
            // Not `max`, which would lose the NaN of an argument that rounding can push out of the domain.
            .reduce(|a, b| if a > b || a.is_nan() { a } else { b })
            .unwrap_or(f64::NAN);
        Self::rounded(value, change / step.to_f64() * self.error)
    }
}

impl Plain {
    pub(super) fn build(&self, graph: &mut Graph) -> Expr {
        match self {
            Self::Number(value) => graph.number(*value),
            Self::Decimal(text) => graph.number_exact(text.parse().unwrap()),
            Self::Pi => graph.pi(),
            Self::State(index) => graph.state(*index),
            Self::Parameter(index) => graph.parameter(*index),
            Self::Add(a, b) => {
                let (a, b) = (a.build(graph), b.build(graph));
                graph.add(a, b)
            }
            Self::Subtract(a, b) => {
                let (a, b) = (a.build(graph), b.build(graph));
                graph.sub(a, b)
            }
            Self::Multiply(a, b) => {
                let (a, b) = (a.build(graph), b.build(graph));
                graph.mul(a, b)
            }
            Self::Divide(a, b) => {
                let (a, b) = (a.build(graph), b.build(graph));
                graph.div(a, b)
            }
            Self::Negate(a) => {
                let a = a.build(graph);
                graph.neg(a)
            }
            Self::Power(a, b) => {
                let (a, b) = (a.build(graph), b.build(graph));
                graph.power(a, b)
            }
            Self::Root(a) => {
                let a = a.build(graph);
                graph.sqrt(a)
            }
            Self::Call(function, a) => {
                let a = a.build(graph);
                graph.call(*function, a)
            }
        }
    }

    pub(super) fn evaluate(&self, point: &[Vec<DoubleDouble>; 2]) -> Bounded {
        let exact = |value| Bounded { value, error: 0.0 };
        match self {
            Self::Number(value) => exact(DoubleDouble::from(*value)),
            Self::Decimal(text) => exact(text.parse().unwrap()),
            Self::Pi => exact(DoubleDouble::PI),
            Self::State(index) => exact(point[0][*index]),
            Self::Parameter(index) => exact(point[1][*index]),
            Self::Add(a, b) => {
                let (a, b) = (a.evaluate(point), b.evaluate(point));
                Bounded::rounded(a.value + b.value, a.error + b.error)
            }
            Self::Subtract(a, b) => {
                let (a, b) = (a.evaluate(point), b.evaluate(point));
                Bounded::rounded(a.value - b.value, a.error + b.error)
            }
            Self::Multiply(a, b) => {
                let (a, b) = (a.evaluate(point), b.evaluate(point));
                let error = a.value.to_f64().abs() * b.error + b.value.to_f64().abs() * a.error;
                Bounded::rounded(a.value * b.value, error)
            }
            Self::Divide(a, b) => {
                let (a, b) = (a.evaluate(point), b.evaluate(point));
                let value = a.value / b.value;
                let below = b.value.to_f64().abs();
                if b.error > LARGEST_LINEAR_ERROR * below {
                    return Bounded {
                        value,
                        error: f64::INFINITY,
                    };
                }
                let error = (a.error + value.to_f64().abs() * b.error) / below;
                Bounded::rounded(value, error)
            }
            Self::Negate(a) => {
                let a = a.evaluate(point);
                Bounded {
                    value: -a.value,
                    ..a
                }
            }
            Self::Power(a, b) => {
                let (a, b) = (a.evaluate(point), b.evaluate(point));
                let of_base = a.through(|base| naive_power(base, b.value));
                if b.error == 0.0 {
                    return of_base;
                }
                let of_exponent = b.through(|exponent| naive_power(a.value, exponent));
                Bounded::rounded(of_base.value, of_base.error + of_exponent.error)
            }
            Self::Root(a) => a.evaluate(point).through(Scalar::sqrt),
            Self::Call(function, a) => a.evaluate(point).through(|argument| function.of(argument)),
        }
    }
}

fn naive_power(base: DoubleDouble, exponent: DoubleDouble) -> DoubleDouble {
    let whole = exponent.low() == 0.0 && exponent.high() == libm::rint(exponent.high());
    if whole && exponent.high().abs() < 100.0 {
        let count = exponent.high().abs() as usize;
        let product = (0..count).fold(DoubleDouble::ONE, |product, _| product * base);
        return if exponent.high() < 0.0 {
            DoubleDouble::ONE / product
        } else {
            product
        };
    }
    base.powf(exponent)
}
