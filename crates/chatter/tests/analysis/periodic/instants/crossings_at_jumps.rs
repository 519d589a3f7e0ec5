//! A surface that is crossed just after a jump, or just before one that takes the state off it: the crossing goes out and comes in there.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, End, SpecialKind};

/// The way of x from a clock's tick, which maps it, to the next.
fn ticked(rate: &str, map: &str) -> String {
    format!(
        "[parameters]\np = 0.4\n[table.drag]\nx = [-3, -1, 0, 1, 3]\ny = [-0.5, -0.2, 0, 0.4, 1]\n[flight]\nx = \"{rate}\"\nc = \"1\"\n\
        [[event]]\nname = \"tick\"\nsurface = \"c - 1\"\nreset = {{ c = \"0\", x = \"{map}\" }}\n[initial]\nx = 0.3\nc = 0\n"
    )
}

fn touches(branch: &Branch) -> Vec<f64> {
    let touches = (branch.special.iter()).inspect(|s| assert_eq!(s.kind, SpecialKind::Touch));
    let mut all: Vec<f64> = touches.map(value).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// With f the way over a unit of time, x = p + a f(x) begins or ends at the surfaces where p is x - a f(x) for an x of which x or f(x) is there. They are told
/// from below, from above and from between, at all steps.
#[test]
fn a_crossing_goes_out_where_a_jump_leads_just_onto_its_surface_or_just_off_it() {
    // From 1.5 zero is reached at the tick.
    let sides = ("-1 - 0.5*sign(x)", "p + 0.3*x", vec![0.15, 1.5]);
    // Rates of -0.8, -1.1, -1.4 and -1.7 from -2, -1, 0 and 1 on: x is 0 or 1, or comes to -1 or 0 at the tick.
    let late = |x: f64, rate: f64| x * (1.0 - 1.0 / rate);
    let pieces = (
        "-1.4 - 0.3*floor(x)",
        "p + 0.2*x",
        vec![
            0.2 + 0.2 * late(0.8, 1.1),
            late(1.4, 1.1) + 0.2,
            1.0 + 0.2 * late(1.1, 1.4),
            1.0 + late(1.7, 1.4),
        ],
    );
    for (rate, map, expected) in [sides, pieces] {
        let text = ticked(rate, map);
        for (start, step) in [("-0.3", 0.1), ("0.4", 0.02), ("1.45", 0.1)] {
            let found = over(&with(&text, &[("p", start)]), "p", (-0.5, 1.55), (4, step));
            let branch = &found[0];
            assert_eq!(branch.ends, [End::Range, End::Range], "{rate} {start}");
            let known = touches(branch);
            assert_eq!(known.len(), expected.len(), "{rate} {start} {known:?}");
            for (known, expected) in known.iter().zip(&expected) {
                assert!((known - expected).abs() < 1e-14, "{rate} {start} {known}");
            }
            assert!(branch.special.iter().all(|s| s.persists == Some(true)));
        }
    }
}

/// At the knot of a table, and where a spring begins to push, fields go on as they are.
#[test]
fn nothing_is_told_where_a_jump_leads_onto_a_surface_and_the_field_goes_on_as_it_is() {
    for rate in ["-1.5 - drag(x)", "-1.5 - max(0, x)"] {
        let text = ticked(rate, "p + 0.3*x");
        for start in ["-0.3", "0.4", "1.7"] {
            let found = over(&with(&text, &[("p", start)]), "p", (-0.5, 1.8), (4, 0.1));
            let branch = &found[0];
            assert_eq!(branch.ends, [End::Range, End::Range], "{rate} {start}");
            assert!(branch.special.is_empty(), "{rate} {:?}", branch.special);
        }
    }
}

/// From x > 0 the orbit is x = (p + 0.09)/0.7, from below (p - 0.03)/0.7.
#[test]
fn a_branch_ends_where_a_jump_leads_onto_a_surface_that_the_field_leaves_to_both_sides() {
    let text = ticked("0.1 + 0.2*sign(x)", "p + 0.3*x");
    for (start, end, side) in [("0.4", -0.09, 0), ("-0.4", 0.03, 1)] {
        for step in [0.1, 0.01] {
            let found = over(&with(&text, &[("p", start)]), "p", (-0.5, 0.5), (4, step));
            let branch = &found[0];
            let known = touches(branch);
            assert_eq!(known.len(), 1, "{start} {known:?}");
            assert!((known[0] - end).abs() < 1e-15, "{start} {known:?}");
            let why = branch.ends[side].to_string();
            assert!(why.contains("away from there to both sides"), "{why}");
            assert_eq!(branch.ends[1 - side], End::Range);
        }
    }
}

/// An oscillator under the control of a relay meets a stop. Where the impact leads just onto the surface of the relay the branch turns back, with one
/// crossing more. The place, and that of the fold beyond it, from the closed form of each part of the way, in thirty digits.
#[test]
fn a_branch_turns_back_where_an_impact_leads_just_onto_a_surface() {
    let text = "[parameters]\nw = 1.1\n[flight]\nx = \"v\"\nv = \"-x - 0.06*v + 0.8*cos(w*t) - 0.5*sign(v + 0.4*x)\"\n[[contact]]\n\
        name = \"stop\"\ngap = \"0.8 - x\"\nimpulse = { v = -1 }\nrestitution = 0.7\n[section.strobe]\nsurface = \"sin(w*t)\"\n\
        direction = \"rising\"\n[initial]\nx = 0.3\nv = 0\n";
    for (start, step) in [("1.1", 0.1), ("1.4", 0.1), ("1.1", 0.02)] {
        let found = over(&with(text, &[("w", start)]), "w", (1.05, 1.45), (4, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start}");
        let at = |kind: SpecialKind, expected: f64| {
            let mut all = branch.special.iter().filter(|s| s.kind == kind);
            let near = all.find(|s| (value(s) - expected).abs() < 1e-13);
            near.unwrap_or_else(|| panic!("{start} {:?}", branch.special))
        };
        let touch = at(SpecialKind::Touch, 1.338_845_980_478_316);
        assert_eq!(touch.persists, Some(false));
        at(SpecialKind::Fold, 1.340_397_757_062_601_8);
    }
}
