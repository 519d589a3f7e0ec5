//! Curves of chatter borders in two parameters.

use super::plane::{curve, curve_within};
use super::{model, nearest, over, with};
use chatter::analysis::periodic::{End, Known, Limits, SpecialKind};
use chatter::model::Model;
use chatter::numerics::Complex;
use core::f64::consts::PI;

/// The border of the valve at other parameters, in quadruple precision.
#[test]
fn the_border_of_the_valve_in_two_parameters() {
    let valve = model("pressure_relief_valve", &[("q", "0.02")]);
    let found = over(&valve, "q", (0.0199, 0.02008), (2, 0.1));
    let border = nearest(&found, &[SpecialKind::ChatterBorder], 0.02005);
    let curve = curve(&valve, ["q", "kappa"], &border, ((1.25, 1.3), 0.5));
    assert_eq!(curve.ends, [End::Range, End::Range]);
    let last = curve.points.last().unwrap();
    assert!((last.parameters[1] - 1.3).abs() < 1e-15);
    assert!((last.parameters[0] - 0.014_453_978_036_535_98).abs() < 1e-11);
}

/// An oscillator against a wall that moves at twice the frequency.
fn moving_wall(s: &str) -> Model {
    let text = "[parameters]\nw = 0.385\ns = 0.318\nz = 0.1\nr = 0.8\n[flight]\nx = 'v'\nv = 'cos(w*t) - 2*z*v - x'\n\
                [[contact]]\nname = 'wall'\ngap = 's + 0.05*sin(2*w*t + 0.3) - x'\nimpulse = {v = -1}\n\
                restitution = 'r'\n[section.s]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0\n\
                v = -0.5\n";
    with(text, &[("s", s)])
}

/// A curve of borders turns back in the second parameter.
#[test]
fn a_curve_of_borders_that_turns_back() {
    let border = Known {
        kind: SpecialKind::ChatterBorder,
        monitor: None,
        state: vec![0.0, -0.5],
        period: 2.0 * PI / 0.375,
    };
    let limits = Limits {
        range: (0.338, 0.342),
        other: Some((0.355, 0.38)),
        impacts: 70,
        points: 100,
        longest_step: 0.9,
    };
    let told = (&border, 0.375);
    let curve = curve_within(&moving_wall("0.339"), ["w", "s"], told, &limits).unwrap();
    assert_eq!(curve.ends, [End::Range, End::Range]);
    let [first, .., last] = &curve.points[..] else {
        panic!("{curve:?}");
    };
    // Where the sequence of impacts of the exact flights, in fifty digits, changes from complete to incomplete.
    for (end, w) in [
        (first, 0.376_662_580_429_741_2),
        (last, 0.359_561_145_881_94),
    ] {
        assert!(end.parameters[1] == 0.338);
        assert!((end.parameters[0] - w).abs() < 1e-12, "{end:?}");
    }
}

/// Beside a border flights are hardly higher than rounding of the gap: there multipliers of a branch are those of its solution in longer numbers,
/// and a curve in two parameters, which is no branch, has points all the same.
#[test]
fn a_curve_of_doublings_beside_a_border() {
    let doubling = Known {
        kind: SpecialKind::PeriodDoubling,
        monitor: None,
        state: vec![
            0.323_361_260_411_090_26,
            -0.095_925_405_532_624_2,
            16.320_845_972_929_046,
        ],
        period: 16.320_845_972_929_046,
    };
    let limits = Limits {
        range: (0.317_99, 0.318_01),
        other: None,
        impacts: 70,
        points: 2,
        longest_step: 1.0,
    };
    let at = 0.384_979_143_703_784_67;
    let told = (&doubling, at);
    let curve = curve_within(&moving_wall("0.318"), ["w", "s"], told, &limits).unwrap();
    assert!(curve.points.len() > 2);
    let is_double = |multiplier: &Complex| (multiplier.re + 1.0).abs() < 1e-3;
    assert!((curve.points.iter()).all(|point| point.multipliers.iter().any(is_double)));
}
