//! Curves in two parameters where the force changes at a rate of zero beside a wall at rest, and where an impact comes or leaves at a corner of it.

use super::plane::{curve, of};
use super::{GRAZES, nearest, over, value, with};
use chatter::analysis::periodic::{End, Special, SpecialCurve, SpecialKind};
use chatter::model::Model;

/// A mass under drag or friction, and a wall.
fn beside_wall(drag: &str, set: &[(&str, &str)]) -> Model {
    let text = format!(
        "[parameters]\nb = 0.15\nw = 0.7\n[flight]\nx = 'v'\nv = 'cos(w*t) - x - 0.02*v - {drag}'\n[[contact]]\n\
         name = 'wall'\ngap = '0.8 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.6\n[section.s]\nsurface = 'sin(w*t)'\n\
         direction = 'rising'\n[initial]\nx = 0\nv = 0.1\n"
    );
    with(&text, set)
}

fn one(model: &Model, kinds: &[SpecialKind], (range, at): ((f64, f64), f64)) -> Special {
    let mut model = model.clone();
    let middle = 0.5 * (range.0 + range.1);
    model.set_parameter("w", &format!("{middle:?}")).unwrap();
    nearest(&over(&model, "w", range, (8, 0.05)), kinds, at)
}

/// Both parameters of an end of a curve.
fn end(curve: &SpecialCurve, high: bool) -> [f64; 2] {
    let last = |a: &[f64; 2], b: &[f64; 2]| a[1].total_cmp(&b[1]);
    let all = (curve.points.iter()).map(|point| [point.parameters[0], point.parameters[1]]);
    match high {
        true => all.max_by(last).unwrap(),
        false => all.min_by(last).unwrap(),
    }
}

/// Drag changes where the rate turns, which at a graze is at the wall: the flight ends there, and that is no second graze. In other units, too;
/// w at b = 0.1 and 0.2 is that of integrations in quadruple precision.
#[test]
fn a_curve_of_grazes_goes_on_where_drag_turns_with_the_rate() {
    for (length, per_time) in [(1.0, 1.0), (1e-3, 1e3), (1e3, 1e-2)] {
        let text = format!(
            "[parameters]\nb = 0.15\nw = {w:?}\nf = {f:?}\nk = {k:?}\nc = {c:?}\nq = {q:?}\nd = {d:?}\n[flight]\nx = 'v'\n\
             v = 'f*cos(w*t) - k*x - c*v - q*b*v*abs(v)'\n[[contact]]\nname = 'wall'\ngap = 'd - x'\nimpulse = {{ v = -1 }}\n\
             restitution = 0.6\n[initial]\nx = 0\nv = {v:?}\n",
            w = 0.7 * per_time,
            f = length * per_time * per_time,
            k = per_time * per_time,
            c = 0.02 * per_time,
            q = 1.0 / length,
            d = 0.8 * length,
            v = 0.1 * length * per_time,
        );
        let model = with(&text, &[]);
        let range = (0.69 * per_time, 0.72 * per_time);
        let graze = one(&model, &GRAZES, (range, 0.7065 * per_time));
        let found = curve(&model, ["w", "b"], &graze, ((0.1, 0.2), 0.05));
        assert_eq!(found.ends, [End::Range, End::Range]);
        assert!(found.special.is_empty(), "{:?}", found.special);
        assert!(found.points.len() < 60, "{}", found.points.len());
        for (high, w, b) in [(false, 0.71823, 0.1), (true, 0.69537, 0.2)] {
            let at = end(&found, high);
            assert!((at[1] - b).abs() < 1e-12, "{at:?}");
            assert!((at[0] / per_time - w).abs() < 1e-5, "{at:?}");
        }
        if length == 1.0 {
            let beside = with(&text, &[("b", "0.2")]);
            let graze = one(&beside, &GRAZES, ((0.69, 0.7), 0.695));
            assert!((end(&found, true)[0] - value(&graze)).abs() < 1e-10);
        }
    }
}

/// Dry friction holds the mass on the wall where the force at a graze would bring it back. That place, and where the graze turns into a fold,
/// are those of the closed form of the flights with mpmath.
#[test]
fn a_curve_of_grazes_tells_where_friction_holds_the_mass_on_the_wall() {
    let model = beside_wall("b*sign(v)", &[("b", "0.21")]);
    let graze = one(&model, &GRAZES, ((0.68, 0.69), 0.685));
    for step in [0.05, 0.02] {
        let found = curve(&model, ["w", "b"], &graze, ((0.2, 0.3), step));
        for (kind, w, b) in [
            (
                SpecialKind::Touch,
                0.565_459_110_627_417,
                0.263_555_477_509_503_76,
            ),
            (SpecialKind::GrazeFold, FOLD[0], FOLD[1]),
        ] {
            let all = of(&found, kind);
            assert_eq!(all.len(), 1, "{kind:?} {all:?}");
            let off = (all[0][0] - w).abs().max((all[0][1] - b).abs());
            assert!(off < 1e-11, "{kind:?} {all:?}");
        }
        // On from the touch, with the stick.
        assert_eq!(found.ends, [End::Range, End::Range]);
        assert!(found.points.len() < 200, "{}", found.points.len());
    }
}

