//! Laws of simplification, differentiation, formulas and parsing, on random expressions.

use super::plain::{Plain, plain, point};
use super::{names, read};
use crate::expressions::{Corners, Edge, Function, Graph, Names, Symbol};
use crate::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;

/// Error bounds are of first order; an expression whose bound is above this is too ill-conditioned to test on.
const LARGEST_USEFUL_ERROR: f64 = 1e-20;

/// Simplification takes other roundings than the tree does: so many times the tree's own error bound.
const ROUNDING_RATIO: f64 = 100.0;

/// A formula gives a double by the digits that tell it from other doubles, 16 fewer than a double-double has.
const DIGITS_RATIO: f64 = 1e16;

/// The value of the tree and the error allowed, where it is finite and well-conditioned.
fn reference(tree: &Plain, at: &[Vec<DoubleDouble>; 2]) -> Option<(DoubleDouble, f64)> {
    let bounded = tree.evaluate(at);
    let allowed = ROUNDING_RATIO * bounded.error;
    (bounded.value.is_finite() && allowed < LARGEST_USEFUL_ERROR)
        .then_some((bounded.value, allowed))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn simplification_keeps_the_value(tree in plain(), at in point()) {
        check_value(&tree, &at)?;
    }

    #[test]
    fn rebuilding_a_canonical_expression_changes_nothing(tree in plain()) {
        let mut graph = Graph::default();
        let expr = tree.build(&mut graph);
        let again = graph.substitute(expr, &|_| None);
        prop_assert_eq!(again, expr);
    }

    /// Numbers at both ends of the range, which do not all fit into one.
    #[test]
    fn rebuilding_a_product_of_extreme_numbers_changes_nothing(
        numbers in proptest::collection::vec(extreme(), 1..6),
        divided in proptest::collection::vec(any::<bool>(), 6),
        symbol in any::<bool>(),
        shift in extreme(),
    ) {
        let mut graph = Graph::default();
        let mut expr = if symbol { graph.state(0) } else { graph.number(1.0) };
        for (&number, &divided) in numbers.iter().zip(&divided) {
            let number = graph.number(number);
            expr = if divided { graph.div(expr, number) } else { graph.mul(expr, number) };
        }
        prop_assert_eq!(graph.substitute(expr, &|_| None), expr);
        let shift = graph.number(shift);
        let sum = graph.sub(expr, shift);
        prop_assert_eq!(graph.substitute(sum, &|_| None), sum);
    }

    /// At points where denominators, radicands and arguments of logarithms often vanish.
    #[test]
    fn simplification_keeps_where_there_is_no_value(tree in plain(), at in corners()) {
        let expected = exactly(&tree, &at);
        let mut graph = Graph::default();
        let expr = tree.build(&mut graph);
        let parts = graph.reachable(&[expr]);
        let values = graph.evaluate_all(&parts, &at[0], &at[1]);
        let undefined = values.iter().any(|value| !value.is_finite());
        match expected {
            Exactly::Undefined => prop_assert!(undefined, "{tree:?} at {at:?}"),
            Exactly::Value(value) => {
                prop_assert!(!undefined, "{tree:?} at {at:?}");
                let found = values[values.len() - 1];
                prop_assert!((found - value).abs() <= 1e-12 * (1.0 + value.abs()), "{found} {value}");
            }
            Exactly::Unsure => {}
        }
    }

    #[test]
    fn formulas_are_read_back_as_they_were(tree in plain(), at in point()) {
        if let Some((_, allowed)) = reference(&tree, &at) {
            let mut graph = Graph::default();
            let expr = tree.build(&mut graph);
            let (states, parameters) = names();
            let text = graph.to_text(expr, Names { states: &states, parameters: &parameters });
            let back = read(&mut graph, &text);
            prop_assert!(back.is_ok(), "{text}: {}", back.unwrap_err());
            let expected = graph.evaluate(expr, &at[0], &at[1]);
            let value = graph.evaluate(back.unwrap(), &at[0], &at[1]);
            let error = (value - expected).abs().to_f64();
            prop_assert!(error <= DIGITS_RATIO * allowed, "{text}: {value:.20} is not {expected:.20}");
        }
    }

    #[test]
    fn derivatives_are_the_limit_of_differences(tree in plain(), at in point()) {
        check_derivative(&tree, &at)?;
    }

    /// Random trees seldom hit the narrow domains of the inverse functions: here every function is met inside its own,
    /// with an argument of either sign.
    #[test]
    fn each_function_keeps_its_value_and_slope(
        function in proptest::sample::select(Function::ALL.to_vec()),
        factor in prop_oneof![Just(-0.5), Just(0.25), Just(-1.0), Just(1.0)],
        size in 0.05_f64..0.95,
    ) {
        let positive_only = function == Function::Ln;
        let state = if positive_only { size * f64::signum(factor) } else { size };
        let at = [vec![DoubleDouble::from(state)], vec![]];
        let argument = Plain::Multiply(Box::new(Plain::Number(factor)), Box::new(Plain::State(0)));
        let tree = Plain::Call(function, Box::new(argument));
        prop_assert!(reference(&tree, &at).is_some());
        check_value(&tree, &at)?;
        prop_assert!(check_derivative(&tree, &at)?);
    }

    #[test]
    fn any_text_is_read_or_refused(text in r"[\PC]{0,40}") {
        check_spans(&text)?;
    }

    #[test]
    fn any_jumble_of_tokens_is_read_or_refused(
        tokens in proptest::collection::vec(
            prop_oneof![
                Just("x"), Just("kappa"), Just("nobody"), Just("sin"), Just("pi"), Just("2"), Just("1e3"),
                Just("."), Just("+"), Just("-"), Just("*"), Just("**"), Just("/"), Just("^"), Just("("),
                Just(")"), Just(","), Just(" "), Just("é"), Just("²"), Just("𝛼"),
            ],
            0..30,
        ),
    ) {
        check_spans(&tokens.concat())?;
    }
}

