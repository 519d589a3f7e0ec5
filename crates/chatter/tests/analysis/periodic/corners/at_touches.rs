//! Corners of drag, `v*abs(v)`, that fall at the very instant of a touch, and touches that fall together: the branch goes through, from every start
//! and at every step.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// The touches of the branch from a start, which goes through its range, all of which persist.
fn touches(text: &str, name: &str, range: (f64, f64), (start, step): (&str, f64)) -> Vec<f64> {
    let found = over(&with(text, &[(name, start)]), name, range, (4, step));
    let branch = &found[0];
    let context = format!("from {start} by {step}");
    assert_eq!(branch.ends, [End::Range, End::Range], "{context}");
    let all = branch.special.iter();
    all.map(|special| {
        let kind = (special.kind, special.persists);
        assert_eq!(kind, (SpecialKind::Touch, Some(true)), "{context}");
        value(special)
    })
    .collect()
}

fn assert_one(found: &[f64], expected: f64, tolerance: f64) {
    let is_it = matches!(found, [one] if (one - expected).abs() < tolerance);
    assert!(is_it, "{found:?} and not {expected}");
}

/// On a floor that shakes by A sin(w t) the force is least where the rate turns, and vanishes there where A w^2 = g.
#[test]
fn a_ball_with_drag_leaves_the_floor_where_its_force_vanishes() {
    let text = r#"
    [parameters]
    omega = 8
    [flight]
    y = "v"
    v = "-9.81 - 0.2*v*abs(v)"
    [[contact]]
    name = "floor"
    gap = "y - 0.15*sin(omega*t)"
    impulse = { v = 1 }
    restitution = 0.75
    [section.strobe]
    surface = "sin(omega*t)"
    direction = "rising"
    [initial]
    y = 0.1
    v = 1
    "#;
    let expected = libm::sqrt(9.81 / 0.15);
    for walk in [("8.05", 0.05), ("8.06", 0.1)] {
        let found = touches(text, "omega", (8.04, 8.1), walk);
        assert_one(&found, expected, 1e-12);
    }
}

/// A gear with backlash b whose teeth come apart below omega_1, where its least place with teeth in mesh is b, just as its rate turns.
const GEAR: &str = r#"
    [parameters]
    omega = 1.2
    [flight]
    x = "v"
    v = "0.2 + 0.15*cos(omega*t + 0.4) - 0.08*v - 0.05*v*abs(v) - (1 + 0.25*cos(omega*t))*(x - clamp(x, -0.5, 0.5))"
    [section.strobe]
    surface = "sin(omega*t)"
    direction = "rising"
    [initial]
    x = 0.8
    v = 0
    "#;

#[test]
fn teeth_with_drag_part_where_their_rate_turns() {
    for walk in [("1.2", 0.02), ("1.205", 0.1)] {
        let found = touches(GEAR, "omega", (1.2, 1.22), walk);
        assert_one(&found, 1.211_550_661_855_699_7, 1e-12);
    }
}

/// At this step the corner of the drag has changed places with the way back just before the touch, where the parameter stands still.
#[test]
fn teeth_part_where_a_corner_has_changed_places_just_before() {
    let found = touches(GEAR, "omega", (1.19, 1.23), ("1.2", 0.01));
    assert_one(&found, 1.211_550_661_855_699_7, 1e-12);
}

/// A wheelset that runs between two flanges, and touches both alike.
#[test]
fn both_flanges_are_touched_at_once() {
    let text = r#"
    [parameters]
    V = 1.6
    [flight]
    y = "v"
    v = "-y - 0.3*v - (v/V - psi) - 30*(y - clamp(y, -0.6, 0.6))"
    psi = "q"
    q = "-psi - 0.3*q - (q/V + 0.6*V*y) - 0.3*q^3"
    [section.mid]
    surface = "y"
    direction = "rising"
    [initial]
    y = 0.1
    v = 0
    psi = 0.1
    q = 0
    "#;
    for walk in [
        ("1.58", 0.1),
        ("1.59", 0.02),
        ("1.65", 0.02),
        ("1.565", 0.02),
    ] {
        let found = touches(text, "V", (1.56, 1.66), walk);
        assert_one(&found, 1.571_373_818_752_045, 1e-12);
    }
}
