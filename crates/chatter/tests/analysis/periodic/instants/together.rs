//! Impacts that share an instant: closed contacts that feel another's impact, and flights of several contacts that end at once.

use crate::periodic::differences::{agree, differences};
use crate::periodic::{GRAZES, nearest, over, settles, value, with};
use chatter::analysis::periodic::{PeriodicError, SpecialKind};
use chatter::model::Model;
use chatter::numerics::Real;

/// A hammer strikes a nail that a spring holds on a stop: the stop feels the blow, and sends the nail back against the hammer.
const HAMMER: &str = r#"
[parameters]
F = 2.0
omega = 1.5
p = 2.0
[flight]
x = "v"
v = "-x - 0.2*v + F*cos(omega*t)"
y = "w"
w = "-4*y - 0.3*w - p"
[[contact]]
name = "stop"
gap = "y"
impulse = { w = 1 }
restitution = 0.3
[[contact]]
name = "hammer"
gap = "x - y + 0.3"
impulse = { v = 1, w = -0.5 }
restitution = 0.5
[initial]
x = 1
v = 0
y = 0
w = 0
"#;

/// Two equal masses under one force, each at a stop of its own, in phase.
fn pair(coupling: &str) -> Model {
    let text = r#"
[parameters]
F = 2.0
[flight]
x = "v"
v = "-x - 0.1*v + F*cos(2.1*t) - COUPLING"
y = "w"
w = "-y - 0.1*w + F*cos(2.1*t) + COUPLING"
[[contact]]
name = "right"
gap = "0.3 - x"
impulse = { v = -1 }
restitution = 0.7
[[contact]]
name = "top"
gap = "0.3 - y"
impulse = { w = -1 }
restitution = 0.7
[initial]
x = 0
v = 0
y = 0
w = 0
"#;
    with(&text.replace("COUPLING", coupling), &[])
}

#[test]
fn a_stop_feels_what_strikes_the_nail_on_it() {
    for set in [&[][..], &[("p", "0.8"), ("omega", "2.5")]] {
        let model = with(HAMMER, set);
        let orbit = settles(&model).unwrap();
        assert!(orbit.residual < 1e-28, "{}", orbit.residual);
        agree(&orbit, &differences(&model, &orbit));
    }
}

#[test]
fn the_branch_of_a_hammer_doubles() {
    let branches = over(&with(HAMMER, &[]), "omega", (1.3, 2.6), (40, 0.02));
    let doubling = nearest(&branches, &[SpecialKind::PeriodDoubling], 2.37);
    // Beside it the motion settles to orbits of one period, and of two.
    let periods = |omega: f64| {
        let model = with(HAMMER, &[("omega", &format!("{omega}"))]);
        let period = settles(&model).unwrap().period.to_f64();
        (period * omega / core::f64::consts::TAU).round()
    };
    let simple = if periods(value(&doubling) - 0.01) == 1.0 {
        -0.01
    } else {
        0.01
    };
    assert_eq!(periods(value(&doubling) + simple), 1.0);
    assert_eq!(periods(value(&doubling) - simple), 2.0);
}

#[test]
fn two_masses_in_phase_strike_at_once() {
    for coupling in ["0", "0.3*(x - y)"] {
        let model = pair(coupling);
        let orbit = settles(&model).unwrap();
        assert_eq!(orbit.impacts, Some(2));
        agree(&orbit, &differences(&model, &orbit));
    }
    // With a damper between them each impact changes the force on the other mass.
    let damped = settles(&pair("0.3*(v - w)"));
    assert!(
        matches!(damped, Err(PeriodicError::OrderMatters { .. })),
        "{damped:?}"
    );
}

#[test]
fn masses_in_phase_part_at_a_branch_point_and_lose_both_impacts_at_one_graze() {
    let branches = over(&pair("0.3*(x - y)"), "F", (0.5, 3.0), (40, 0.02));
    // A displacement of one against the other grows by itself: its multiplier is one where the branch of motion out of phase begins.
    let parting = nearest(&branches, &[SpecialKind::BranchPoint], 2.2);
    let model = |by: f64| {
        let mut model = pair("0.3*(x - y)");
        let value = format!("{:?}", value(&parting) + by);
        model.set_parameter("F", &value).unwrap();
        model
    };
    let largest = |by: f64| {
        let orbit = settles(&model(by)).unwrap();
        orbit.multipliers[0].re
    };
    let (before, after) = (largest(-1e-3) - 1.0, largest(1e-3) - 1.0);
    assert!(before * after < 0.0, "{before} {after}");
    assert!(
        (before + after).abs() < 1e-2 * after.abs(),
        "{before} {after}"
    );
    let graze = nearest(&branches, &GRAZES, 1.025);
    // Without impacts each is a linear oscillator of amplitude 0.3 there.
    let (w, z) = (2.1_f64, 0.1);
    let exact = 0.3 * ((1.0 - w * w).powi(2) + (z * w).powi(2)).sqrt();
    assert!((value(&graze) - exact).abs() < 1e-12, "{}", value(&graze));
}

#[test]
fn a_ball_at_rest_on_a_plate_is_told_on_it() {
    let text = r#"
[table.lift]
x = [0, 0.25, 0.5, 0.75, 1]
y = [0, 0.7, 1, 0.7, 0]
kind = "periodic-cubic"
[flight]
y = "v"
v = "-10 - 0.2*v + 0.1*mod(t, 0.5)"
[[contact]]
name = "plate"
gap = "y - 0.05*lift(t/1.5)"
impulse = { v = 1 }
restitution = 0.5
[initial]
y = 0.3
v = 0
"#;
    let orbit = settles(&with(text, &[])).unwrap();
    // Exactly, since simulations start there: whatever is below the plate is beyond it.
    let phase = orbit.start[2].to_f64().rem_euclid(1.5);
    assert!(phase != 0.0 || orbit.start[0].to_f64() == 0.0);
}
