//! Sections that share their instant with a corner of the forcing, or with another event: an orbit is what it is wherever it is told.

use crate::periodic::{branch_spec, nearest, orbit, settles, with};
use chatter::analysis::periodic::{Beside, MarginKind, Spec, SpecialKind, branches};
use chatter::numerics::Real;
use core::f64::consts::TAU;
use std::ops::ControlFlow;

/// di Bernardo's buck converter: a coil and a capacitor that a comparator switches, on a ramp that falls back where the section is. Times are
/// stretched by a factor.
fn converter(stretch: f64, section: &str) -> String {
    let scaled = |x: f64| format!("{:e}", x * stretch);
    format!(
        "[parameters]\nE = 24\nT = {}\nL = {}\nC = {}\n[flight]\nv = '(i - v/22)/C'\n\
         i = '(if(8.4*(v - 11.3) >= 3.8 + 4.4*mod(t, T)/T, 0, E) - v)/L'\n{section}[initial]\nv = 12\ni = 0.55\n",
        scaled(400e-6),
        scaled(20e-3),
        scaled(47e-6)
    )
}

/// A section where a sine of that phase rises.
fn strobe(period: &str, phase: f64) -> String {
    format!("[section.strobe]\nsurface = 'sin(2*pi*t/{period} - {phase})'\ndirection = 'rising'\n")
}

#[test]
fn a_converter_goes_round_once_wherever_its_section_is() {
    for stretch in [1.0, 1e3, 2500.0] {
        let sections = [String::new(), strobe("T", 0.0), strobe("T", 0.3)];
        for section in sections {
            let model = with(&converter(stretch, &section), &[]);
            let found = settles(&model).unwrap();
            let turns = found.period.to_f64() / (400e-6 * stretch);
            assert!((turns - 1.0).abs() < 1e-12, "{stretch} {section} {turns}");
            let [first, second] = &found.multipliers[..] else {
                panic!("{:?}", found.multipliers)
            };
            // Liouville: the product of both is exp(-T/(R C)).
            let product = (-400e-6_f64 / (22.0 * 47e-6)).exp();
            assert!((first.modulus() * second.modulus() - product).abs() < 1e-10);
            assert_eq!(found.section.is_some(), !section.is_empty());
        }
    }
}

/// By SciPy from the flows of both pieces in closed form: where the determinant of one turn's derivative and the identity vanishes.
const DOUBLING: f64 = 24.516_572_828_562_45;

#[test]
fn a_converter_doubles_where_its_map_does() {
    for section in [strobe("T", 0.0), strobe("T", 0.3)] {
        let model = with(&converter(1.0, &section), &[]);
        let beside = Beside::default();
        let what = branch_spec(&model, ("E", (23.5, 25.0)), (8, 0.05), beside);
        let found = branches(&model, &Spec::default(), &what, Vec::new(), &mut |_| {
            ControlFlow::Continue(())
        });
        let found = found.unwrap();
        let all: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
        assert_eq!(all, [SpecialKind::PeriodDoubling]);
        let doubling = nearest(&found, &[SpecialKind::PeriodDoubling], DOUBLING);
        let off = (doubling.point.parameter() - DOUBLING).abs();
        assert!(off < 1e-9, "{off}");
        assert!((doubling.point.period - 400e-6).abs() < 1e-15);
    }
}

