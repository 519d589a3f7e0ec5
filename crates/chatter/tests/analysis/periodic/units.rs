//! Units of states and of time say nothing: numbers scale with them, and what has no unit stays.

use super::{orbit, over, settles, value, with};
use chatter::analysis::exponents::{Spec as Averages, exponents};
use chatter::analysis::periodic::{End, PeriodicError, SpecialKind};
use chatter::numerics::Real;
use core::f64::consts::TAU;
use std::ops::ControlFlow;

/// A resonator with a stop whose unit of time is 1/W.
fn resonator(w: f64) -> String {
    format!(
        "[parameters]\nW = {w}\nq = 2\n[flight]\nx = \"v\"\nv = \"-0.1*W*v - W^2*x + W^2*cos(q*W*t)\"\n[[contact]]\n\
         name = \"stop\"\ngap = \"x + 0.5\"\nimpulse = {{ v = 1 }}\nrestitution = 0.75\n[initial]\nx = 0\nv = 0\n"
    )
}

#[test]
fn multipliers_and_exponents_of_fast_motion_are_those_of_slow_motion() {
    for w in [1e-6, 1.0, 1e7, 1e9, 1e12] {
        let model = with(&resonator(w), &[("q", "0.9")]);
        let found = orbit(&model);
        let product: f64 = found.multipliers.iter().map(|m| m.modulus()).product();
        let expected = 0.75 * 0.75 * (-0.1 * TAU / 0.9_f64).exp();
        assert!(
            (product - expected).abs() < 1e-9,
            "{w}: {product} {expected}"
        );
        assert!(
            (found.multipliers[0].re + 0.305_137_358_8).abs() < 1e-9,
            "{w}"
        );
        let interval = TAU / 0.9 / w;
        let spec = Averages {
            interval,
            transient: 100,
            intervals: 100,
        };
        let averages = exponents(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
        let sum: f64 = averages.values.iter().sum();
        assert!(
            (sum * interval - expected.ln()).abs() < 1e-9,
            "{w}: {averages:?}"
        );
    }
}

#[test]
fn special_points_of_fast_motion_are_those_of_slow_motion() {
    let doublings = |w: f64| -> Vec<f64> {
        let at_rest = resonator(w).replace("x + 0.5", "x").replace("0.75", "0.8");
        over(&with(&at_rest, &[]), "q", (1.7, 3.2), (40, 0.02))
            .iter()
            .flat_map(|branch| &branch.special)
            .filter(|special| special.kind == SpecialKind::PeriodDoubling)
            .map(value)
            .collect()
    };
    let slow = doublings(1.0);
    assert!((slow[0] - 2.658_884_546_68).abs() < 1e-10, "{slow:?}");
    let fast = doublings(1e8);
    assert_eq!(slow.len(), fast.len(), "{slow:?} {fast:?}");
    for (a, b) in slow.iter().zip(&fast) {
        assert!((a - b).abs() < 1e-11, "{a} {b}");
    }
}

/// Where forces of nanometres are what matters, or a load that changes in the course of months, the equations say their period all the
/// same.
#[test]
fn a_period_is_known_however_small_its_load() {
    let cubic = "[parameters]\nom = 0.9\n[flight]\nx = \"v\"\nv = \"-0.1*v - x - 1e16*x^3 + 1e-8*cos(om*t)\"\n\
                 [initial]\nx = 0\nv = 0\n";
    let slow = "[flight]\nx = \"1e-6*(cos(2e-7*t) - x)\"\n[initial]\nx = 0\n";
    for (text, frequency) in [(cubic, 0.9), (slow, 2e-7)] {
        let found = orbit(&with(text, &[]));
        let off = found.period.to_f64() * frequency / TAU - 1.0;
        assert!(off.abs() < 1e-13, "{off:e}");
    }
}

/// A relaxation oscillator whose events are a million units of time apart, and motion that goes on without any.
#[test]
fn slow_motion_is_not_rest() {
    let cycle = |s: f64| {
        let text = format!(
            "[flight]\nx = \"(1.5 - x)/{s}\"\n[[event]]\nname = \"fires\"\nsurface = \"x - 1\"\ndirection = \"rising\"\n\
             reset = {{ x = 0 }}\n[initial]\nx = 0.2\n"
        );
        orbit(&with(&text, &[])).period.to_f64() / s
    };
    for s in [1.0, 1e4, 1e7, 1e9] {
        let off = cycle(s) - 3.0_f64.ln();
        assert!(off.abs() < 1e-13, "{s}: {off:e}");
    }
    let turns = "[flight]\nx = \"y\"\ny = \"-x\"\n[initial]\nx = 1\ny = 0\n";
    let told = settles(&with(turns, &[])).unwrap_err();
    assert!(
        !matches!(told, PeriodicError::Equilibrium { .. }),
        "{told:?}"
    );
}

/// A lag that is switched on when a ramp of period T, at whose end the section is, has come to x/2: with s the part of the period at which it
/// does, x e^(-s) = 2 s and x = E + (2 s - E) e^(s - 1). In most units both are at one instant, but for rounding.
#[test]
fn a_section_at_the_end_of_a_ramp_is_there_in_all_units_of_time() {
    for period in ["400e-6", "4e-3", "0.7"] {
        let text = format!(
            "[parameters]\nT = {period}\nE = 1.0\n[flight]\nx = \"(if(0.5*x < mod(t/T, 1), E, 0) - x)/T\"\n[section.strobe]\n\
             surface = \"sin(2*pi*t/T)\"\ndirection = \"rising\"\n[initial]\nx = 0.2\n"
        );
        let model = with(&text, &[]);
        let branch = &over(&model, "E", (0.5, 2.0), (8, 0.02))[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{period}");
        assert!(branch.special.is_empty(), "{period}");
        for point in &branch.points {
            let (height, x) = (point.parameter(), point.state[0]);
            let off = |s: f64| height + (2.0 * s - height) * (s - 1.0).exp() - 2.0 * s * s.exp();
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if off(middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let expected = [2.0 * low * low.exp(), 2.0 * low];
            let near = |x: f64| expected.iter().any(|y| (x - y).abs() < 1e-11);
            assert!(near(x), "{period}: {height} {x} {expected:?}");
        }
    }
}

/// Two masses with dry friction on the ground and between them, and a stop: on the way to a fold the moment between where they slip and where
/// they stick comes to none, and the branch goes on without it (integrated with scipy, piece by piece).
#[test]
fn a_stay_that_vanishes_leads_on_in_all_units() {
    let masses = |[length, first, other, time]: [f64; 4]| {
        let set =
            |name: &str, rate: &str, unit: f64| format!("{name} = '({rate})*{unit}/{time}'\n");
        format!(
            "[parameters]\nF = 1.2\n[definitions]\nx = 'X/{length}'\nv = 'V/{first}'\ny = 'Y/{length}'\nu = 'U/{other}'\n[flight]\n{}{}{}{}\
             [[contact]]\nname = 'stop'\ngap = '{length} - Y'\nimpulse = {{ U = -1 }}\nrestitution = 0.65\n\
             [initial]\nX = '0.1*{length}'\nV = '0.2*{first}'\nY = 0\nU = 0\n",
            set("X", "v", length),
            set(
                "V",
                &format!("F*cos(1.1*t/{time}) - x - 0.4*sign(v) - 0.8*(x - y) - 0.3*sign(v - u)"),
                first
            ),
            set("Y", "u", length),
            set("U", "(0.8*(x - y) + 0.3*sign(v - u))/0.7 - 0.1*u", other),
        )
    };
    let touch = 1.150_435_944_660_908;
    for (units, from, range) in [
        ([1.0, 1.0, 1.4, 1.0], 1.6, (1.14, 1.61)),
        ([1e3, 1.0, 1.0, 1e3], 1.16, (1.149, 1.165)),
        ([1e-3, 0.6, 3e-3, 1e-3], 1.16, (1.149, 1.165)),
        ([1e3, 7e2, 0.31, 1e3], 1.16, (1.149, 1.165)),
    ] {
        let model = with(&masses(units), &[("F", &format!("{from}"))]);
        let branch = &over(&model, "F", range, (6, 0.01))[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{units:?}");
        let places = |kind: SpecialKind| -> Vec<f64> {
            let of = branch.special.iter().filter(|found| found.kind == kind);
            of.map(value).collect()
        };
        let (touches, folds) = (places(SpecialKind::Touch), places(SpecialKind::Fold));
        let near = touches.iter().filter(|at| (*at - touch).abs() < 2e-12);
        assert_eq!(near.count(), 1, "{units:?}: {touches:?}");
        assert!(
            matches!(&folds[..], [fold] if (fold - 1.150_218_734_068_6).abs() < 2e-12),
            "{units:?}: {folds:?}"
        );
    }
}
