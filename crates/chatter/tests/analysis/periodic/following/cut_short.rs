//! A stick that an impact cuts short, and that begins just there.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// A mass on a belt hits a stop. Where its stick begins just at the impact the branch turns back as the orbit that slips all the way. The place
/// by an integration of the slip (DOP853, tolerance 1e-13) from that impact to the velocity of the belt.
#[test]
fn a_branch_turns_back_where_a_stick_begins_at_the_impact_that_ends_it() {
    let text = "[parameters]\nV = 0.13\n[flight]\nx = \"v\"\n\
        v = \"-x - 0.04*v - (0.25 + 0.35*exp(-abs(v - V)/0.3))*sign(v - V)\"\n[[contact]]\nname = \"stop\"\ngap = \"0.45 - x\"\n\
        impulse = { v = -1 }\nrestitution = 0.5\n[section.s]\nsurface = \"x - 0.2\"\ndirection = \"rising\"\n[initial]\nx = 0.45\nv = -0.05\n";
    // The orbit that slips where V is 0.13.
    let slips = [("V", "0.1336702831463664"), ("v", "-0.04081155240645208")];
    for (set, step) in [(&[][..], 0.05), (&[], 0.2), (&slips[..], 0.05)] {
        let mut text = text.to_owned();
        for (name, to) in set.iter().filter(|(name, _)| *name == "v") {
            text = text.replace("v = -0.05", &format!("{name} = {to}"));
        }
        let set: Vec<_> = set
            .iter()
            .copied()
            .filter(|(name, _)| *name == "V")
            .collect();
        let found = over(&with(&text, &set), "V", (0.1, 0.15), (4, step));
        let [branch] = &found[..] else {
            panic!("{} branches", found.len());
        };
        let [touch] = &branch.special[..] else {
            panic!("{:?}", branch.special);
        };
        assert_eq!(
            (touch.kind, touch.persists),
            (SpecialKind::Touch, Some(false))
        );
        assert!(
            (value(touch) - 0.114_427_768_528_25).abs() < 1e-13,
            "{touch:?}"
        );
        assert!(touch.error < 1e-14);
        // A stick forgets; without it displacements grow by 1.39169 at V = 0.13, by the difference of two integrations.
        let known = |point: &chatter::analysis::periodic::Point| point.multipliers[0].re;
        let slipping = branch.points.iter().filter(|point| known(point) > 0.5);
        let near = slipping.min_by(|a, b| {
            let off = |point: &chatter::analysis::periodic::Point| (point.parameter() - 0.13).abs();
            off(a).total_cmp(&off(b))
        });
        let near = near.expect("an orbit that slips");
        let expected = 1.391_687 - 2.9 * (near.parameter() - 0.13);
        assert!(
            (known(near) - expected).abs() < 0.02,
            "{} {}",
            near.parameter(),
            known(near)
        );
        assert!(branch.points.iter().any(|point| known(point) == 0.0));
    }
}

/// An oscillator with drag as the square of its velocity meets a shaken stop. Where its velocity turns just at the impact nothing stays at zero velocity,
/// since the drag does not jump there, and all doublings are told whatever the start. That at 0.973 is 0.973295955 by another integrator, too.
#[test]
fn what_turns_at_an_impact_does_not_stay_where_no_field_jumps() {
    let text = "[parameters]\nw = 1.2\n[flight]\nx = \"v\"\nv = \"-0.2*v*abs(v) - x\"\n[[contact]]\nname = \"stop\"\n\
        gap = \"x + 0.2 - 0.5*sin(w*t)\"\nimpulse = { v = 1 }\nrestitution = 0.6\n[section.strobe]\n\
        surface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = 1\nv = 0\n";
    for start in ["1.2", "1.0"] {
        let found = over(&with(text, &[("w", start)]), "w", (0.8, 1.3), (4, 0.05));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start}");
        assert!(
            branch.points.iter().all(|point| point.impacts == Some(1)),
            "{start}"
        );
        let doublings = (branch.special.iter()).filter(|s| s.kind == SpecialKind::PeriodDoubling);
        let doublings: Vec<f64> = doublings.map(value).collect();
        assert_eq!(doublings.len(), 2, "{start}");
        assert!(
            (doublings[0] - 0.894_718_754_368_7).abs() < 1e-12,
            "{start} {doublings:?}"
        );
        assert!(
            (doublings[1] - 0.973_295_954_981_5).abs() < 1e-12,
            "{start} {doublings:?}"
        );
    }
    // With two impacts a period another one turns it, from either side.
    for start in ["0.57", "0.7"] {
        let found = over(&with(text, &[("w", start)]), "w", (0.55, 0.7), (4, 0.1));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start}");
        assert!(branch.special.is_empty(), "{start} {:?}", branch.special);
    }
}
