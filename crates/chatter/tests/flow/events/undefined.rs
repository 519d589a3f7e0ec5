//! Folding never changes where an expression is undefined: what has no value at some parameter or state is refused, or ends
//! the run there.

use chatter::analysis::simulate::{Outcome, SimulateError, Spec, simulate};
use chatter::expressions::Singularity;
use chatter::flow::FlowError;
use chatter::model::{Model, ModelErrorKind};
use std::ops::ControlFlow;

fn text(field: &str, impulse: &str, restitution: &str, section: &str) -> String {
    format!(
        "[parameters]\ng = 1\nr = 0.5\nm = 2\n[flight]\ny = \"v\"\nv = \"{field}\"\n[[contact]]\nname = \"floor\"\n\
         gap = \"y\"\nimpulse = {{ v = \"{impulse}\" }}\nrestitution = \"{restitution}\"\n[section.cut]\n\
         surface = \"{section}\"\n[initial]\ny = 1\nv = 0\n"
    )
}

/// The message of the only error.
fn refused(text: &str) -> String {
    let errors = Model::from_toml(text, "test").expect_err(text);
    assert!(
        matches!(errors.errors()[0].kind(), ModelErrorKind::NotFinite { .. }),
        "{text}"
    );
    errors.errors()[0].kind().to_string()
}

#[test]
fn formulas_without_a_value_are_refused() {
    for undefined in [
        "0/0",
        "1/0",
        "(1/0)*0",
        "(1/0)-(1/0)",
        "log(0)*0",
        "0*sqrt(-1)",
        "(g-1)/(g-1)",
        "(1/(g-1))^0",
        "1^(1/(g-1))",
        "log(g-1)-log(g-1)",
        "1/(1/(g-1))",
        "asin(2*g)*0",
        "sqrt(g-2)^2",
    ] {
        for text in [
            text(undefined, "1", "r", "v"),
            text(&format!("v*({undefined}) - g"), "1", "r", "v"),
            text("-g", undefined, "r", "v"),
            text("-g", "1", undefined, "v"),
            text("-g", "1", "r", &format!("v + ({undefined})")),
            text("-g", "1", "r", "v").replace("r = 0.5", &format!("r = \"{undefined}\"")),
            text("-g", "1", "r", "v").replace("y = 1\n", &format!("y = \"{undefined}\"\n")),
            text("-g", "1", "r", "v") + &format!("[definitions]\nunused = \"{undefined}\"\n"),
        ] {
            refused(&text);
        }
    }
    let message = refused(&text("-v*r/(g - 1)", "1", "r", "v"));
    assert_eq!(message, "`1/(g - 1)` in d/dt of `v` is inf");
    let message = refused(&text("-g", "1/(m - 2)", "r", "v"));
    assert_eq!(
        message,
        "the impulse on `v` of contact `floor`, `1/(m - 2)`, is inf"
    );
}

/// Overflow in the middle of a formula is no gap in where it is defined.
#[test]
fn formulas_with_a_value_are_taken() {
    for defined in [
        "1/(1 + exp(1000*g))",
        "tanh(exp(800))",
        "r/r",
        "0*r",
        "(g-1)*0",
        "sqrt(g-1)",
        "0^g",
        "(1/m)/(1/m)",
    ] {
        let text = text(&format!("-g - ({defined})"), "1", "r", "v");
        assert!(Model::from_toml(&text, "test").is_ok(), "{defined}");
    }
}

/// What parameters do not choose need not have a value: it is as if it were not there.
#[test]
fn pieces_that_parameters_pass_over_need_no_value() {
    let run = |text: &str| {
        let mut model = Model::from_toml(text, "test").unwrap_or_else(|e| panic!("{text}\n{e}"));
        let spec = Spec::until(3.0);
        let on = &mut |_: &_| ControlFlow::Continue(());
        let first = simulate::<f64>(&model, &spec, on).unwrap();
        model.set_parameter("m", "5").unwrap();
        let second = simulate::<f64>(&model, &spec, on).unwrap();
        [first.state, second.state]
    };
    let plain = run(&text("-g", "1", "r", "v"));
    for one in [
        "if(m < 3, sqrt(3 - m), sqrt(m - 4))",
        "if(m > 3, 1/(m - 4), 1/(3 - m))",
        "if(m > 3 and log(m - 4) > -1, asin(m - 4)*2/pi, 1)",
        "if(m < 3 or sqrt(m - 4) > 0.5, 1, sqrt(2 - m))",
        "if(m <= 2, 1, log(m - 2)/log(3))",
    ] {
        let unused = format!("[definitions]\nunused = \"{one}\"\n");
        for text in [
            text(&format!("-g*({one})"), "1", "r", "v"),
            text("-g", one, "r", "v"),
            text("-g", "1", &format!("r*({one})"), "v"),
            text("-g", "1", "r", &format!("v*({one})")),
            text("-g", "1", "r", "v").replace("r = 0.5", &format!("r = \"0.5*({one})\"")),
            text("-g", "1", "r", "v").replace("y = 1\n", &format!("y = \"{one}\"\n")),
            text("-g", "1", "r", "v") + &unused,
        ] {
            for (found, plain) in run(&text).iter().zip(&plain) {
                for (x, y) in found.iter().zip(plain) {
                    assert!((x - y).abs() < 1e-13, "{text}: {x} {y}");
                }
            }
        }
    }
    refused(&text("-g*(if(m < 3, sqrt(1 - m), 1))", "1", "r", "v"));
    refused(&text("-g*(if(m - 2 > sqrt(1 - m), 1, 1/2))", "1", "r", "v"));
}

