//! Orbits of systems that conserve energy: where branches meet both multipliers are 1.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// Mirror images, in time, of orbits with two impacts meet in one that is its own. A station beside that may be on either branch, whichever step led
/// there; the place is no fold, nor is it passed untold. By Newton's method on trace = 2 of the closed form of the flights, in thirty digits.
#[test]
fn a_branch_that_turns_at_its_mirror_image_in_time_tells_where() {
    let text = "[parameters]\nomega = 3.5\n[flight]\nx = \"v\"\nv = \"cos(omega*t) - x\"\n[[contact]]\nname = \"wall\"\n\
        gap = \"0.2 - x\"\nimpulse = { v = -1 }\nrestitution = 1\n[section.strobe]\nsurface = \"sin(omega*t)\"\n\
        direction = \"rising\"\n[initial]\nx = -1\nv = 1\n";
    for step in [0.0178571, 0.01, 0.003] {
        let found = over(&with(text, &[]), "omega", (2.2, 3.6), (8, step));
        let [branch, itself] = &found[..] else {
            panic!("{} branches", found.len());
        };
        // The orbits that are their own mirror images go through the same point.
        let passes = itself.special.iter().any(|s| {
            s.kind == SpecialKind::BranchPoint
                && (value(s) - 2.639_656_695_679_384_7).abs() <= s.error
        });
        assert!(passes, "{step}");
        let kinds: Vec<SpecialKind> = branch.special.iter().map(|s| s.kind).collect();
        let expected = [
            SpecialKind::BranchPoint,
            SpecialKind::ImpactGraze,
            SpecialKind::PeriodDoubling,
        ];
        assert_eq!(kinds, expected, "{step}");
        assert_eq!(branch.ends, [End::Back, End::Range], "{step}");
        let met = &branch.special[0];
        let off = (value(met) - 2.639_656_695_679_384_7).abs();
        assert!(off <= met.error && met.error < 1e-13, "{step} {met:?}");
    }
}
