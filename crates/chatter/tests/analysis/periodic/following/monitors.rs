//! Functions of the user's that are watched along branches.

use crate::periodic::{branch_spec, with};
use chatter::analysis::periodic::{Beside, Spec, SpecialKind, Told, branches};
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
