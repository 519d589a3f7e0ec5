//! Where states matter only by their differences an orbit drifts along, and its multipliers are those of the differences.

use super::{model, orbit, over, value, with};
use chatter::analysis::exponents::{Spec as Averages, exponents};
use chatter::analysis::periodic::SpecialKind;
use chatter::numerics::Real;
use core::f64::consts::TAU;
use std::ops::ControlFlow;

/// A driven mass that strikes a carriage from within, both on their way somewhere.
const DRIFTING: &str = r#"
[parameters]
F = 1.3
w = 2.1
[flight]
x = "u"
X = "U"
u = "F*cos(w*t) - 0.1*(u - U) - (x - X)"
U = "(0.1*(u - U) + (x - X) - 0.7*U + 0.2)/2"
[[contact]]
name = "front"
gap = "0.4 - (x - X)"
impulse = { u = -1, U = "1/2" }
restitution = 0.6
[initial]
x = 0
X = 0
u = 0.1
U = 0
"#;

/// The same in the mass's place on the carriage.
fn at_rest() -> String {
    DRIFTING
        .replace("x = \"u\"\nX = \"U\"", "z = \"u - U\"")
        .replace("(x - X)", "z")
        .replace("x = 0\nX = 0", "z = 0")
}

#[test]
fn multipliers_and_special_points_of_what_drifts_are_those_of_the_differences() {
    let (drifting, resting) = (with(DRIFTING, &[]), with(&at_rest(), &[]));
    let (one, other) = (orbit(&drifting), orbit(&resting));
    assert_eq!(one.multipliers.len(), 3);
    for (a, b) in one.multipliers.iter().zip(&other.multipliers) {
        assert!(
            (a.re - b.re).hypot(a.im - b.im) < 1e-10,
            "{:?} {:?}",
            one.multipliers,
            other.multipliers
        );
    }
    let special = |model| -> Vec<(SpecialKind, f64)> {
        over(model, "w", (1.6, 3.0), (20, 0.05))
            .iter()
            .flat_map(|branch| &branch.special)
            .map(|special| (special.kind, value(special)))
            .collect()
    };
    let (one, other) = (special(&drifting), special(&resting));
    assert_eq!(one.len(), other.len(), "{one:?} {other:?}");
    assert!(!one.is_empty());
    for (a, b) in one.iter().zip(&other) {
        assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-9, "{one:?} {other:?}");
    }
}

/// The largest exponent is that of the largest multiplier.
#[test]
fn the_drill_has_the_multiplier_that_its_exponent_says() {
    let drill = model("percussive_drill", &[]);
    let found = orbit(&drill);
    let period = found.period.to_f64();
    let spec = Averages {
        interval: TAU / 0.4,
        transient: 100,
        intervals: 400,
    };
    let averages = exponents(&drill, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    // Progress itself is a direction in which nothing grows.
    let largest = averages
        .values
        .iter()
        .find(|value| **value < -1e-6)
        .unwrap();
    let expected = (largest * period).exp();
    let modulus = found.multipliers[0].modulus();
    assert!(
        (modulus - expected).abs() < 1e-4 * expected,
        "{modulus} {expected} {averages:?}"
    );
}
