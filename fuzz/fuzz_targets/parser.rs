//! Any text is read as an expression or refused with a span inside it; what is read can be differentiated, evaluated,
//! rebuilt unchanged and, as a formula, read again.

#![no_main]

use chatter::expressions::{Graph, Names, ParseErrorKind, Symbol};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let mut graph = Graph::default();
    let (x, y, kappa) = (graph.state(0), graph.state(1), graph.parameter(0));
    let resolve = |name: &str| match name {
        "x" => Some(x),
        "y" => Some(y),
        "kappa" => Some(kappa),
        _ => None,
    };
    let known = ["x", "y", "kappa"];
    let expr = match graph.parse(text, &resolve, &known) {
        Ok(expr) => expr,
        Err(error) => {
            assert!(text.get(error.span.clone()).is_some(), "{error:?}");
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    assert_eq!(graph.substitute(expr, &|_| None), expr);
    let derivative = graph.derivative(expr, Symbol::State(0));
    for part in [expr, derivative] {
        let _ = graph.evaluate(part, &[0.7_f64, -1.3], &[2.0]);
        let (states, parameters) = (["x".to_string(), "y".to_string()], ["kappa".to_string()]);
        let names = Names {
            states: &states,
            parameters: &parameters,
        };
        let _ = graph.to_tex(part, names);
        let formula = graph.to_text(part, names);
        if formula.contains('…') {
            continue;
        }
        if let Err(error) = graph.parse(&formula, &resolve, &known) {
            let is_large = matches!(
                error.kind,
                ParseErrorKind::TooDeep | ParseErrorKind::TooLong { .. }
            );
            assert!(is_large, "{formula}: {error}");
        }
    }
});
