//! Where branches meet each is left along the other; and what stays on the unit circle passes it nowhere.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, Point, SpecialKind};

/// An oscillator without damping: its multipliers are exp(+-2 pi i/omega).
const FREE: &str = r#"
[parameters]
omega = 2.5
[flight]
x = "v"
v = "-x + cos(omega*t)"
[section.strobe]
surface = "sin(omega*t)"
direction = "rising"
[initial]
x = -0.1904761904761905
v = 0
"#;

#[test]
fn a_pair_that_stays_on_the_unit_circle_does_not_pass_it() {
    let found = over(&with(FREE, &[]), "omega", (2.2, 3.0), (10, 0.02));
    let [branch] = &*found else {
        panic!("{} branches", found.len());
    };
    assert!(branch.special.is_empty(), "{:?}", branch.special[0]);
    assert!(branch.points.len() > 30);
    assert!(branch.points.iter().all(Point::is_neutral));
    assert!(!branch.points.iter().any(Point::is_stable));
}

/// The same with a stop at the equilibrium that takes no energy. The orbit is its own image under the reversal of time.
const ELASTIC: &str = r#"
[parameters]
omega = 2.3
[flight]
x = "v"
v = "-x + cos(omega*t)"
[[contact]]
name = "stop"
gap = "-x"
impulse = { v = -1 }
restitution = 1
[section.strobe]
surface = "sin(omega*t)"
direction = "rising"
[initial]
x = -1.3788035701646943
v = 0
"#;

#[test]
fn a_pair_that_rounding_takes_off_the_unit_circle_does_not_pass_it() {
    for step in [0.03, 0.04] {
        let found = over(&with(ELASTIC, &[]), "omega", (2.02, 3.99), (10, step));
        let [branch, ..] = &*found else {
            panic!("no branch");
        };
        let is_told = |kind: SpecialKind| branch.special.iter().any(|s| s.kind == kind);
        assert!(is_told(SpecialKind::PeriodDoubling), "{step}");
        assert!(!is_told(SpecialKind::NeimarkSacker), "{step}");
    }
}

/// Iterates a map by a clock.
fn map(image: &str, start: f64) -> String {
    format!(
        r#"
[parameters]
a = 0.7
[flight]
x = "0"
s = "1"
[[event]]
name = "tick"
surface = "s - 1"
direction = "rising"
reset = {{ x = "{image}", s = "0" }}
[section.mid]
surface = "s - 0.5"
direction = "rising"
[initial]
x = {start}
s = 0
"#
    )
}

fn kinds(branch: &Branch) -> Vec<(SpecialKind, f64)> {
    let told = |special| (value(special) * 1e9).round() / 1e9;
    (branch.special.iter())
        .map(|special| (special.kind, told(special)))
        .collect()
}

/// The logistic map shifted by 1, from both of its fixed points: each is of one side of a = 1, where they exchange their stability.
#[test]
fn at_a_transcritical_point_either_branch_leads_to_the_other() {
    use SpecialKind::{BranchPoint, PeriodDoubling};
    let text = map("1 + a*(x - 1)*(2 - x)", 1.5);
    for a in ["2.5", "0.7"] {
        let found = over(&with(&text, &[("a", a)]), "a", (0.5, 3.5), (10, 0.05));
        let [one, other] = &*found else {
            panic!("{} branches", found.len());
        };
        let curved = vec![(BranchPoint, 1.0), (PeriodDoubling, 3.0)];
        let (straight, curved) = match kinds(one) == curved {
            true => (other, one),
            false => (one, other),
        };
        assert_eq!(kinds(straight), [(BranchPoint, 1.0)]);
        for point in &straight.points {
            assert!((point.state[0] - 1.0).abs() < 1e-12);
        }
        for point in &curved.points {
            let right = 2.0 - 1.0 / point.parameter();
            assert!((point.state[0] - right).abs() < 1e-11);
        }
    }
}

/// x = 0 and x^2 = a - 1, each from the other.
#[test]
fn at_a_pitchfork_steps_have_the_sizes_of_the_whole_system() {
    let text = map("a*x - x^3", 0.0);
    let found = over(&with(&text, &[]), "a", (0.5, 3.5), (10, 0.05));
    let [trunk, arms] = &*found else {
        panic!("{} branches", found.len());
    };
    assert!(trunk.points.iter().all(|point| point.state[0] == 0.0));
    assert!(arms.points.len() < 300, "{}", arms.points.len());
    for end in [arms.points.first(), arms.points.last()] {
        assert_eq!(end.unwrap().parameter(), 3.5);
    }
    let from_arm = with(&map("a*x - x^3", 0.7), &[("a", "1.5")]);
    let found = over(&from_arm, "a", (0.5, 3.5), (10, 0.05));
    let [arms, trunk] = &*found else {
        panic!("{} branches", found.len());
    };
    assert!(arms.points.iter().all(|p| p.parameter() >= 1.0 - 1e-12));
    assert!(
        trunk
            .points
            .iter()
            .all(|point| point.state[0].abs() < 1e-12)
    );
}

