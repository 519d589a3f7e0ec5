//! Where the equations have no value beyond: what a root is taken of, and the end of a table.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// A linear oscillator, and something that flows through an opening which it closes at x = 1.5.
/// (A table is left a part of 1e-12 of its largest argument beyond its end.)
fn opening(flow: &str, length: f64) -> String {
    format!(
        "[parameters]\nL = {length:?}\nF = '0.4*L'\nw = 0.7\n[flight]\nx = 'v'\nv = 'F*cos(w*t) - 0.2*v - x'\nz = '{flow} - z'\n\
         [section.s]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[table.level]\nx = [-1500, 0, 1500]\ny = [1, 2, 5]\nkind = 'linear'\n\
         [initial]\nx = 0\nv = 0\nz = 1\n"
    )
}

/// The amplitude F/|1 - w^2 + 0.2 i w| comes to 1.5 lengths at F = 1.5 |1 - w^2 + 0.2 i w|.
#[test]
fn branches_end_where_the_equations_do() {
    let factor = 1.5 * (1.0_f64 - 0.49).hypot(0.2 * 0.7);
    let flows = [
        "sqrt(1.5 - x/L)",
        "(1.5 - x/L)^1.5",
        "x/L*sqrt(1.5 - x/L)",
        "(1.5 - x/L)^0.3",
        "sqrt(2.25 - (x/L)^2)",
        "level(1000*x/L)",
    ];
    for (place, flow) in flows.into_iter().enumerate() {
        // A unit of length is no matter of what ends: one flow is asked in three.
        let lengths: &[f64] = if place == 0 {
            &[1e-3, 1.0, 1e3]
        } else {
            &[1.0]
        };
        for &length in lengths {
            let model = with(&opening(flow, length), &[]);
            let range = (0.1 * length, 2.0 * length);
            let found = over(&model, "F", range, (8, 0.05)).swap_remove(0);
            let touches: Vec<f64> = found
                .special
                .iter()
                .filter(|special| special.kind == SpecialKind::Touch)
                .map(value)
                .collect();
            let expected = factor * length;
            assert!(
                touches
                    .iter()
                    .any(|touch| (touch / expected - 1.0).abs() < 2e-12),
                "{flow} {length}: {touches:?}, {expected}"
            );
            let ends = &found.ends;
            let says =
                |end: &End| matches!(end, End::Lost(why) if why.contains("no motion leads beyond"));
            assert!(ends.iter().any(says), "{flow} {length}: {ends:?}");
            assert!(
                (found.points.iter()).all(|point| point.parameters[0] <= expected * (1.0 + 1e-12)),
                "{flow} {length}"
            );
        }
    }
}