fn check_value(tree: &Plain, at: &[Vec<DoubleDouble>; 2]) -> Result<(), TestCaseError> {
    if let Some((expected, allowed)) = reference(tree, at) {
        let mut graph = Graph::default();
        let expr = tree.build(&mut graph);
        let value = graph.evaluate(expr, &at[0], &at[1]);
        let error = (value - expected).abs().to_f64();
        prop_assert!(
            error <= allowed,
            "{value:.20} is not {expected:.20}: {error:e} > {allowed:e}"
        );
    }
    Ok(())
}

/// Compares the derivative in the first state with differences; says whether they were good enough to compare with.
fn check_derivative(tree: &Plain, at: &[Vec<DoubleDouble>; 2]) -> Result<bool, TestCaseError> {
    let mut graph = Graph::default();
    let expr = tree.build(&mut graph);
    let derivative = graph.derivative(expr, Symbol::State(0));
    let value = graph.evaluate(derivative, &at[0], &at[1]);
    // Fourth order: the error falls sixteenfold from one step to its half.
    let difference = |step: f64| {
        let shifted = |steps: f64| {
            let mut states = at[0].clone();
            states[0] += DoubleDouble::from(steps * step);
            graph.evaluate(expr, &states, &at[1])
        };
        let near = (shifted(1.0) - shifted(-1.0)) * DoubleDouble::from(8.0);
        let far = shifted(2.0) - shifted(-2.0);
        (near - far) / DoubleDouble::from(12.0 * step)
    };
    let (coarse, fine) = (difference(1.0 / 131_072.0), difference(1.0 / 262_144.0));
    let spread = (coarse - fine).abs().to_f64();
    let size = graph.evaluate(expr, &at[0], &at[1]).abs().to_f64() + fine.abs().to_f64() + 1.0;
    let comparable = fine.is_finite() && value.is_finite() && spread < 1e-9 * size;
    if comparable {
        let error = (value - fine).abs().to_f64();
        prop_assert!(
            error <= 2.0 * spread + 1e-20 * size,
            "{value:.20} is not {fine:.20}, spread {spread:e}"
        );
    }
    Ok(comparable)
}

fn check_spans(text: &str) -> Result<(), TestCaseError> {
    if let Err(error) = read(&mut Graph::default(), text) {
        prop_assert!(text.get(error.span.clone()).is_some(), "{:?}", error.span);
        prop_assert!(!error.to_string().is_empty());
    }
    Ok(())
}

/// The first and second number cannot be multiplied, the first and third can.
#[test]
fn rebuilding_numbers_at_the_end_of_the_range_changes_nothing() {
    for text in [
        "5e-324*355e-4*353e2-32",
        "355e-4*5e-324*353e2*x",
        "1e300*1e300*1e-300*x",
        "x/1e-320/1e5",
    ] {
        let mut graph = Graph::default();
        let expr = read(&mut graph, text).unwrap();
        assert_eq!(graph.substitute(expr, &|_| None), expr, "{text}");
    }
}

fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(5e-324),
        Just(2.5e-310),
        Just(f64::MIN_POSITIVE),
        Just(1.7e308),
        Just(355e-4),
        Just(353e2),
        Just(-32.0),
        Just(0.1),
        (-308_i32..308).prop_map(|power| libm::pow(10.0, f64::from(power))),
    ]
}

