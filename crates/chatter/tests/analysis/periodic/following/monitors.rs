//! Functions of the user's that are watched along branches.

use crate::periodic::{branch_spec, model, value, with};
use chatter::analysis::periodic::{
    Beside, End, Known, Limits, Spec, Special, SpecialKind, Told, branches, special_curve,
};
use chatter::model::Model;
use std::ops::ControlFlow;

/// A mass between two walls, told from where it passes the middle, or at a phase of its force.
const TWO_WALLS: &str = r#"
[parameters]
d1 = 0.6
[flight]
x = "L*v/T"
v = "(1.394*cos(1.331*t/T) - 2*0.07852*v - x/L)/T"
[[contact]]
name = "right"
gap = "d1*L - x"
impulse = { v = -1 }
restitution = 0.5949
[[contact]]
name = "left"
gap = "0.9705*L + x"
impulse = { v = 1 }
restitution = 0.5026
[section.strobe]
surface = "sin(1.331*t/T)"
direction = "rising"
[section.mid]
surface = "x"
direction = "rising"
[initial]
x = 0
v = 0.4
"#;

/// The values of the parameter at which a function is told to vanish.
fn zeros(model: &Model, section: &str, function: &str) -> Vec<f64> {
    let spec = Spec {
        section: model
            .sections
            .iter()
            .position(|known| known.name == section),
        monitors: vec![function.to_owned()],
        ..Spec::default()
    };
    let beside = Beside {
        doublings: 0,
        branch_points: 0,
    };
    let over = branch_spec(model, ("d1", (0.4, 1.2)), (8, 0.02), beside);
    let mut quiet = |_: Told<'_>| ControlFlow::Continue(());
    let found = branches(model, &spec, &over, Vec::new(), &mut quiet).unwrap();
    let special = found.iter().flat_map(|branch| &branch.special);
    special
        .filter(|special| special.kind == SpecialKind::Monitor)
        .map(|special| *special.point.parameters.last().unwrap())
        .collect()
}

/// A function that is zero wherever it is told changes its sign by rounding, which is no zero of it; another one is found where it is, in all units.
#[test]
fn what_vanishes_on_the_section_has_no_zeros_there() {
    let mut known: Option<Vec<f64>> = None;
    for (length, time) in [(1.0, 1.0), (1e3, 1e-3), (1e-3, 1e3)] {
        let text = TWO_WALLS
            .replace('L', &format!("{length:?}"))
            .replace('T', &format!("{time:?}"));
        let model = with(&text, &[]);
        assert_eq!(zeros(&model, "mid", "x"), [0.0; 0]);
        assert_eq!(
            zeros(&model, "strobe", &format!("sin(1.331*t/{time:?})")),
            [0.0; 0]
        );
        let found = zeros(&model, "mid", "v - 1.05");
        assert!(!found.is_empty());
        let before = known.get_or_insert_with(|| found.clone());
        assert_eq!(before.len(), found.len());
        assert!(
            before
                .iter()
                .zip(&found)
                .all(|(a, b)| (a - b).abs() < 1e-10)
        );
    }
}

/// The zero of a function of gears with play along the branch of one step.
fn zero_of(gears: &Model, spec: &Spec, step: f64) -> Special {
    let over = branch_spec(
        gears,
        ("omega", (1.38, 1.405)),
        (8, step),
        Beside::default(),
    );
    let mut quiet = |_: Told<'_>| ControlFlow::Continue(());
    let found = branches(gears, spec, &over, Vec::new(), &mut quiet).unwrap();
    let special = found.into_iter().flat_map(|branch| branch.special);
    let mut zeros = special.filter(|special| special.kind == SpecialKind::Monitor);
    let zero = zeros.next().expect("a zero");
    assert!(zeros.next().is_none());
    zero
}

/// A function that vanishes just where the play of gears ends does so where that is crossed at the section. This is known to rounding, and its curve in two
/// parameters goes through the zeros on branches with the other one held.
#[test]
fn a_function_that_vanishes_on_a_surface_has_its_zeros_at_the_section() {
    let spec = Spec {
        monitors: vec!["x - backlash".to_owned()],
        ..Spec::default()
    };
    let gears = |mean: &str| model("gear_backlash", &[("omega", "1.39"), ("mean", mean)]);
    let own = gears("0.1");
    let zeros = [0.01, 0.02, 0.05, 0.1].map(|step| zero_of(&own, &spec, step));
    for zero in &zeros {
        let off = value(zero) - value(&zeros[0]);
        assert!(
            off.abs() < 1e-14 && zero.error < 1e-14,
            "{off} {}",
            zero.error
        );
        assert!(
            (zero.point.state[0] - 1.0).abs() < 1e-14,
            "{:?}",
            zero.point
        );
    }
    let known = Known {
        kind: SpecialKind::Monitor,
        monitor: zeros[0].monitor,
        state: zeros[0].point.state.clone(),
        period: zeros[0].point.period,
    };
    let limits = Limits {
        range: (1.39, 1.401),
        other: None,
        impacts: 8,
        points: 200,
        longest_step: 0.05,
    };
    let mut there = own.clone();
    let at = format!("{:?}", value(&zeros[0]));
    there.set_parameter("omega", &at).unwrap();
    let free = ["mean", "omega"].map(|name| there.parameter_index(name).unwrap());
    let mut quiet = |_: Told<'_>| ControlFlow::Continue(());
    let curve = special_curve(
        &there,
        &spec,
        (free, &known),
        &limits,
        Vec::new(),
        &mut quiet,
    );
    let curve = curve.unwrap();
    assert_eq!(curve.ends, [End::Range, End::Range]);
    assert!(curve.points.len() > 10);
    for point in &curve.points {
        assert!(point.monitors[0].abs() < 1e-13, "{:?}", point.parameters);
    }
    for point in [&curve.points[2], &curve.points[curve.points.len() - 3]] {
        let [mean, omega] = point.parameters[..] else {
            panic!("{:?}", point.parameters);
        };
        let other = zero_of(&gears(&format!("{mean:?}")), &spec, 0.05);
        let off = value(&other) - omega;
        assert!(off.abs() < 1e-13, "{mean} {off}");
    }
}
