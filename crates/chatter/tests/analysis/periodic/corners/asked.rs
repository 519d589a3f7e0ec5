//! Orbits whose impacts and resets ask for corners of their own.

use crate::periodic::differences::{agree, differences};
use crate::periodic::{orbit, with};
use chatter::numerics::Real;

/// A driven mass that hits a wall.
fn struck(tables: &str, restitution: &str) -> String {
    format!(
        "{tables}[flight]\nx = \"v\"\nv = \"-0.1*v - x + 2.5*cos(2.3*t)\"\n[[contact]]\nname = \"wall\"\ngap = \"0.4 - x\"\n\
         impulse = {{ v = -1 }}\nrestitution = \"{restitution}\"\n[initial]\nx = 0\nv = 0.2\n"
    )
}

/// One impact a period with the rate v leaves of areas r d(r v)/dv e^(-0.1 T).
#[test]
fn restitutions_that_change_with_the_rate_have_their_slope_in_multipliers() {
    let e = "[table.e]\nx = [0, 0.5, 1, 3]\ny = [0.9, 0.8, 0.75, 0.45]\n";
    for (tables, restitution) in [
        ("", "min(0.9, 0.5*abs(v)^(-0.25))"),
        ("", "0.5 + 0.2*floor(abs(v)*2)/(1 + floor(abs(v)*2))"),
        (e, "e(abs(v))"),
        (e, "e(v)"),
    ] {
        let model = with(&struck(tables, restitution), &[]);
        let found = orbit(&model);
        assert_eq!(found.multipliers.len(), 2, "{restitution}");
        agree(&found, &differences(&model, &found));
    }
}

/// A swing that is kicked once a turn, by the lesser of two laws: V = g(V e^(-T/20)) with T = 2 pi/w.
#[test]
fn a_reset_has_the_slope_of_the_law_that_holds() {
    let w = (1.0_f64 - 0.0025).sqrt();
    let left = (-0.1 * std::f64::consts::PI / w).exp();
    for (constant, slope) in [(0.5, 0.9), (0.8, 0.4)] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-0.1*v - x\"\n[[event]]\nname = \"kick\"\nsurface = \"x\"\ndirection = \"rising\"\n\
             reset = {{ v = \"sign(x)*min(0.9*v + {constant}, 0.4*v + 1.3)\" }}\n[initial]\nx = 0.1\nv = 1\n"
        );
        let found = orbit(&with(&text, &[]));
        let period = found.period.to_f64();
        assert!(
            (period - 2.0 * std::f64::consts::PI / w).abs() < 1e-12,
            "{period}"
        );
        let expected = slope * left;
        let near = |m: &f64| (m - expected).abs() < 1e-10;
        let moduli: Vec<f64> = found.multipliers.iter().map(|m| m.modulus()).collect();
        assert!(moduli.iter().any(near), "{moduli:?} {expected}");
    }
}
