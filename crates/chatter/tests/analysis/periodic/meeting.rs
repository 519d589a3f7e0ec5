//! Where branches meet each is left along the other; and what stays on the unit circle passes it nowhere.

use super::{over, value, with};
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