#[test]
fn parameters_that_leave_a_formula_without_a_value_are_refused() {
    let spec = Spec::until(1.0);
    for (field, impulse, name) in [
        ("-g*r/r", "1", "r"),
        ("-g", "1/m", "m"),
        ("-g", "m/m^2", "m"),
        ("-g + 0*log(m)", "1", "m"),
        ("-g*m^0.5*m^0.5", "m/m", "m"),
    ] {
        let mut model = Model::from_toml(&text(field, impulse, "0.5", "v"), "test").unwrap();
        assert!(model.check_defined().is_ok());
        model.set_parameter(name, "0").unwrap();
        let error = model.check_defined().expect_err(field);
        assert!(error.to_string().contains(" is "), "{error}");
        let outcome = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(()));
        assert!(matches!(outcome, Err(SimulateError::Model(_))), "{field}");
        assert!(model.set_parameter("g", "0/0").is_err());
        assert!(model.set_initial("y", "log(0)*0").is_err());
    }
}

/// A ball that falls from 1 reaches y = 0.5 at time 1.
#[test]
fn states_that_leave_a_formula_without_a_value_end_the_run() {
    for (field, kind) in [
        ("-g*(y - 0.5)/(y - 0.5)", Singularity::Division),
        ("-g + 0/(y - 0.5)", Singularity::Division),
        ("-g + 1/(y - 0.5) - 1/(y - 0.5)", Singularity::Division),
        ("-g*(1/(y - 0.5))^0", Singularity::Division),
        ("-g + 0*log(y - 0.5)", Singularity::Logarithm),
        ("-g + 0*sqrt(y - 0.5)", Singularity::SquareRoot),
        ("-g*(y - 0.5)^-2*(y - 0.5)^2", Singularity::Division),
    ] {
        let model = Model::from_toml(&text(field, "1", "r", "v"), "test").unwrap();
        let run = simulate::<f64>(
            &model,
            &Spec::until(5.0),
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap();
        let Outcome::Failed(FlowError::Singular {
            time, kind: found, ..
        }) = run.outcome
        else {
            panic!("{field}: {:?}", run.outcome);
        };
        assert_eq!(found, kind, "{field}");
        assert!((time - 1.0).abs() < 1e-13, "{field}: {time}");
    }
}

/// What the impulse is divided by cancels exactly, in any unit: a plastic impact leaves no rate.
#[test]
fn derived_quotients_cancel_exactly() {
    for impulse in ["1", "m", "1/m", "1/m^2", "sqrt(m)"] {
        for m in ["3", "0.7", "1e-9"] {
            let mut model = Model::from_toml(&text("-g", impulse, "0", "v"), "test").unwrap();
            model.set_parameter("m", m).unwrap();
            let run = simulate::<f64>(
                &model,
                &Spec::until(5.0),
                &mut |_| ControlFlow::Continue(()),
            )
            .unwrap();
            assert_eq!(run.counts.impacts, 1, "{impulse} at {m}");
            assert_eq!(run.state[..2], [0.0, 0.0], "{impulse} at {m}");
        }
    }
}

/// A round clearance: its gap has no slope at the centre, where nothing is hit, and motion begins there and passes it. What is hit
/// there cannot be.
#[test]
fn a_gap_without_a_slope_matters_where_it_vanishes() {
    let text = |gap: &str, x: &str| {
        format!(
            "[flight]\nx = \"u\"\nu = \"0\"\ny = \"v\"\nv = \"0\"\n[[contact]]\nname = \"ring\"\ngap = \"{gap}\"\n\
             impulse = {{ u = \"-x\", v = \"-y\" }}\nrestitution = 0.5\n[initial]\nx = {x}\nu = 0.1\ny = 0\nv = 0\n"
        )
    };
    for gap in ["1 - hypot(x, y)", "1 - sqrt(x^2 + y^2)"] {
        // From the centre to the ring in 10, from the other side of it in 15; back at half the rate, through the centre again.
        for (start, expected) in [("0", -0.25), ("-0.5", 0.0)] {
            let model = Model::from_toml(&text(gap, start), "test").unwrap();
            let run = simulate::<f64>(&model, &Spec::until(35.0), &mut |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
            assert_eq!(run.outcome, Outcome::Horizon, "{gap}");
            assert_eq!(run.counts.impacts, 1, "{gap}");
            assert!((run.state[0] - expected).abs() < 1e-14, "{:?}", run.state);
        }
    }
    let model = Model::from_toml(&text("hypot(x, y)", "0"), "test").unwrap();
    let start = simulate::<f64>(
        &model,
        &Spec::until(1.0),
        &mut |_| ControlFlow::Continue(()),
    );
    let Err(SimulateError::Start(FlowError::Singular {
        kind, expression, ..
    })) = start
    else {
        panic!("{start:?}");
    };
    assert_eq!(kind, Singularity::SquareRoot);
    assert_eq!(expression, "x^2 + y^2");
}
