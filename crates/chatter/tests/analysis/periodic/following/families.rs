//! Families of orbits at one value of the parameter: where a system is linear along its orbit, doubled orbits of all sizes leave at a doubling, up to
//! where they come to what is not linear.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// A gear whose teeth stay in mesh along its orbit: displacements obey x'' + 0.08 x' + (1 + cos(omega t)/4) x = 0.
const GEAR: &str = r#"
[parameters]
omega = 1.8
[flight]
x = "v"
v = "0.2 + 0.15*cos(omega*t + 0.4) - 0.08*v - (1 + 0.25*cos(omega*t))*(x - clamp(x, -0.5, 0.5))"
[section.strobe]
surface = "sin(omega*t)"
direction = "rising"
[initial]
x = 0.8
v = 0
"#;

/// Where that has a multiplier of -1, by Hill's determinant.
const DOUBLINGS: [f64; 2] = [1.900_545_855_446_418_2, 2.092_426_137_061_239_2];

/// Doubled orbits are on no side of a doubling where all of them are at its value.
#[test]
fn a_doubling_of_a_linear_map_has_no_side() {
    for (start, step) in [("1.8", 0.05), ("2.15", 0.05), ("1.7", 0.03)] {
        let found = over(
            &with(GEAR, &[("omega", start)]),
            "omega",
            (1.6, 2.2),
            (4, step),
        );
        let special = &found[0].special;
        assert_eq!(special.len(), 2, "{start} {step}");
        for (special, at) in special.iter().zip(DOUBLINGS) {
            assert_eq!(
                (special.kind, special.above),
                (SpecialKind::PeriodDoubling, None)
            );
            assert!((value(special) - at).abs() < 1e-12);
        }
    }
}

/// The branch of doubled orbits goes up the family at one doubling, to where an orbit comes to the end of the mesh, and from there on to the family at
/// the other one, and down it. On neither does it fold, and neither is gone on from in a direction of the parameter.
#[test]
fn a_family_ends_at_the_simple_orbit_and_at_a_touch() {
    for (start, step) in [("2.0", 0.07), ("1.95", 0.1)] {
        let found = over(
            &with(GEAR, &[("omega", start)]),
            "omega",
            (1.6, 2.2),
            (4, step),
        );
        let branch = &found[0];
        let again = End::Again(SpecialKind::BranchPoint);
        assert_eq!(branch.ends, [again.clone(), again], "{start} {step}");
        let kinds: Vec<_> = branch.special.iter().map(|s| s.kind).collect();
        let touches: Vec<_> = branch
            .special
            .iter()
            .filter(|s| s.kind == SpecialKind::Touch)
            .collect();
        let folds = kinds
            .iter()
            .filter(|kind| **kind == SpecialKind::Fold)
            .count();
        assert_eq!((touches.len(), folds), (2, 1), "{start} {step}: {kinds:?}");
        let mut places: Vec<f64> = touches.iter().map(|s| value(s)).collect();
        places.sort_by(f64::total_cmp);
        for (place, at) in places.iter().zip(DOUBLINGS) {
            assert!((place - at).abs() < 1e-12);
        }
        assert!(touches.iter().all(|touch| touch.persists.is_none()));
    }
}

/// An oscillator without damping at mu = 0, where orbits of all sizes up to the stop are periodic. What is zero there says nothing of how far rounding
/// of the parameter may go: nowhere along the family is a fold.
#[test]
fn a_family_at_zero_does_not_fold() {
    let text = "[parameters]\nmu = 0.3\n[flight]\nx = \"v\"\nv = \"mu*(1 - x^2)*v - x\"\n[[contact]]\nname = \"stop\"\n\
        gap = \"1.4 - x\"\nimpulse = { v = -1 }\nrestitution = 0.8\n[section.mid]\nsurface = \"x\"\n\
        direction = \"rising\"\n[initial]\nx = 0.5\nv = 0\n";
    for step in [0.1, 0.03] {
        let found = over(&with(text, &[]), "mu", (-0.3, 1.0), (8, step));
        let kinds: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
        assert!(!kinds.contains(&SpecialKind::Fold), "{step} {kinds:?}");
        let at_zero = found[0]
            .points
            .iter()
            .filter(|p| p.parameter().abs() < 1e-12);
        assert!(at_zero.count() > 5, "{step}");
    }
}

/// A wheelset in rails with clearance hunts: at V = 1/sqrt(2) it is a linear oscillator without damping until it touches both flanges, half a period from
/// each other. Rounding has one of these touches end before the other.
#[test]
fn a_family_begins_at_two_symmetric_touches_wherever_from() {
    let text = r#"
    [parameters]
    V = 2
    [flight]
    y = "v"
    v = "-2*(v/V - psi) - y - 20*(y - clamp(y, -0.3, 0.3))"
    psi = "om"
    om = "-2*(0.5*om/V + y) - psi"
    [section.mid]
    surface = "y"
    direction = "rising"
    [initial]
    y = 0.2
    v = 0
    psi = 0
    om = 0
    "#;
    for (start, range) in [("1", (0.5, 4.0)), ("1", (0.6, 1.05)), ("2", (0.5, 4.0))] {
        let model = with(text, &[("V", start)]);
        let found = over(&model, "V", range, (4, 0.01));
        let special = &found[0].special;
        let kinds: Vec<SpecialKind> = special.iter().map(|s| s.kind).collect();
        let context = format!("{start} {range:?}");
        assert_eq!(kinds, [SpecialKind::Hopf, SpecialKind::Touch], "{context}");
        for special in special {
            assert!((value(special) - 0.5_f64.sqrt()).abs() < 1e-12, "{context}");
        }
        assert_eq!(found[0].ends, [End::Equilibrium, End::Range], "{context}");
    }
}

/// An oscillator with a Jenkins element, a spring in series with a slider: below the force at which that begins to slide it sticks wherever it is, and all motion is
/// periodic. In closed form that is F |(1 - w^2 + k) + 2 i zeta w|^-1 = z_s.
#[test]
fn a_branch_of_slips_ends_where_a_joint_sticks_in_many_places() {
    let text = "[parameters]\nF = 0.5\n[flight]\nx = \"v\"\nv = \"-x - 0.04*v - 0.6*z + F*cos(0.9*t)\"\n\
        z = \"if(z >= 0.5, min(v, 0), if(z <= -0.5, max(v, 0), v))\"\n[initial]\nx = 0\nv = 0\nz = 0\n";
    let ends = 0.5 * (1.6_f64 - 0.81).hypot(0.04 * 0.9);
    for (start, step) in [("0.5", 0.1), ("0.42", 0.03)] {
        let found = over(&with(text, &[("F", start)]), "F", (0.3, 0.55), (4, step));
        let branch = &found[0];
        assert!(
            matches!(&branch.ends, [End::Lost(why), End::Range] if why.starts_with("its events come to nothing")),
            "{start} {step} {:?}",
            branch.ends
        );
        let last = branch.points[0].parameter();
        assert!((last - ends).abs() < 1e-9, "{start} {step} {last}");
        assert!(
            branch.special.is_empty(),
            "{start} {step} {:?}",
            branch.special
        );
    }
}