/// Iterates a map of two states by a clock.
fn map_of_two(x: &str, y: &str, start: (f64, f64)) -> String {
    let text = map(x, start.0).replace("x = \"0\"\n", "x = \"0\"\ny = \"0\"\n");
    let text = text.replace("reset = { ", &format!("reset = {{ y = \"{y}\", "));
    text.replace("[initial]\n", &format!("[initial]\ny = {}\n", start.1))
}

fn of_kind(branches: &[Branch], kind: SpecialKind) -> Vec<f64> {
    let all = (branches[0].special.iter()).filter(|special| special.kind == kind);
    all.map(value).collect()
}

/// Of two logistic maps, one of which drives the other, each doubles, within one step or at once. The product of signs is the same at both ends
/// of a step.
#[test]
fn multipliers_that_pass_minus_one_within_a_step_are_told_each() {
    for share in [1.001, 1.0 + 1e-6, 1.0] {
        let y = format!("{share:?}*a*y*(1 - y) + 0.001*(x - 1 + 1/a)");
        let text = map_of_two("a*x*(1 - x)", &y, (0.6, 0.6));
        for step in [0.05, 0.02] {
            let found = over(&with(&text, &[("a", "2.5")]), "a", (2.2, 3.2), (10, step));
            let doublings = of_kind(&found, SpecialKind::PeriodDoubling);
            let expected = [3.0 / share, 3.0];
            assert_eq!(doublings.len(), 2, "{share} {step}: {doublings:?}");
            for (found, expected) in doublings.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{share} {step}: {doublings:?}"
                );
            }
            // Both maps double as a grows; where they do so at once, it is not said which.
            let sides = found[0].special.iter().map(|special| special.above);
            let are_above = |mut sides: Vec<Option<bool>>| {
                sides.dedup();
                sides == [Some(true)]
            };
            let sides = sides.collect();
            assert!(share == 1.0 || are_above(sides), "{share} {step}");
            assert_eq!(
                kinds(&found[0]).len(),
                2,
                "{share} {step}: {:?}",
                kinds(&found[0])
            );
        }
    }
}

/// The same of two pitchforks: the determinant has the same sign at both ends of a step.
#[test]
fn multipliers_that_pass_one_within_a_step_are_told_each() {
    for share in [1.001, 1.0 + 1e-6] {
        let y = format!("{share:?}*a*y - y^3 + 0.001*x");
        let text = map_of_two("a*x - x^3", &y, (0.0, 0.0));
        for step in [0.05, 0.02] {
            let found = over(&with(&text, &[("a", "0.7")]), "a", (0.5, 1.4), (10, step));
            let points = of_kind(&found, SpecialKind::BranchPoint);
            let expected = [1.0 / share, 1.0];
            assert_eq!(points.len(), 2, "{share} {step}: {points:?}");
            for (found, expected) in points.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-11,
                    "{share} {step}: {points:?}"
                );
            }
        }
    }
    let text = map_of_two("a*x - x^3", "a*y - y^3", (0.0, 0.0));
    let found = over(&with(&text, &[("a", "0.7")]), "a", (0.5, 1.4), (10, 0.05));
    let points = of_kind(&found, SpecialKind::BranchPoint);
    assert!(!points.is_empty(), "{:?}", found[0].special);
    assert!(
        points.iter().all(|point| (point - 1.0).abs() < 1e-11),
        "{points:?}"
    );
}

/// One multiplier goes in as another goes out within a step, over -1 and over 1: as many are beyond at both ends of it. Of the two maps the one
/// passes at a = 3, or 1, and the other, whose slope falls with that of the first, a share earlier.
#[test]
fn one_that_goes_in_as_another_goes_out_is_told() {
    for (share, step) in [(1.01, 0.3), (1.0 + 1e-6, 0.1)] {
        let doubles = map_of_two(
            "a*x*(1 - x)",
            &format!("(6 - {share:?}*a)*y*(1 - y) + 0.001*(x - 1 + 1/a)"),
            (0.6, 0.6),
        );
        let meets = map_of_two(
            "a*x - x^3",
            &format!("(2 - {share:?}*a)*y - y^3 + 0.001*x"),
            (0.0, 0.0),
        );
        let ways = [
            // From the fixed point itself, though it be unstable.
            (
                doubles
                    .replace("x = 0.6\n", "x = \"1 - 1/a\"\n")
                    .replace("y = 0.6\n", &format!("y = \"1 - 1/(6 - {share:?}*a)\"\n")),
                "2.95",
                (2.9, 3.1),
                SpecialKind::PeriodDoubling,
            ),
            (meets, "0.95", (0.9, 1.1), SpecialKind::BranchPoint),
        ];
        for (text, start, range, kind) in ways {
            let last = if kind == SpecialKind::PeriodDoubling {
                3.0
            } else {
                1.0
            };
            let found = over(&with(&text, &[("a", start)]), "a", range, (10, step));
            let told = of_kind(&found, kind);
            let context = format!("{share} {step}: {told:?} {:?}", kinds(&found[0]));
            assert_eq!(told.len(), 2, "{context}");
            for (found, expected) in told.iter().zip([last / share, last]) {
                assert!((found - expected).abs() < 1e-11, "{context}");
            }
        }
    }
}
