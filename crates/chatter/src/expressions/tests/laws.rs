//! Laws of simplification, differentiation, formulas and parsing, on random expressions.

use super::plain::{FUNCTIONS, Plain, plain, point};
use super::{names, read};
use crate::expressions::{Function, Graph, Names, Symbol};
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
        function in proptest::sample::select(FUNCTIONS.to_vec()),
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
