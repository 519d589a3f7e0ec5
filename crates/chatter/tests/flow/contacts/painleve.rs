//! A slender rod that slides and hits on its tip (Painlevé): a contact only pushes, and friction opposes sliding within its cone.

use chatter::analysis::simulate::{Outcome, SimulateError, Simulation, Spec, simulate};
use chatter::flow::{FlowError, Occurrence};
use chatter::model::Model;
use std::ops::ControlFlow;

/// The angle of the rod.
const ANGLE: f64 = 1.0;

/// Inverse inertia at the tip: normal, tangential, and what couples them.
fn inertia() -> [f64; 3] {
    let (sine, cosine) = ANGLE.sin_cos();
    [
        1.0 + 3.0 * cosine * cosine,
        1.0 + 3.0 * sine * sine,
        -3.0 * sine * cosine,
    ]
}

fn run(
    (friction, restitution): (f64, f64),
    (height, speed, spin): (f64, f64, f64),
    until: f64,
) -> Result<Simulation<f64>, SimulateError> {
    let text = format!(
        r#"
        [flight]
        x = "u"
        u = "0"
        y = "w"
        w = "-9.81"
        th = "om"
        om = "0"
        [[contact]]
        name = "tip"
        gap = "y - sin(th)"
        impulse = {{ w = 1, om = "-3*cos(th)" }}
        restitution = {restitution}
        friction = {{ coefficient = {friction}, along = {{ u = 1, om = "3*sin(th)" }}, rate = "u + sin(th)*om" }}
        [initial]
        x = 0
        u = {speed}
        y = "sin({ANGLE}) + {height}"
        w = "cos({ANGLE})*({spin})"
        th = {ANGLE}
        om = {spin}
        "#
    );
    let model = Model::from_toml(&text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate::<f64>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
}

fn energy(state: &[f64]) -> f64 {
    let [_, u, y, w, _, om] = state[..6] else {
        panic!("six states")
    };
    0.5 * (u * u + w * w + om * om / 3.0) + 9.81 * y
}

fn jams_at_start(found: Result<Simulation<f64>, SimulateError>) {
    let jams = matches!(
        &found,
        Err(SimulateError::Start(FlowError::Jammed { time, contact: 0 })) if *time == 0.0
    );
    assert!(jams, "{:?}", found.map(|run| run.outcome));
}

/// In Painlevé's region a force would have to pull to hold the contact (a < 0), or is one of two answers (a > 0).
#[test]
fn a_rod_that_begins_in_the_region_jams_there() {
    let [normal, _, coupling] = inertia();
    assert!(normal + 1.5 * coupling < 0.0);
    jams_at_start(run((1.5, 0.0), (0.0, -2.0, 0.0), 0.05));
    let spin = -4.0;
    assert!(ANGLE.sin() * spin * spin > 9.81);
    jams_at_start(run((1.5, 0.0), (0.0, -2.0, spin), 0.05));
    // The other way it slides with a force that pushes, and less friction holds it.
    for (friction, speed) in [(1.5, 2.0), (0.5, -2.0)] {
        let run = run((friction, 0.0), (0.0, speed, 0.0), 0.01).expect("a legal start");
        assert_eq!(run.outcome, Outcome::Horizon);
        assert!(run.closed.contains(0));
        assert!(run.state[3] > -9.81 * 0.01, "{:?}", run.state);
        assert!(run.state[1].abs() < speed.abs(), "{:?}", run.state);
    }
}

/// With an impulse of full sliding that would have to pull, the impact stops the sliding: both rates are known, and the impulses lie
/// within the cone.
#[test]
fn an_impact_in_the_region_stops_the_sliding() {
    for friction in [1.38, 1.5, 3.0] {
        let run = run((friction, 0.5), (0.1, -2.0, 0.0), 0.2).expect("a legal start");
        assert_eq!(run.outcome, Outcome::Horizon);
        let impact = &run.events[0];
        let Occurrence::Impact {
            rate_before,
            rate_after,
            ..
        } = impact.detail
        else {
            panic!("{:?}", run.events)
        };
        assert!((rate_before + f64::sqrt(2.0 * 9.81 * 0.1)).abs() < 1e-14);
        assert!((rate_after + 0.5 * rate_before).abs() < 1e-12);
        let [normal, tangential, coupling] = inertia();
        let (rise, stop) = (rate_after - rate_before, 2.0);
        let determinant = normal * tangential - coupling * coupling;
        let push = (tangential * rise - coupling * stop) / determinant;
        let along = (normal * stop - coupling * rise) / determinant;
        assert!(push > 0.0 && along.abs() < friction * push);
        let state = &impact.state;
        let expected = [-2.0 + along, rate_before + push];
        for (found, expected) in [state[1], state[3]].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{friction}: {state:?}");
        }
        assert!((state[1] + ANGLE.sin() * state[5]).abs() < 1e-12);
        assert!(energy(state) < energy(&run.start_state));
    }
}

/// Where the impulse of the contact turns the sliding round, and friction is too weak to stop it, it opposes the sliding that follows: of
/// a rod that falls without any, and of one that slides slowly.
#[test]
fn an_impact_that_friction_cannot_stop_slides_on_the_other_way() {
    let [normal, tangential, coupling] = inertia();
    for speed in [0.0, 0.05] {
        for friction in [0.1, 0.3] {
            let run = run((friction, 0.5), (0.1, speed, 0.0), 0.2).expect("a legal start");
            let impact = &run.events[0];
            assert!(matches!(impact.detail, Occurrence::Impact { .. }));
            let push = 1.5 * f64::sqrt(2.0 * 9.81 * 0.1) / (normal + friction * coupling);
            let after = speed + push * (coupling + friction * tangential);
            assert!(after < 0.0);
            let state = &impact.state;
            let sliding = state[1] + ANGLE.sin() * state[5];
            assert!((sliding - after).abs() < 1e-13, "{sliding}, not {after}");
            assert!((state[1] - speed - friction * push).abs() < 1e-13);
        }
    }
}
