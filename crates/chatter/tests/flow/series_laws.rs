//! Series against closed form: the expansion of a function along a flow is the function of the expanded flow.

use chatter::expressions::{Expansion, Expr, Function, Graph, Tape};
use chatter::numerics::polynomial::horner;
use chatter::numerics::{DoubleDouble, Lanes, Real, Scalar};
use proptest::prelude::*;

/// Flow of x' = y, y' = -x/2 - y/5 + 1/10: smooth, neither a polynomial nor symmetric in time.
fn oscillator(graph: &mut Graph) -> Vec<Expr> {
    let (x, y) = (graph.state(0), graph.state(1));
    let half = graph.number(-0.5);
    let fifth = graph.number(-0.2);
    let tenth = graph.number(0.1);
    let terms = [graph.mul(half, x), graph.mul(fifth, y), tenth];
    vec![y, graph.sum(&terms)]
}

/// Every function of the language and every operation of the tape, of arguments inside their domains near the start.
fn outputs(graph: &mut Graph) -> Vec<(String, Expr)> {
    let (x, y) = (graph.state(0), graph.state(1));
    let one = graph.number(1.0);
    let two = graph.number(2.0);
    let quarter = graph.number(0.25);
    let parameter = graph.parameter(0);
    let mut list = Vec::new();
    let small = {
        let sum = graph.add(x, y);
        graph.mul(quarter, sum)
    };
    for function in [
        Function::Exp,
        Function::Sin,
        Function::Cos,
        Function::Tan,
        Function::Asin,
        Function::Acos,
        Function::Atan,
        Function::Sinh,
        Function::Cosh,
        Function::Tanh,
    ] {
        list.push((format!("{function:?}"), graph.call(function, small)));
    }
    let positive = {
        let square = graph.power(x, two);
        let sum = graph.add(square, y);
        graph.add(sum, two)
    };
    list.push(("ln".into(), graph.call(Function::Ln, positive)));
    for exponent in [0.5, -0.5, 1.5, -1.0, -2.0, 3.0, 7.0, 0.3, -1.7] {
        let exponent_expr = graph.number(exponent);
        list.push((
            format!("power {exponent}"),
            graph.power(positive, exponent_expr),
        ));
    }
    list.push(("constant exponent".into(), graph.power(positive, parameter)));
    list.push(("variable exponent".into(), graph.power(positive, small)));
    let product = graph.mul(x, y);
    list.push(("product".into(), product));
    let below = graph.add(positive, product);
    list.push(("quotient".into(), graph.div(small, below)));
    let factor = graph.sub(product, one);
    let scaled = graph.mul(parameter, factor);
    list.push(("factor before a sum".into(), scaled));
    list
}

fn check<R: Real>(x: f64, y: f64, parameter: f64, step: f64, tolerance: f64) {
    let mut graph = Graph::default();
    let field = oscillator(&mut graph);
    let named = outputs(&mut graph);
    assert!(named.len() > 20);
    for (name, expr) in named {
        let tape = Tape::new(&mut graph, 2, &field, &[expr]);
        let parameters = [R::splat(parameter)];
        let constants = tape.constants(&graph, &parameters);
        let mut expansion = Expansion::<R>::new(&[&tape]);
        let order = R::ORDERS[R::ORDERS.len() - 1];
        let tau = R::splat(0.5);
        let start = [R::splat(x), R::splat(y)];
        expansion.run(&tape, &constants, &start, &[R::ZERO; 2], tau, order);
        let s = R::splat(step);
        let end = [
            horner(expansion.series(0), s),
            horner(expansion.series(1), s),
        ];
        let value = horner(expansion.output(&tape, 0).unwrap(), s);
        let direct = graph.evaluate(expr, &end, &parameters);
        let error = (value - direct).abs().to_f64();
        assert!(
            error <= tolerance * direct.abs().to_f64().max(1.0),
            "{name} at ({x}, {y}), step {step}: {value} against {direct}, off by {error:e}"
        );
    }
}

/// A derivative that is integrated at once gives the bits of one that is a series of its own, because it is an output too.
#[test]
fn an_integrated_derivative_is_that_series_integrated() {
    const ORDER: usize = 20;
    let expand = |outputs: usize| {
        let mut graph = Graph::default();
        let field = oscillator(&mut graph);
        let tape = Tape::new(&mut graph, 2, &field, &field[2 - outputs..]);
        let constants = tape.constants(&graph, &[]);
        let mut expansion = Expansion::<f64>::new(&[&tape]);
        expansion.run(&tape, &constants, &[0.3, 0.4], &[1e-18, -1e-18], 0.5, ORDER);
        let bits = |slot: usize| expansion.series(slot).iter().map(|c| c.to_bits());
        (0..2).flat_map(bits).collect::<Vec<_>>()
    };
    assert_eq!(expand(0), expand(1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn functions_follow_the_flow(x in -0.8_f64..0.8, y in -0.8_f64..0.8, p in -2.0_f64..2.0, s in 0.0_f64..0.5) {
        check::<f64>(x, y, p, s, 3e-14);
    }

    #[test]
    fn and_to_thirty_digits(x in -0.8_f64..0.8, y in -0.8_f64..0.8, p in -2.0_f64..2.0, s in 0.0_f64..0.3) {
        check::<DoubleDouble>(x, y, p, s, 3e-29);
    }

    #[test]
    fn a_lane_is_the_scalar_to_the_bit(x in -0.8_f64..0.8, y in -0.8_f64..0.8, p in -2.0_f64..2.0) {
        let mut graph = Graph::default();
        let field = oscillator(&mut graph);
        for (name, expr) in outputs(&mut graph) {
            let tape = Tape::new(&mut graph, 2, &field, &[expr]);
            let constants = tape.constants(&graph, &[p]);
            let mut single = Expansion::<f64>::new(&[&tape]);
            single.run(&tape, &constants, &[x, y], &[1e-18, -1e-18], 0.5, 20);
            let mut wide = Expansion::<Lanes<4>>::new(&[&tape]);
            let lanes: Vec<_> = constants.iter().map(|&c| Lanes::<4>::splat(c)).collect();
            let state = [Lanes([x, 0.1, x, 0.2]), Lanes([y, 0.3, y, -0.2])];
            wide.run(&tape, &lanes, &state, &[Lanes::splat(1e-18), Lanes::splat(-1e-18)], Lanes::splat(0.5), 20);
            for (a, b) in single.output(&tape, 0).unwrap().iter().zip(wide.output(&tape, 0).unwrap()) {
                prop_assert_eq!(a.to_bits(), b.0[2].to_bits(), "{}", name);
            }
        }
    }
}
