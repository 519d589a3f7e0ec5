//! Friction whose sliding turns in flight, where nothing happens.

use crate::periodic::{orbit, over, value, with};
use chatter::analysis::periodic::{Branch, End, SpecialKind};
use chatter::numerics::Real;
use core::f64::consts::PI;

/// A part on a shaken plate that friction stops at each impact, c = pi (1 - r)/(1 + r) being the plate's rate where it bounces once a period; from its flight up
/// to the first section on.
const CONVEYOR: &str = r#"
[parameters]
G = 2.6
r = 0.2
c = "pi*(1 - r)/(1 + r)"
d = "acos(c/G)"
[flight]
u = "0"
y = "v"
v = "-1"
[[contact]]
name = "plate"
gap = "y - G*sin(t)"
impulse = { v = 1 }
restitution = "r"
friction = { coefficient = 0.4, along = { u = 1 }, rate = "u - 2*G*cos(t)" }
[section.s]
surface = "sin(t)"
direction = "rising"
"#;

fn kinds(branch: &Branch) -> Vec<(SpecialKind, f64)> {
    let special = branch.special.iter();
    special.map(|s| (s.kind, value(s))).collect()
}

fn agrees(found: &[(SpecialKind, f64)], expected: &[(SpecialKind, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((kind, at), (expected, value)) in found.iter().zip(expected) {
        assert_eq!(kind, expected, "{found:?}");
        assert!((at - value).abs() < 1e-13 * value, "{at} {value}");
    }
}

/// It bounces as though there were no friction, in closed form: with two periods of the plate each orbit comes back at sqrt(c^2 + (2 (1 + r^2)/(1 + r)^2)^2), with one
/// the first fold is where c is the plate's greatest rate. The graze is that of its flight with 30 digits. At each impact friction stops the sliding, and that
/// of the simple orbit is zero there already.
#[test]
fn a_part_that_friction_stops_bounces_as_without_it() {
    let doubling = (2.0 * PI / 3.0).hypot(2.0 * 1.04 / 1.44);
    let simple = "[initial]\nu = \"2*c\"\ny = \"pi*(2*pi - d) - (2*pi - d)^2/2 + sqrt(G^2 - c^2)\"\nv = \"d - pi\"\n";
    for step in [0.1, 0.03] {
        let model = with(&format!("{CONVEYOR}{simple}"), &[("G", "2.12")]);
        let found = over(&model, "G", (2.09, 2.66), (1, step));
        assert_eq!(found[0].ends, [End::Impacts(1), End::Range], "{step}");
        let expected = [
            (SpecialKind::FlightGraze, 2.639_354_167_600_482),
            (SpecialKind::Fold, 2.0 * PI / 3.0),
            (SpecialKind::PeriodDoubling, doubling),
        ];
        agrees(&kinds(&found[0]), &expected);
    }
    let doubled = "[initial]\nu = 0\ny = 10\nv = 0\n";
    for step in [0.1, 0.03] {
        let model = with(&format!("{CONVEYOR}{doubled}"), &[]);
        let found = over(&model, "G", (2.5, 4.0), (2, step));
        let expected = [
            (SpecialKind::BranchPoint, doubling),
            (SpecialKind::PeriodDoubling, 2.732_235_534_912_634_3),
        ];
        agrees(&kinds(&found[0]), &expected);
        assert_eq!(found[0].ends[1], End::Range, "{step}");
    }
}

const PLATE: &str = r#"
[[contact]]
name = "plate"
gap = "y"
impulse = { v = 1 }
restitution = 0
friction = { coefficient = 0.5, along = { u = 1 }, rate = "u - G*cos(t)" }
"#;
const COVER: &str = r#"
[[contact]]
name = "cover"
gap = "1 - y"
impulse = { v = -1 }
restitution = 0
friction = { coefficient = 0.5, along = { u = 1 }, rate = "u - G*cos(t)" }
"#;

/// A block that sticks to its plate and slips, under a cover which moves with the plate and which it never touches: both slide at one rate, and that it vanishes is
/// an event at the plate, whichever is named first. In closed form: it slips from where G sin(t) = 1/2 until its rate, which falls by 1/2, is that of the plate.
#[test]
fn what_slides_at_the_rate_of_a_contact_in_flight_sticks() {
    let (begin, rest) = (
        "[parameters]\nG = 0.8\n[flight]\nu = 0\ny = \"v\"\nv = \"-1\"\n",
        "[section.s]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n[initial]\nu = 0\ny = 0\nv = 0\n",
    );
    let slips = (0.5_f64 / 0.8).asin();
    let expected = (PI - slips) * 0.5 - 0.8 * slips.cos();
    for (one, other) in [(PLATE, COVER), (COVER, PLATE)] {
        let found = orbit(&with(&format!("{begin}{one}{other}{rest}"), &[]));
        let own = found.start[0].to_f64();
        assert!((own - expected).abs() < 1e-14, "{own} {expected}");
    }
}
