//! What texts mean, as numbers.

use super::read;
use crate::expressions::{Graph, is_name, is_reserved, names};
use crate::numerics::DoubleDouble;

/// x = 2, y = 3, z = 5; kappa = 0.5, beta = 20, q = 7.
fn check(text: &str, expected: f64) {
    let mut graph = Graph::default();
    let expr = read(&mut graph, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let value: f64 = graph.evaluate(expr, &[2.0, 3.0, 5.0], &[0.5, 20.0, 7.0]);
    let same = value == expected || (value.is_nan() && expected.is_nan());
    let near = (value - expected).abs() <= 4.0 * f64::EPSILON * expected.abs();
    assert!(same || near, "{text} is {value}, not {expected}");
}

#[test]
fn operators_group_as_in_mathematics() {
    check("1 + 2*3", 7.0);
    check("(1 + 2)*3", 9.0);
    check("10 - 3 - 2", 5.0);
    check("10 - (3 - 2)", 9.0);
    check("24/4/3", 2.0);
    check("24/(4/3)", 18.0);
    check("24/4*3", 18.0);
    check("-x^2", -4.0);
    check("(-x)^2", 4.0);
    check("2^-3", 0.125);
    check("2^3^2", 512.0);
    check("(2^3)^2", 64.0);
    check("2^-3^2", 1.0 / 512.0);
    check("x**y", 8.0);
    check("-x**y", -8.0);
    check("--x", 2.0);
    check("- - -x", -2.0);
    check("+x", 2.0);
    check("x - -y", 5.0);
    check("x*-y", -6.0);
    check("x/-y*z", -10.0 / 3.0);
    check("-x*y", -6.0);
    check("-x/y", -2.0 / 3.0);
    check("x-y-z", -6.0);
    check("x^y^-1", libm::pow(2.0, 1.0 / 3.0));
    check("2*x^2*y", 24.0);
    check("((((x))))", 2.0);
    check("x\n  + y\t- z", 0.0);
}

#[test]
fn numbers_are_read_as_written() {
    check("1e-3", 0.001);
    check("1E+3", 1000.0);
    check(".5", 0.5);
    check("2.", 2.0);
    check("2.e1", 20.0);
    check("1e3*x", 2000.0);
    check("0.0", 0.0);
    check("0e400", 0.0);
    check("5e-324", 5e-324);
    check("pi", core::f64::consts::PI);
    check("2*pi*x", 4.0 * core::f64::consts::PI);
    let mut graph = Graph::default();
    let third = read(&mut graph, "0.1/0.3").unwrap();
    let third = graph.as_number(third).unwrap() * DoubleDouble::from(3.0);
    assert!((third - DoubleDouble::from(1.0)).high().abs() < 1e-31);
}

#[test]
fn functions_take_one_argument() {
    check("sqrt(x^2 + z)", 3.0);
    check("exp(0)", 1.0);
    check("exp(x)", libm::exp(2.0));
    check("log(exp(x))", 2.0);
    check("ln(x)", libm::log(2.0));
    check("sin(x)", libm::sin(2.0));
    check("cos(x)", libm::cos(2.0));
    check("tan(x)", libm::tan(2.0));
    check("asin(kappa)", libm::asin(0.5));
    check("acos(kappa)", libm::acos(0.5));
    check("atan(kappa)", libm::atan(0.5));
    check("sinh(x)", libm::sinh(2.0));
    check("cosh(x)", libm::cosh(2.0));
    check("tanh(x)", libm::tanh(2.0));
    check("sin (x)^2 + cos(x)^2", 1.0);
    check("-sqrt(4)^2", -4.0);
    check("beta*(q - x*sqrt(y))", 20.0 * (7.0 - 2.0 * 3.0_f64.sqrt()));
    check("(-x)^y", -8.0);
    check("(-x)^0.5", f64::NAN);
    check("sqrt(-x)", f64::NAN);
    check("x^kappa", 2.0_f64.sqrt());
}

#[test]
fn names_are_found_without_reading_the_grammar() {
    let text = "kappa*sin(Ω_1) + (pi - x2";
    let found: Vec<&str> = names(text).unwrap().into_iter().map(|s| &text[s]).collect();
    assert_eq!(found, ["kappa", "Ω_1", "x2"]);
    for name in ["x", "y1", "κ", "_a", "drag_coefficient", "Öffnung"] {
        assert!(is_name(name) && !is_reserved(name), "{name}");
    }
    for name in ["", "1x", "a-b", "x²", "a b", "y'"] {
        assert!(!is_name(name), "{name}");
    }
    assert!(is_reserved("pi") && is_reserved("sqrt") && is_reserved("ln"));
}
