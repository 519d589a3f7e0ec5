//! Special points that lie on one curve in two parameters, which is listed once.

use super::plane::curve;
use super::{nearest, over, value, with};
use chatter::analysis::periodic::{Known, Limits, Point, Spec, Special, SpecialKind, goes_through};
use chatter::model::Model;

/// Whether a special point lies on a part of a curve.
pub(super) fn is_on(
    model: &Model,
    free: [&str; 2],
    special: &Special,
    (range, kind, points): ((f64, f64), SpecialKind, &[Point]),
) -> bool {
    let known = Known {
        kind: special.kind,
        monitor: special.monitor,
        state: special.point.state.clone(),
        period: special.point.period,
    };
    let mut model = model.clone();
    model
        .set_parameter(free[0], &format!("{:?}", value(special)))
        .unwrap();
    let free = free.map(|name| model.parameter_index(name).unwrap());
    let limits = Limits {
        range,
        other: None,
        impacts: 60,
        points: 3000,
        longest_step: 0.05,
    };
    let curve = (kind, points);
    goes_through(&model, &Spec::default(), (free, &known), &limits, curve).unwrap()
}

/// x'' + 0.8 x' + x = cos(w t) below the wall s: below the resonance the gap of the orbit without impacts closes, above it that opens. Both grazes are on the one curve
/// that the amplitude says, and its other orbits are not.
#[test]
fn grazes_of_both_names_are_on_one_curve() {
    let text = "[parameters]\ns = 1.2\nw = 0.6\n[flight]\nx = 'v'\nv = '-x - 0.8*v + cos(w*t)'\n[[contact]]\ngap = 's - x'\n\
                impulse = { v = -1 }\nrestitution = 0.7\n[initial]\nx = 1\nv = 0\n";
    let model = with(text, &[]);
    let found = over(&model, "w", (0.5, 1.1), (3, 0.1));
    // Where (1 - w^2)^2 + (0.8 w)^2 = 1/s^2.
    let root = (0.68_f64 * 0.68 - 1.0 + 1.0 / 1.44).sqrt();
    let [low, high] = [-root, root].map(|by| (0.68 + by).sqrt());
    let [closes, opens] = [
        (SpecialKind::FlightGraze, low),
        (SpecialKind::ImpactGraze, high),
    ]
    .map(|(kind, at)| nearest(&found, &[kind], at));
    assert!((value(&closes) - low).abs() < 1e-12, "{closes:?}");
    assert!((value(&opens) - high).abs() < 1e-12, "{opens:?}");
    let range = (1.15, 1.5);
    let grazes = curve(&model, ["w", "s"], &closes, (range, 0.1));
    let is_on = |special: &Special, points: &[Point]| {
        is_on(&model, ["w", "s"], special, (range, grazes.kind, points))
    };
    assert!(is_on(&closes, &grazes.points) && is_on(&opens, &grazes.points));
    let is_highest = |ways: &[Point]| ways[0].parameters[1] > ways[1].parameters[1];
    let before = grazes.points.windows(2).position(is_highest).unwrap();
    let [before, beyond] = [&grazes.points[..before], &grazes.points[before..]];
    let on = [&closes, &opens].map(|special| [before, beyond].map(|part| is_on(special, part)));
    assert!(
        on == [[true, false], [false, true]] || on == [[false, true], [true, false]],
        "{on:?}"
    );
}

/// Both folds beside the cusp of a spring with two slopes are on one curve, however far apart the points of it are.
#[test]
fn both_folds_are_on_one_curve_with_any_step() {
    let text = "[parameters]\nf = 0.4\nw = 0.6\n[flight]\nx = 'v'\nv = 'f*cos(w*t) - 0.1*v - x - 4*max(x - 0.3, 0)'\n\
                [section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0\nv = 0\n";
    let model = with(text, &[]);
    let found = over(&model, "w", (0.55, 0.65), (3, 0.02));
    let folds: Vec<&Special> = (found[0].special.iter())
        .filter(|special| special.kind == SpecialKind::Fold)
        .collect();
    assert_eq!(folds.len(), 2, "{:?}", found[0].special);
    let range = (0.1, 1.0);
    let curve = curve(&model, ["w", "f"], folds[0], (range, 0.05));
    for fold in &folds {
        let of = (range, curve.kind, &*curve.points);
        assert!(is_on(&model, ["w", "f"], fold, of), "{fold:?}");
    }
}
