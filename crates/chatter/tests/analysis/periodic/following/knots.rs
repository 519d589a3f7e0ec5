//! Knots of tables that complete chatter comes to.

use crate::periodic::{over, with};
use chatter::analysis::periodic::End;

/// A follower on a cam that is a spline through points every 40 degrees. Once a turn it chatters to rest: at 279.36 degrees for omega = 12.35 and at 280.43
/// for 12.37, by an integration of its own. As that passes the knot at 280 degrees nothing happens to the orbit.
#[test]
fn the_end_of_chatter_passes_a_knot() {
    let text = "[parameters]\nomega = 12.35\n[table.lift]\nx = [0, 40, 80, 120, 160, 200, 240, 280, 320, 360]\n\
        y = [0, 0.02, 0.12, 0.24, 0.3, 0.27, 0.16, 0.05, 0.01, 0]\nkind = \"periodic-cubic\"\n[flight]\ny = \"v\"\n\
        v = \"-30*(y + 0.6) - v\"\nangle = \"omega\"\n[[contact]]\nname = \"cam\"\ngap = \"y - lift(angle*180/pi)\"\n\
        impulse = { v = 1 }\nrestitution = 0.45\n[section.turn]\nsurface = \"sin(angle)\"\ndirection = \"rising\"\n\
        [initial]\ny = 0.5\nv = 0\nangle = 0\n";
    for (step, range) in [
        (0.1, (12.34, 12.4)),
        (0.3, (12.33, 12.42)),
        (0.9, (12.33, 12.4)),
    ] {
        let found = over(&with(text, &[]), "omega", range, (30, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{step}");
        assert!(branch.special.is_empty(), "{step}");
        let rests = branch
            .points
            .iter()
            .all(|p| p.impacts.is_none() && p.is_stable());
        assert!(rests, "{step}");
    }
}