/// Small numbers whose sums, products and many quotients are exact, zero most often.
fn corners() -> impl Strategy<Value = [Vec<f64>; 2]> {
    let number = || proptest::sample::select(vec![0.0, 0.0, 1.0, -1.0, 2.0, -2.0, 0.5, 4.0]);
    let three = || proptest::collection::vec(number(), 3);
    (three(), three()).prop_map(|(states, parameters)| [states, parameters])
}

/// What is known of a tree's value without any rounding.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Exactly {
    Value(f64),
    /// Some part of it has none.
    Undefined,
    /// It has been rounded: whether it vanishes cannot be said.
    Unsure,
}

fn exactly(tree: &Plain, at: &[Vec<f64>; 2]) -> Exactly {
    use Exactly::{Undefined, Unsure, Value};
    /// Beyond, sums may be rounded.
    const LARGEST: f64 = 1e6;
    let of = |tree: &Plain| exactly(tree, at);
    let value = match tree {
        Plain::Number(value) => Value(*value),
        Plain::Decimal(text) => match text.parse::<f64>() {
            Ok(value) if value != 0.1 => Value(value),
            _ => Unsure,
        },
        Plain::Pi => Unsure,
        Plain::State(index) => Value(at[0][*index]),
        Plain::Parameter(index) => Value(at[1][*index]),
        Plain::Negate(a) => match of(a) {
            Value(a) => Value(-a),
            other => other,
        },
        Plain::Root(a) => exact_power(of(a), Value(0.5)),
        Plain::Power(a, b) => exact_power(of(a), of(b)),
        Plain::Call(function, a) => match of(a) {
            Value(a) => {
                let value = function.of(a);
                let outside = *function == Function::Ln && a <= 0.0;
                if outside || value.is_nan() {
                    Undefined
                } else if value == libm::rint(value) && (a == 0.0 || a == 1.0) {
                    Value(value)
                } else {
                    Unsure
                }
            }
            other => other,
        },
        Plain::Add(a, b) | Plain::Subtract(a, b) | Plain::Multiply(a, b) | Plain::Divide(a, b) => {
            match (of(a), of(b)) {
                (Undefined, _) | (_, Undefined) => Undefined,
                (Value(a), Value(b)) => match tree {
                    Plain::Add(..) => Value(a + b),
                    Plain::Subtract(..) => Value(a - b),
                    Plain::Multiply(..) => Value(a * b),
                    _ if b == 0.0 => Undefined,
                    _ if (a / b).mul_add(b, -a) == 0.0 => Value(a / b),
                    _ => Unsure,
                },
                (_, Value(0.0)) if matches!(tree, Plain::Divide(..)) => Undefined,
                _ => Unsure,
            }
        }
    };
    match value {
        Value(value) if value.abs() > LARGEST || (value != 0.0 && value.abs() < 1.0 / LARGEST) => {
            Unsure
        }
        value => value,
    }
}

fn exact_power(base: Exactly, exponent: Exactly) -> Exactly {
    use Exactly::{Undefined, Unsure, Value};
    match (base, exponent) {
        (Undefined, _) | (_, Undefined) => Undefined,
        (Value(base), Value(exponent)) => {
            let whole = exponent == libm::rint(exponent);
            let value = libm::pow(base, exponent);
            if (base == 0.0 && exponent < 0.0) || (base < 0.0 && !whole) {
                Undefined
            } else if whole && exponent >= 0.0 || value == libm::rint(value) {
                Value(value)
            } else {
                Unsure
            }
        }
        _ => Unsure,
    }
}

/// Limits of a command, and what else is chosen by them, are two surfaces: whatever their signs, and the order of their terms.
#[test]
fn surfaces_are_one_whatever_their_sign_and_order() {
    let mut graph = Graph::default();
    let (x, v, u) = (graph.state(0), graph.state(1), graph.parameter(0));
    let minus_u = graph.neg(u);
    let command = graph.add(x, v);
    let limited = graph.clamp(command, minus_u, u);
    let below = graph.sub(minus_u, command);
    let windup = graph.switch(below, x, v, Edge::Below);
    let backwards = graph.sum(&[v, minus_u, x]);
    let above = graph.step(backwards);
    let corners = Corners::of(&graph, &[limited, windup, above], 1);
    let surfaces: Vec<_> = corners.surfaces.iter().map(|&s| graph.node(s)).collect();
    assert_eq!(surfaces.len(), 2, "{surfaces:?}");
    for at in [-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0] {
        for (low, high) in [(-1.0, 1.0), (1.0, -1.0), (0.5, 0.5)] {
            let [x, low_, high_] = [0, 1, 2].map(|place| graph.state(place));
            let clamped = graph.clamp(x, low_, high_);
            let value = graph.evaluate(clamped, &[at, low, high], &[]);
            assert_eq!(
                value,
                f64::min(f64::max(at, low), high),
                "{at} {low} {high}"
            );
        }
    }
}