/// A damped oscillator under a square wave, which changes its sign where the section is: after half a period its state is minus what it was.
#[test]
fn a_square_wave_tells_once_around_at_all_frequencies() {
    for k in 0..60 {
        let w = 0.5 + 0.025 * f64::from(k);
        let text = format!(
            "[flight]\nx = 'v'\nv = '-x - 0.2*v + sign(sin({w:?}*t))'\n[section.strobe]\nsurface = 'sin({w:?}*t)'\n\
             direction = 'rising'\n[initial]\nx = 0.1\nv = 0\n"
        );
        let found = settles(&with(&text, &[])).unwrap();
        let turns = found.period.to_f64() * w / TAU;
        assert!((turns - 1.0).abs() < 1e-12, "{w} {turns}");
        let half = 0.5 * TAU / w;
        let own = 0.99_f64.sqrt();
        let (sin, cos) = (own * half).sin_cos();
        let shrinks = (-0.1 * half).exp();
        let [a, b] = [cos + 0.1 * sin / own, sin / own].map(|x| x * shrinks);
        let [c, d] = [-sin / own, cos - 0.1 * sin / own].map(|x| x * shrinks);
        // (I + M) X = (M - I) (1, 0), by Cramer's rule.
        let determinant = (1.0 + a) * (1.0 + d) - b * c;
        let x = ((a - 1.0) * (1.0 + d) - b * c) / determinant;
        let v = ((1.0 + a) * c - c * (a - 1.0)) / determinant;
        let told: Vec<f64> = found.start.iter().map(|x| x.to_f64()).collect();
        assert!((told[0] - x).abs() < 1e-10, "{w} {told:?} {x}");
        assert!((told[1] - v).abs() < 1e-10, "{w} {told:?} {v}");
    }
}

/// Complete chatter, with friction that turns at the top of each flight, that a square wave and a ramp of half its period end at one instant, whichever of
/// both rounding has come first: the period is that of the forcing, and the rate at the other wall that of the flight from rest, by DOP853.
#[test]
fn chatter_that_two_corners_of_one_clock_end_is_found() {
    for (w, rate) in [("0.655", 0.851_324_93), ("0.661", 0.847_188_36)] {
        for section in [
            "",
            "[section.s]\nsurface = 'sin(W*t)'\ndirection = 'rising'\n",
        ] {
            let text = format!(
                "[flight]\nx = 'v'\nv = 'mod(W*t/pi, 1) + sign(sin(W*t)) - x^3 - 0.2*x - 0.23*v - 0.2*sign(v)'\n\
                 [[contact]]\nname = 'a'\ngap = '0.63 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.45\n\
                 [[contact]]\nname = 'b'\ngap = '0.89 + x'\nimpulse = {{ v = 1 }}\nrestitution = 0.61\n\
                 {section}[initial]\nx = 0.1\nv = 0\n"
            );
            let found = orbit(&with(&text.replace('W', w), &[]));
            let turns = found.period.to_f64() * w.parse::<f64>().unwrap() / TAU;
            assert!((turns - 1.0).abs() < 1e-12, "{w} {section} {turns}");
            assert!(found.residual < 1e-20, "{}", found.residual);
            assert_eq!(found.impacts, None);
            assert!(found.multipliers.iter().all(|m| m.modulus() == 0.0));
            let mut rates =
                (found.margins.iter()).filter(|margin| margin.kind == MarginKind::ImpactRate);
            assert!(
                rates.any(|margin| (margin.value - rate).abs() < 1e-8),
                "{w}"
            );
        }
    }
}

/// A ramp, a square wave and a step of one clock change at one instant, in whichever order rounding has them: the period is one turn, with and
/// without a section there.
#[test]
fn corners_of_one_clock_are_told_once_around() {
    for force in [
        "sign(sin(W*t)) + 0.5*step(mod(W*t/(2*pi), 1) - 0.5)",
        "mod(W*t/pi, 1) + sign(sin(W*t))",
        "sign(sin(W*t)) + 0.4*sign(sin(3*W*t))",
    ] {
        for w in ["0.525", "0.648", "1.099", "1.136"] {
            for section in [
                "",
                "[section.s]\nsurface = 'sin(W*t)'\ndirection = 'rising'\n",
            ] {
                let text = format!(
                    "[flight]\nx = 'v'\nv = '{force} - x - 0.2*v'\n{section}[initial]\nx = 0.1\nv = 0\n"
                );
                let found = settles(&with(&text.replace('W', w), &[])).unwrap();
                let w: f64 = w.parse().unwrap();
                let turns = found.period.to_f64() * w / TAU;
                assert!((turns - 1.0).abs() < 1e-12, "{force} {w} {section} {turns}");
                let shrinks = (-0.1 * TAU / w).exp();
                for m in &found.multipliers {
                    assert!((m.modulus() - shrinks).abs() < 1e-9, "{force} {w} {m:?}");
                }
            }
        }
    }
}