/// w and b where the graze under dry friction turns into a fold.
const FOLD: [f64; 2] = [0.687_095_976_471_135_8, 0.207_028_840_379_446_76];

/// Where an impact loses its rate friction changes with it, and comes first: the curve of folds ends at its graze, whatever the steps.
#[test]
fn a_curve_of_folds_ends_at_the_graze_under_dry_friction() {
    let model = beside_wall("b*sign(v)", &[("b", "0.19")]);
    let fold = one(&model, &[SpecialKind::Fold], ((0.69, 0.75), 0.6979));
    for step in [0.05, 0.01] {
        let found = curve(&model, ["w", "b"], &fold, ((0.18, 0.3), step));
        assert!(
            found.ends.contains(&End::At(SpecialKind::GrazeFold)),
            "{:?}",
            found.ends
        );
        let all = of(&found, SpecialKind::GrazeFold);
        assert_eq!(all.len(), 1);
        let off = (all[0][0] - FOLD[0]).abs().max((all[0][1] - FOLD[1]).abs());
        assert!(off < 1e-10, "{all:?}");
    }
}

/// Friction about zero with corners at v = 0.2 and -0.2: the other impact leaves with -0.2 at b = 0.1616, and comes with 0.2 at b = 0.0749, where nothing
/// happens. At b = 0.07 w is that of integrations in quadruple precision.
#[test]
fn a_curve_of_grazes_goes_on_where_another_impact_is_at_a_corner() {
    let drag = "b*clamp(v/0.2, -1, 1)";
    let model = beside_wall(drag, &[]);
    let graze = one(&model, &GRAZES, ((0.47, 0.48), 0.4746));
    let found = curve(&model, ["w", "b"], &graze, ((0.07, 0.17), 0.05));
    assert_eq!(found.ends, [End::Range, End::Range]);
    assert!(found.special.is_empty(), "{:?}", found.special);
    let (low, high) = (end(&found, false), end(&found, true));
    assert!((low[0] - 0.477_747_2).abs() < 1e-7, "{low:?}");
    let beside = beside_wall(drag, &[("b", "0.17")]);
    let graze = one(&beside, &GRAZES, ((0.47, 0.48), high[0]));
    assert!((high[0] - value(&graze)).abs() < 1e-10, "{high:?}");
}

/// Friction that jumps at v = 0.3: the derivative of the orbit does where the other impact comes with that rate, which is told, at one place
/// whatever the steps.
#[test]
fn a_jump_of_friction_at_another_impact_is_told() {
    let model = beside_wall("b*sign(v - 0.3)", &[("b", "0.1")]);
    let graze = one(&model, &GRAZES, ((0.48, 0.52), 0.5));
    let touches = [0.05, 0.02].map(|step| {
        let found = curve(&model, ["w", "b"], &graze, ((0.07, 0.12), step));
        assert_eq!(found.ends, [End::Range, End::Range]);
        let all = of(&found, SpecialKind::Touch);
        assert_eq!(all.len(), 1, "{all:?}");
        all[0]
    });
    let off = touches[0].iter().zip(&touches[1]);
    assert!(off.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) < 1e-12);
}

/// Johnson's restitution is bounded from above for slow impacts: which piece holds at no rate at all changes nothing.
#[test]
fn a_curve_of_grazes_asks_nothing_of_a_restitution_at_no_rate() {
    let text = "[parameters]\nb = 0.15\nw = 0.7\n[flight]\nx = 'v'\nv = 'cos(w*t) - x - 0.02*v - b*v'\n[[contact]]\nname = 'wall'\n\
                gap = '0.8 - x'\nimpulse = { v = -1 }\nrestitution = 'min(0.9, 0.6*abs(v)^(-0.25))'\n[initial]\nx = 0\nv = 0.1\n";
    let graze = |b: &str| {
        let found = over(
            &with(text, &[("b", b), ("w", "1.0")]),
            "w",
            (0.7, 1.05),
            (8, 0.05),
        );
        nearest(&found, &GRAZES, 0.71)
    };
    let found = curve(
        &with(text, &[]),
        ["w", "b"],
        &graze("0.15"),
        ((0.14, 0.16), 0.05),
    );
    assert_eq!(found.ends, [End::Range, End::Range]);
    assert!(found.special.is_empty(), "{:?}", found.special);
    let off = end(&found, true)[0] - value(&graze("0.16"));
    assert!(off.abs() < 1e-10, "{off:e}");
}
