//! Models with several release points in a period, and border orbits that a graze takes away.

use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::model::Model;

const TWO_HARMONICS: &str = r#"
[parameters]
g = 9.81
A = 0.001
omega = "40*pi"
r = 0.6
[definitions]
table = "A*(sin(omega*t) + 0.3*sin(2*omega*t + 0.7))"
[flight]
y = "v"
v = "-g"
[[contact]]
name = "table"
gap = "y - table"
impulse = { v = 1 }
restitution = "r"
[initial]
y = 0.01
v = 0
"#;

/// A table with a sharp hump that the flight after release passes at t = 1.19, the later ones high above it. The hump grows
/// with Gamma, so that flights with larger Gamma touch it.
const HUMP: &str = r#"
[parameters]
Gamma = 1.99
h = 0.0
r = 0.5
[definitions]
table = "Gamma*sin(t) + (h + 5*(Gamma - 1.992147953777344))*exp(400*(cos(t - 1.2) - 1))"
[flight]
y = "v"
v = "-1"
[[contact]]
name = "table"
gap = "y - table"
impulse = { v = 1 }
restitution = "r"
[initial]
y = 0.0
v = 0.0
"#;

/// Where the first border orbit of the table without hump is, and the height with which the hump touches it: the least
/// value of gap over exp(400 (cos(t - 1.2) - 1)), from thirty digits.
const FLAT_BORDER: f64 = 1.992_147_953_777_344;
const TOUCHING: f64 = 0.075_785_400_066_467_48;

fn hump(h: f64) -> Model {
    let mut model = Model::from_toml(HUMP, "hump").unwrap();
    model.set_parameter("h", &format!("{h:e}")).unwrap();
    model
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} {b}");
}

/// Borders from another program, found by bisection of the verdict: not from the first release point of the
/// period.
#[test]
fn borders_from_every_release_point_are_found() {
    let model = Model::from_toml(TWO_HARMONICS, "table").unwrap();
    let spec = BorderSpec::new("A");
    let verdicts = verdicts_in(&model, &spec, 0.000_92, 0.000_93).unwrap();
    assert_eq!(verdicts.len(), 2);
    let found = borders_in::<f64>(&model, &spec, 0.000_92, 0.000_93).unwrap();
    let [border] = &found.borders[..] else {
        panic!("{:?}", found.borders)
    };
    close(border.value.value, 9.259_397_458_339_88e-4, 2e-11);
    for near in [0.000_925_9, 0.000_926_5] {
        let again = border_near::<f64>(&model, &spec, near).unwrap();
        close(again.value.value, border.value.value, 1e-14);
        close(again.exact.slope.value, border.exact.slope.value, 1e-12);
    }
    let prediction = Prediction::exact(border).unwrap();
    let simulator = Simulator::new(&model, &spec, border).unwrap();
    let window = simulator.compare(&prediction, 12, 12)[0];
    let off = window.discrepancy(border.value.value).grazing.unwrap();
    assert!(off.abs() < 0.05, "{window:?}");
}

/// As long as the flight clears the hump, the border is that of the flat table.
#[test]
fn a_hump_that_is_not_touched_changes_nothing() {
    let spec = BorderSpec::new("Gamma");
    let flat = border_near::<f64>(&hump(0.0), &spec, FLAT_BORDER).unwrap();
    close(flat.value.value, FLAT_BORDER, 1e-15);
    for h in [0.5 * TOUCHING, TOUCHING * (1.0 - 1e-3)] {
        let border = border_near::<f64>(&hump(h), &spec, FLAT_BORDER).unwrap();
        close(border.value.value, FLAT_BORDER, 1e-15);
        close(border.exact.slope.value, flat.exact.slope.value, 1e-9);
    }
}

/// Once it is touched, complete chatter ends before the border, where the first impact is a graze.
#[test]
fn a_graze_of_the_first_impact_ends_the_search() {
    let spec = BorderSpec::new("Gamma");
    for excess in [1e-7, 1e-5, 1e-3] {
        let model = hump(TOUCHING * (1.0 + excess));
        let found = borders_in::<f64>(&model, &spec, 1.9915, 1.9922).unwrap();
        let first = |border: &&Border<f64>| border.first_impact.time > 4.0;
        assert_eq!(found.borders.iter().filter(first).count(), 0, "{excess}");
        let graze = |at: &&Break| matches!(at.cause, BreakCause::Graze { impact: 0, .. });
        let at = found.breaks.iter().find(graze);
        let at = at.unwrap_or_else(|| panic!("{excess}: {:?}", found.breaks));
        // d(touching height)/d(Gamma) = 0.15 on the flat table; the hump grows by 5.
        let expected = FLAT_BORDER - TOUCHING * excess / 4.85;
        close(at.value, expected, 1e-3 * excess + 1e-13);
    }
}

/// Chatter that leads from one release point to another is no border, and told as such.
#[test]
fn chatter_that_ends_at_another_release_point_is_told() {
    let model = hump(TOUCHING * (1.0 + 1e-5));
    let found = borders_in::<f64>(&model, &BorderSpec::new("Gamma"), 1.9915, 1.994).unwrap();
    let elsewhere = |at: &Break| at.cause == BreakCause::Elsewhere;
    assert!(found.breaks.iter().any(elsewhere), "{:?}", found.breaks);
}

/// Up to a rounding error of the border chatter is complete: rates that sink below rounding end it.
#[test]
fn chatter_is_complete_up_to_the_border() {
    let model = hump(0.0);
    let mut spec = BorderSpec::new("Gamma");
    spec.samples = 8;
    for decade in 3..11 {
        let off = 10f64.powi(-decade);
        let all = verdicts_in(&model, &spec, FLAT_BORDER - off, FLAT_BORDER - 0.5 * off).unwrap();
        let complete = |list: &&Vec<(f64, Verdict)>| {
            list.iter()
                .all(|(_, verdict)| *verdict == Verdict::Complete)
        };
        assert_eq!(all.iter().filter(complete).count(), 1, "{decade}: {all:?}");
    }
}
