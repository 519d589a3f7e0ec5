//! Orbits with events that change the state, dead zones, motion that comes to rest, and ends of what theory allows.

use super::{model, nearest, orbit, over, value, with};
use chatter::analysis::periodic::{End, Spec, SpecialKind, settled};
use chatter::numerics::Real;
use core::f64::consts::PI;
use std::ops::ControlFlow;

/// A linear oscillator that is kicked where it comes up through zero: by Liouville's formula the product of its multipliers is
/// k^2 exp(-c T).
const KICKED: &str = r#"
[parameters]
om = 1.3
k = 0.8
[flight]
x = "v"
v = "-x - 0.1*v + cos(om*t)"
[[event]]
name = "kick"
surface = "x"
direction = "rising"
reset = { v = "k*v" }
[initial]
x = 0.1
v = 0
"#;

#[test]
fn an_orbit_with_an_event_is_followed_over_a_range() {
    let product = |k: f64| k * k * (-0.1 * 2.0 * PI / 1.3).exp();
    let found = orbit(&with(KICKED, &[]));
    let all: f64 = found.multipliers.iter().map(|m| m.modulus()).product();
    assert!((all - product(0.8)).abs() < 1e-9, "{all}");
    let branches = over(&with(KICKED, &[]), "k", (0.3, 1.2), (40, 0.01));
    assert_eq!(branches.len(), 1);
    assert_eq!(branches[0].ends, [End::Range, End::Range]);
    assert!(branches[0].special.is_empty(), "{:?}", branches[0].special);
    for point in &branches[0].points {
        let all: f64 = point.multipliers.iter().map(|m| m.modulus()).product();
        assert!((all - product(point.parameter())).abs() < 1e-9);
    }
}

/// A mass that is free between two soft stops, started where no force depends on its place.
#[test]
fn what_a_dead_zone_hides_at_the_start_is_a_state_of_the_orbit() {
    let text = "[parameters]\ng = 2\n[flight]\nx = \"v\"\nv = \"4*cos(t) - 0.3*v - 30*(max(x - g, 0) - max(-x - 1.3*g, 0))\"\n\
                [initial]\nx = 0\nv = 0\n";
    let model = with(text, &[]);
    let spec = Spec::default();
    let found = settled(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(found.multipliers.len(), 2);
    let all: f64 = found.multipliers.iter().map(|m| m.modulus()).product();
    let expected = (-0.3 * found.period.to_f64()).exp();
    assert!((all - expected).abs() < 1e-9, "{all} {expected}");
}

/// Pressed against its stop for ever, a forced oscillator moves no more: an orbit of one period that forgets everything.
#[test]
fn rest_under_a_force_is_an_orbit() {
    let model = model("impact_oscillator", &[("sigma", "-2")]);
    let mut model = model;
    model.set_initial("x", "-2.5").unwrap();
    let found = orbit(&model);
    let omega = model.parameter_values::<f64>(&[])[model.parameter_index("omega").unwrap()];
    assert!((found.period.to_f64() - 2.0 * PI / omega).abs() < 1e-12);
    assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
}

/// Where another event comes before an impact the branch goes on with the other order, read off the motion: below 1.99195.
#[test]
fn complete_chatter_goes_on_where_the_order_of_events_changes() {
    let found = over(&model("dwell_cam", &[]), "omega", (1.985, 2.0), (60, 0.01));
    assert!(found[0].points.iter().all(|point| point.impacts.is_none()));
    let least = (found[0].points.iter()).map(|point| point.parameter());
    let least = least.fold(f64::INFINITY, f64::min);
    assert!(least < 1.989, "{least}");
}

const STOP: &str = r#"
[parameters]
r = 0.7
[flight]
x = "v"
v = "cos(t) - 0.1*v - x"
[[contact]]
name = "s"
gap = "0.5 - x"
impulse = { v = -1 }
restitution = "r"
[initial]
x = 0
v = 0
"#;

#[test]
fn a_branch_ends_where_a_restitution_would_be_more_than_one() {
    let found = over(&with(STOP, &[]), "r", (0.6, 1.4), (40, 0.02));
    let largest = (found.iter().flat_map(|branch| &branch.points))
        .map(|point| point.parameter())
        .fold(0.0, f64::max);
    assert!((largest - 1.0).abs() < 1e-12, "{largest}");
    let special = found.iter().flat_map(|branch| &branch.special);
    assert!(special.map(value).all(|at| at <= 1.0));
}

/// Grazes accumulate at a border in the ratio eta, 0.098 at this restitution; those whose flights are no higher than rounding
/// are not told, and what is told lies on its own side of the border.
#[test]
fn flights_below_rounding_are_no_impacts() {
    let found = over(&with(STOP, &[]), "r", (0.08, 0.081), (60, 0.02));
    let border = value(&nearest(&found, &[SpecialKind::ChatterBorder], 0.0804544));
    assert!((border - 0.080_454_482_485_117).abs() < 1e-12, "{border}");
    let many = found.iter().flat_map(|branch| &branch.points);
    for point in many.filter(|point| point.impacts.is_some_and(|n| n > 3)) {
        assert!(point.parameter() > border - 1e-12, "{point:?}");
    }
}

/// A thyristor that fires and goes out once a period, which sets its current to zero: nothing is left of a displacement, and no quotient of
/// multipliers says what the second one is.
#[test]
fn what_resets_forget_altogether_has_no_multipliers_but_zero() {
    let text = r#"
[flight]
i = "if(q > 0.5, sin(t) - 0.2 - 0.3*i, 0)"
q = "0"
[[event]]
name = "fire"
surface = "sin(t - 1)"
direction = "rising"
reset = { q = 1 }
[[event]]
name = "off"
surface = "i + 1 - q"
direction = "falling"
reset = { q = 0, i = 0 }
[initial]
i = 0
q = 0
"#;
    let found = orbit(&with(text, &[]));
    assert!((found.period.to_f64() - 2.0 * PI).abs() < 1e-14);
    assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
    assert!(!found.multipliers.is_empty() && found.is_stable());
}
