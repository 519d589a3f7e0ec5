//! A stick that an impact cuts short, and that begins just there.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::SpecialKind;

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
