//! Where restitutions come to an end of what they may be.

use crate::periodic::{over, with};
use chatter::analysis::periodic::End;

/// A range may go beyond 0 <= r <= 1, where solutions of the equations are no motion: branches end at 0 and at 1, as if that were the range.
#[test]
fn a_branch_ends_where_a_restitution_does() {
    let text = "[parameters]\nr = 0.65\n[flight]\nx = \"v\"\nv = \"cos(1.3*t) - 0.1*v - x\"\n[[contact]]\nname = \"wall\"\n\
        gap = \"0.9 - x\"\nimpulse = { v = -1 }\nrestitution = \"r\"\n[section.strobe]\nsurface = \"sin(1.3*t)\"\n\
        direction = \"rising\"\n[initial]\nx = 0\nv = 0\n";
    for step in [0.1, 0.03] {
        let ends = |range: (f64, f64)| {
            let found = over(&with(text, &[]), "r", range, (8, step));
            let branch = &found[0];
            let values = branch.points.iter().map(|point| point.parameter());
            let (low, high) = values.fold((1.0_f64, 0.0_f64), |(low, high), r| {
                (low.min(r), high.max(r))
            });
            (branch.ends.clone(), low, high)
        };
        let beyond = |end: &End| matches!(end, End::Lost(why) if why.contains("`wall`"));
        let (all, low, high) = ends((-1.0, 2.0));
        assert!(all.iter().all(beyond), "{step} {all:?}");
        assert!(
            low.abs() < 1e-15 && (high - 1.0).abs() < 1e-15,
            "{step} {low} {high}"
        );
        let (all, low, _) = ends((0.0, 1.0));
        assert_eq!(all, [End::Range, End::Range], "{step}");
        assert!(low.abs() < 1e-15, "{step} {low}");
        // Within one step of 1.
        let (all, _, high) = ends((0.2, 0.99));
        assert_eq!(all, [End::Range, End::Range], "{step}");
        assert!((high - 0.99).abs() < 1e-15, "{step} {high}");
    }
}
