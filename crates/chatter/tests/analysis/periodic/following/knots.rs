//! Knots of tables that orbits come to: as complete chatter ends, and as a stop is touched.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// A follower on a cam that is a spline through points every 40 degrees. Once a turn it chatters to rest: at 279.36 degrees for omega = 12.35 and at 280.43
/// for 12.37, by an integration of its own. As that passes the knot at 280 degrees nothing happens to the orbit.
#[test]
#[ignore = "takes ten seconds"]
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

/// A soft stop under a force that is a table of the phase, each knot of which is another number in the next turn. It is touched where the amplitude of the
/// oscillator is the distance, F = s |1 - w^2 + 2 i z w|, be that just before the end of a turn.
#[test]
fn a_stop_is_touched_in_a_turn_that_ends_in_other_pieces() {
    let (w, z, s) = (0.65_f64, 0.06_f64, 0.6_f64);
    let touch = s * (1.0 - w * w).hypot(2.0 * z * w);
    for phase in ["0.4", "0.5", "0.6"] {
        let text = format!(
            "[parameters]\nF = 0.5\n[table.one]\nx = [0, 0.3, 0.8, 1]\ny = [1, 1, 1, 1]\nkind = \"periodic-cubic\"\n[flight]\nx = \"v\"\n\
             v = \"F*one({w}*t/(2*pi))*cos({w}*t + {phase}) - {}*v - x - 3*max(x - {s}, 0)\"\n[section.s]\nsurface = \"sin({w}*t)\"\n\
             direction = \"rising\"\n[initial]\nx = 0.1\nv = 0\n",
            2.0 * z
        );
        let found = over(&with(&text, &[]), "F", (0.3, 0.5), (30, 0.1));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{phase}");
        let [only] = &branch.special[..] else {
            panic!("{phase}: {:?}", branch.special);
        };
        assert_eq!(only.kind, SpecialKind::Touch);
        assert!((value(only) - touch).abs() < 1e-14, "{phase}: {only:?}");
    }
}
