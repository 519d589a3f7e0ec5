//! Simplification, derivatives and formulas, as text.

use super::{names, read};
use crate::expressions::{Folding, Graph, Symbol};

fn check(text: &str, expected: &str) {
    let mut graph = Graph::default();
    let expr = read(&mut graph, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let (states, parameters) = names();
    let names = crate::expressions::Names {
        states: &states,
        parameters: &parameters,
    };
    assert_eq!(graph.to_text(expr, names), expected, "{text}");
}

#[test]
fn sums_are_flattened_and_like_terms_merged_where_the_first_stood() {
    check("2*x + 3*x", "5*x");
    check("x + (y + z)", "x + y + z");
    check("x + y + x", "2*x + y");
    check("x - x", "0");
    check("x + y - x", "y");
    check("1 + x + 2", "3 + x");
    check("0 + x + 0", "x");
    check("y - x + 1", "y - x + 1");
    check("x*y + y*x", "2*x*y");
    check("x/2 + x/2", "x");
    check("x/3 + x/3", "2*x/3");
    check("x + y - (x + y)", "0");
    check("x - (x + y)", "-y");
    check("x - (y + z)", "x - (y + z)");
    check("x - (y - z)", "x - y + z");
    check("3*(x + y) - 2*(x + y)", "x + y");
    check("2*(x + y) - 2*x", "2*y");
    check("2*(x + y) + x", "2*(x + y) + x");
    check("1 - (1 - x)", "x");
    check("0.73*0.3*x - 0.219*x", "0");
    check("x + 0.1 + 0.2 - 0.3", "x");
    check("(x + 1)*1e300*1e300", "1e300*1e300*(x + 1)");
}

#[test]
fn products_are_flattened_and_equal_bases_merged() {
    check("x*x^2", "x^3");
    check("x*y*x", "x^2*y");
    check("x*1", "x");
    check("x*0", "0");
    check("0/x", "0/x");
    check("y*x*q*2", "2*q*x*y");
    check("x/x", "x/x");
    check("x^2/x^3", "1/x");
    check("sqrt(x)*sqrt(x)", "sqrt(x)*sqrt(x)");
    check("sqrt(x)^2", "sqrt(x)*sqrt(x)");
    check("(x^2)^3", "x^6");
    check("abs(x)^2", "x^2");
    check("abs(x)*abs(x)*abs(x)", "if(x >= 0, x, -x)^3");
    check("(x^kappa)^2", "(x^kappa)^2");
    check("x^kappa*x^beta", "x^kappa*x^beta");
    check("(2*x)^3", "8*x^3");
    check("x/(2*x)", "0.5*x/x");
    check("x/(x*y)", "x/(x*y)");
    check("x*y/(x*y)^2", "1/(x*y)");
    check("6*x/3", "2*x");
    check("x/3*6", "2*x");
    check("1/3", "1/3");
    check("3*(1/3)", "1");
    check("-(x - y)", "-x + y");
    check("-(x + y)", "-(x + y)");
    check("--(x + y)", "x + y");
    check("2*(x + 1)", "2*(x + 1)");
    check("-x*-y", "x*y");
    check("(x + y)*(y + z)/(x + y)", "(x + y)*(y + z)/(x + y)");
}

/// What has no value at some point keeps having none there.
#[test]
fn folding_leaves_where_an_expression_is_undefined() {
    check("0/0", "0/0");
    check("(1/0)*0", "0/0");
    check("1/0 - 1/0", "0/0");
    check("log(0)*0", "0*log(0)");
    check("log(x) - log(x)", "0*log(x)");
    check("0*tan(x)", "0*tan(x)");
    check("x^2/x", "x^2/x");
    check("(1/x)^-1", "x^2/x");
    check("(1/x)^0", "1 + 0/x");
    check("1^(1/x)", "1 + 0/x");
    check("sqrt(x)*x", "x^1.5");
    check("sqrt(x)^2/x", "sqrt(x)/sqrt(x)");
    check("x^-2*x^-1", "1/x^3");
    check("x^2/x^5", "1/x^3");
}

/// Where it has values everywhere, nothing is left of it.
#[test]
fn what_has_values_everywhere_is_folded() {
    check("0*x", "0");
    check("0*sin(x)*exp(y)", "0");
    check("exp(x)/exp(x)", "1");
    check("sqrt(1 + x^2)^2", "1 + x^2");
    check("(2 + x^2)/(2 + x^2)", "1");
    check("sqrt(x^2)*sqrt(x^2)", "x^2");
    check("0*sqrt(1 + x^4)", "0");
    check("0*log(2)", "0*log(2)");
    check("2^x - 2^x", "0");
    check("pi/pi", "1");
}

#[test]
fn what_follows_from_equations_is_folded_where_values_agree() {
    let mut graph = Graph::default();
    graph.set_folding(Folding::Continued);
    let one = graph.number(1.0);
    for text in [
        "x/x",
        "(1/kappa)/(1/kappa)",
        "x^2/x - x + 1",
        "0*log(x) + 1",
        "sqrt(x)^2/x",
    ] {
        let expr = read(&mut graph, text).unwrap();
        assert_eq!(expr, one, "{text}");
    }
}

#[test]
fn powers_and_functions_are_folded_only_where_exact() {
    check("x^0", "1");
    check("x^1", "x");
    check("1^x", "1");
    check("2^10", "1024");
    check("10^-3", "0.001");
    check("0^2", "0");
    check("0^-1", "1/0");
    check("4^0.5", "2");
    check("4^-1.5", "0.125");
    check("sqrt(2)", "sqrt(2)");
    check("sqrt(2)*sqrt(2)", "2");
    check("sqrt(-4)", "sqrt(-4)");
    check("(-2)^3", "-8");
    check("(-8)^(1/3)", "(-8)^(1/3)");
    check("10^400", "10^400");
    check("sin(0) + cos(0) + exp(0) + log(1)", "2");
    check("sin(pi) + cos(pi)", "-1");
    check("acos(1) + atan(0) + cosh(0) + tanh(0)", "1");
    check("sin(1)", "sin(1)");
    check("exp(log(x))", "exp(log(x))");
    check("log(exp(x))", "log(exp(x))");
    check("sin(-x)", "-sin(x)");
    check("cos(-2*x)", "cos(2*x)");
    check("tanh(-2)", "-tanh(2)");
    check("exp(-x)", "exp(-x)");
}

#[test]
fn formulas_have_the_parentheses_they_need() {
    for text in [
        "x",
        "-x",
        "x - y",
        "-x^2",
        "(-x)^0.3",
        "(x + y)^2",
        "(x^y)^z",
        "x^(y^z)",
        "x^(-y)",
        "2^x",
        "x^(1/3)",
        "1/x^(1/3)",
        "x^1.5",
        "x/y",
        "x/(y*z)",
        "x/(y + z)",
        "x/(y^2*z)",
        "q*x/y^2",
        "1/x",
        "-1/x",
        "1/sqrt(x)",
        "1/(x + y)",
        "(x + y)/z",
        "-(x + y)/z",
        "x - y/z",
        "x - 2*(y + z)",
        "sin(x + y)^2",
        "2*pi*x",
        "pi/beta",
        "0.1*x",
        "1e-7*x",
        "x/3",
        "2/3 + x",
        "x - 1/3",
        "-kappa*y - x - q + z",
        "beta*(q - x*sqrt(z))",
        "(1/x)^y",
        "(2*x)^y",
        "(x*y)^2",
        "x^(2*y)",
        "(2/3)^x",
        "sqrt(x)^y",
        "exp(-x^2/2)",
    ] {
        let expected = match text {
            "exp(-x^2/2)" => "exp(-0.5*x^2)",
            text => text,
        };
        check(text, expected);
    }
}

#[test]
fn tex_is_as_in_print() {
    let check = |text: &str, expected: &str| {
        let mut graph = Graph::default();
        let expr = read(&mut graph, text).unwrap();
        let (states, parameters) = names();
        let names = crate::expressions::Names {
            states: &states,
            parameters: &parameters,
        };
        assert_eq!(graph.to_tex(expr, names), expected, "{text}");
    };
    check(
        "-kappa*x/(y + 1)^2",
        r"-\frac{\kappa \, x}{\left(y + 1\right)^{2}}",
    );
    check("sqrt(x)*exp(-x)", r"\sqrt{x} \, \exp\left(-x\right)");
    check("x^(y + 1) + 1e-7", r"x^{y + 1} + 1 \cdot 10^{-7}");
    check("x^(1/3)/3", r"\frac{x^{1/3}}{3}");
    check("2*pi*beta", r"2 \, \pi \, \beta");
}

#[test]
fn derivatives_come_out_simplified() {
    let check = |text: &str, expected: &str| {
        let mut graph = Graph::default();
        let expr = read(&mut graph, text).unwrap();
        let derivative = graph.derivative(expr, Symbol::State(0));
        let (states, parameters) = names();
        let names = crate::expressions::Names {
            states: &states,
            parameters: &parameters,
        };
        assert_eq!(graph.to_text(derivative, names), expected, "{text}");
    };
    check("kappa*x^2 + 3*x + q", "2*kappa*x + 3");
    check("x*y*z", "y*z");
    check("sqrt(x)", "0.5/sqrt(x)");
    check("1/x", "-1/x^2");
    check("sin(2*x)", "2*cos(2*x)");
    check("cos(x)", "-sin(x)");
    check("exp(-x^2)", "-2*x*exp(-x^2)");
    check("log(x)", "1/x");
    check("tan(x)", "1 + tan(x)^2");
    check("tanh(x)", "1 - tanh(x)^2");
    check("atan(x)", "1/(1 + x^2)");
    check("y^x", "y^x*log(y)");
    check("x^y", "y*x^(y - 1)");
    check("asin(x)", "1/sqrt((1 - x)*(1 + x))");
    check("acos(x)", "-1/sqrt((1 - x)*(1 + x))");
    check("(x + y)/(x + y)", "0/(x + y)");
}

#[test]
fn a_formula_nobody_could_read_is_cut() {
    let mut graph = Graph::default();
    let mut expr = graph.state(0);
    for _ in 0..100 {
        let sine = graph.call(crate::expressions::Function::Sin, expr);
        let one = graph.number(1.0);
        let more = graph.add(expr, one);
        expr = graph.mul(sine, more);
    }
    let (states, parameters) = names();
    let names = crate::expressions::Names {
        states: &states,
        parameters: &parameters,
    };
    let text = graph.to_text(expr, names);
    assert!(text.len() < 70_000 && text.contains('…'));
    for _ in 0..100_000 {
        expr = graph.call(crate::expressions::Function::Exp, expr);
    }
    assert!(graph.to_text(expr, names).contains('…'));
}

#[test]
fn roots_of_squares_are_sizes() {
    for (text, size) in [
        ("sqrt(x^2)", "abs(x)"),
        ("1 - sqrt((x - y)^2)", "1 - abs(x - y)"),
        ("sqrt(4*x^2)", "2*abs(x)"),
        ("hypot(x, 0)*y", "abs(x)*y"),
        ("(x^2)^1.5", "x^2*abs(x)"),
        ("sqrt(x^4)", "x^2"),
        ("y/sqrt(x^2)", "y/abs(x)"),
        ("3*y*x/sqrt(x^2)", "3*y*sign(x)"),
        ("x^3/sqrt(x^2)", "x^2*sign(x)"),
        ("sqrt(sqrt(x^4))", "abs(x)"),
        ("sqrt(x^3)", "sqrt(x^3)"),
        ("sqrt(-x^2)", "sqrt(-x^2)"),
        ("sqrt(1 + x^2)", "sqrt(1 + x^2)"),
        ("(x^2)^0.75", "abs(x)^1.5"),
        ("sqrt(abs(4*x*y))", "2*sqrt(abs(x))*sqrt(abs(y))"),
        ("abs(x^2*y)^1.5", "x^2*abs(x)*abs(y)^1.5"),
        ("abs(kappa*x*y)^beta", "abs(kappa*x)^beta*abs(y)^beta"),
        ("sqrt(abs(kappa*x))", "sqrt(abs(kappa*x))"),
        (
            "max(x*y, 0)^1.5",
            "if(y >= 0, if(x >= 0, abs(x)^1.5*abs(y)^1.5, 0), if(x >= 0, 0, abs(x)^1.5*abs(y)^1.5))",
        ),
    ] {
        let mut graph = Graph::default();
        let [found, expected] = [text, size].map(|text| read(&mut graph, text).unwrap());
        assert_eq!(graph.with_sizes(&[found]), [expected], "{text}");
    }
}
