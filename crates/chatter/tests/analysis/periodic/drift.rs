//! Where states matter only by their differences an orbit drifts along, and its multipliers are those of the differences.

use super::corners::touches::CONVEYED;
use super::{model, orbit, over, value, with};
use chatter::analysis::exponents::{Spec as Averages, exponents};
use chatter::analysis::periodic::{End, SpecialKind};
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

/// A woodpecker toy, with or without how far it has slid down: that grows, and a return that was told from it would come after
/// thousands of turns.
#[test]
fn a_limit_cycle_is_found_where_something_drifts_with_it() {
    let found = |place: &str, begin: &str| {
        let jam = |name: &str, surface: &str| {
            format!(
                "[[event]]\nname = \"{name}\"\nsurface = \"{surface}\"\nreset = {{ w = \"0.9*w - 0.4*v\", v = 0 }}\n"
            )
        };
        let text = format!(
            "[flight]\np = \"w\"\nw = \"if(abs(p) > 0.3, -p - 0.12, -0.05*p)\"\nv = \"if(abs(p) > 0.3, 0, -1)\"\n{place}\
             [[contact]]\ngap = \"0.8 - p\"\nimpulse = {{ w = -1 }}\nrestitution = 0.5\n{}direction = \"rising\"\n{}\
             direction = \"falling\"\n[section.mid]\nsurface = \"p\"\ndirection = \"rising\"\n\
             [initial]\np = 0\nw = 0.5\nv = 0\n{begin}",
            jam("up", "p - 0.3"),
            jam("down", "p + 0.3"),
        );
        orbit(&with(&text, &[]))
    };
    let alone = found("", "");
    for place in ["z = \"1\"\n", "z = \"v\"\n"] {
        let beside = found(place, "z = 0\n");
        assert!(
            (beside.period - alone.period).to_f64().abs() < 1e-13,
            "{place}"
        );
        assert_eq!((beside.impacts, alone.impacts), (Some(1), Some(1)));
    }
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

/// A capsule: a mass on a spring in a box that friction holds, and a stop. It has drifted far before it settles.
const CAPSULE: &str = r#"
[parameters]
A = 0.8
w = 1.1
[flight]
x = "v"
v = "A*cos(w*t) - (x - y) - 0.1*(v - u)"
y = "u"
u = "((x - y) + 0.1*(v - u))/2 - 0.25*sign(u)"
[[contact]]
name = "stop"
gap = "0.3 - (x - y)"
impulse = { v = -1, u = "1/2" }
restitution = 0.5
[initial]
x = 0
v = 0
y = 0
u = 0
"#;

/// In the box's coordinates nothing drifts. The stop is touched where the flights of a motion integrated step by step, event by event, come down to
/// it, extrapolated to zero.
#[test]
fn what_has_drifted_far_has_the_branch_of_what_stays() {
    let resting = CAPSULE
        .replace("x = \"v\"", "z = \"v - u\"")
        .replace("y = \"u\"\n", "")
        .replace("(x - y)", "z")
        .replace("x = 0", "z = 0")
        .replace("y = 0\n", "");
    let branch = |text: &str| {
        let found = over(&with(text, &[]), "A", (0.4, 1.6), (4, 0.02));
        assert_eq!(found[0].ends, [End::Range, End::Range]);
        let special = found[0].special.iter();
        special.map(|s| (s.kind, value(s))).collect::<Vec<_>>()
    };
    let (one, other) = (branch(CAPSULE), branch(&resting));
    assert_eq!(one.len(), other.len(), "{one:?} {other:?}");
    for (one, other) in one.iter().zip(&other) {
        let off = (one.1 - other.1).abs();
        assert!(one.0 == other.0 && off < 1e-12, "{one:?} {other:?}");
    }
    let graze = one.iter().find(|special| special.0.is_graze()).unwrap();
    assert!((graze.1 - 1.494_607_6).abs() < 1e-6, "{graze:?}");
}

/// A part on a vibrating conveyor, which a period takes along by as much as it moves itself: told from where it begins to slip, the next
/// section is that much farther on. Stuck, it would slip where B |sin(t + ph)| reaches mu (1 - A sin t): for B as large as the least
/// quotient of both it touches that.
#[test]
fn what_drifts_is_told_from_another_event_as_far_on_as_it_is_then() {
    let found = over(
        &with(CONVEYED, &[("B", "0.12")]),
        "B",
        (0.12, 0.43),
        (4, 0.03),
    );
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    let touches: Vec<f64> = found[0].special.iter().map(value).collect();
    let expected = [0.139_011_379_590_337_85, 0.414_354_567_012_753_64];
    assert_eq!(touches.len(), expected.len(), "{touches:?}");
    for (touch, expected) in touches.iter().zip(expected) {
        assert!((touch - expected).abs() < 1e-14, "{touches:?}");
    }
}
