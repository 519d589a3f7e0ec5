//! A run beside its twin in double-double: what agrees is told, and where they part ways.

use chatter::analysis::simulate::{
    EventKind, EventTarget, Outcome, Spec, Stop, Verification, digits, simulate,
};
use chatter::model::Model;
use std::ops::ControlFlow;

const BALL: &str = include_str!("../../../../models/bouncing_ball.toml");

/// A ball on a table whose strokes are as long as its flights: ln 7 is lost with each impact, more or less.
const TABLE: &str = r#"
[flight]
y = "v"
v = "-1"
[[contact]]
gap = "y - 2*sin(t)"
impulse = { v = 1 }
restitution = 0.8
[initial]
y = 3
v = 0
"#;
const VALVE: &str = include_str!("../../../../models/pressure_relief_valve.toml");

fn verified(
    text: &str,
    changes: &[(&str, &str)],
    spec: &Spec,
) -> (chatter::analysis::simulate::Simulation<f64>, Verification) {
    let mut model = Model::from_toml(text, "test").expect("a valid model");
    for (name, value) in changes {
        model.set_parameter(name, value).expect("a known parameter");
    }
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let run = simulate::<f64>(&model, spec, &mut go_on).expect("a valid run");
    let verification = Verification::of(&model, spec, &run, &mut go_on).expect("a valid run");
    (run, verification.expect("nobody breaks off"))
}

#[test]
fn a_run_to_rest_agrees_to_all_digits() {
    let spec = Spec::until(50.0);
    let (run, verification) = verified(BALL, &[("r", "0.7")], &spec);
    assert_eq!(verification.parting, None);
    assert_eq!(verification.times.len(), run.events.len());
    assert!(verification.worst_time() < 1e-13, "{verification:?}");
    assert!(verification.worst_time() > 0.0);
    let end = verification.end.expect("both end in contact");
    assert!(
        end.time == 0.0 && end.state.iter().all(|&off| off < 1e-13),
        "{end:?}"
    );
}

#[test]
fn chaos_loses_digits_until_the_runs_part_ways() {
    let spec = Spec::until(500.0);
    let (run, verification) = verified(TABLE, &[], &spec);
    let parting = verification.parting.as_ref().expect("chaos forgets");
    let end = verification.end.as_ref().expect("both reach the time");
    assert!(end.state.iter().any(|&off| off > 1e-3), "{end:?}");
    assert_eq!(parting.after, verification.times.len());
    assert!(
        parting.after > 20 && parting.after <= run.events.len(),
        "{parting:?}"
    );
    let errors: Vec<f64> = verification
        .times
        .iter()
        .copied()
        .filter(|e| e.is_finite())
        .collect();
    assert!(errors[..3].iter().all(|&error| error < 1e-13), "{errors:?}");
    let early = errors[errors.len() / 4];
    let late = errors[errors.len() - 1];
    assert!(late > 1e3 * early.max(1e-16), "{early:e} {late:e}");
    // Long before that the error is far more than what is told of an accumulation.
    assert!(
        verification.worst_time() > 1e-9,
        "{:e}",
        verification.worst_time()
    );
}

#[test]
fn a_run_that_an_event_ends_is_compared_there() {
    let stop = Stop::Event(EventTarget {
        kind: EventKind::Accumulation,
        at: None,
        count: 3,
    });
    let spec = Spec {
        stops: vec![stop],
        ..Spec::until(200.0)
    };
    let (run, verification) = verified(VALVE, &[("q", "0.0195")], &spec);
    assert!(matches!(run.outcome, Outcome::Event(_)));
    assert_eq!(verification.parting, None);
    assert_eq!(verification.times.len(), run.events.len());
    let end = verification.end.expect("the same event");
    assert!(
        end.time < 1e-11 && end.state.iter().all(|&off| off < 1e-11),
        "{end:?}"
    );
    let (_, verification) = verified(
        VALVE,
        &[("q", "0.0195")],
        &Spec {
            impacts: 20,
            ..Spec::until(200.0)
        },
    );
    assert_eq!(verification.parting, None);
    assert!(verification.end.is_some_and(|end| end.time < 1e-11));
}

#[test]
fn digits_are_those_in_common() {
    assert_eq!(digits(2.0, 0.0), 16);
    assert_eq!(digits(1.0, 1.1e-9), 8);
    assert_eq!(digits(1e-9, 1e-9), 0);
    assert_eq!(digits(1e-9, 1.0), 0);
    assert_eq!(digits(0.0, 1e-30), 0);
}
