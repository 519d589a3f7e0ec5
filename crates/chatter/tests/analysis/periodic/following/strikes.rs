//! What strikes a body that friction holds, ever more weakly.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// An oscillator strikes a body that slips a little and comes back as far. As its impact loses its rate both slips come to nothing, and the body sticks
/// where friction just holds it, at f / k: there the oscillator's amplitude is that and the gap. Without the impact the body may be held anywhere.
#[test]
fn a_struck_body_is_held_in_many_places() {
    for (gap, friction, low) in [
        (0.4_f64, 0.15_f64, 1.7),
        (0.4, 0.3, 1.68),
        (0.5, 0.15, 1.65),
    ] {
        let text = format!(
            "[parameters]\nom = 1.8\n[flight]\nx = \"v\"\nv = \"cos(om*t) - 0.1*v - x\"\ny = \"u\"\nu = \"(-3*y - {friction}*sign(u))/2\"\n\
            [[contact]]\nname = \"pair\"\ngap = \"{gap} + y - x\"\nimpulse = {{ v = -1, u = 0.5 }}\nrestitution = 0.5\n\
            [section.s]\nsurface = \"sin(om*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0\ny = 0\nu = 0\n"
        );
        // (1 - om^2)^2 + (om/10)^2 is one over the square of the amplitude.
        let amplitude = gap + friction / 3.0;
        let half = 0.5 * (2.0 - 0.01);
        let exact = (half + (half * half - 1.0 + amplitude.powi(-2)).sqrt()).sqrt();
        for (start, step) in [("1.75", 0.05), ("1.8", 0.2)] {
            let found = over(&with(&text, &[("om", start)]), "om", (low, 2.0), (4, step));
            assert_eq!(found.len(), 1, "{gap} {friction} from {start}");
            let branch = &found[0];
            let ends = branch.ends.iter().filter(|end| {
                matches!(end, End::Lost(why) if why.starts_with("an impact at `pair` has no rate any more"))
            });
            assert_eq!(
                ends.count(),
                1,
                "{gap} {friction} from {start}: {:?}",
                branch.ends
            );
            let graze = branch
                .special
                .iter()
                .find(|special| special.kind.is_graze());
            let graze = graze.unwrap();
            assert_eq!(graze.kind, SpecialKind::ImpactGraze);
            assert!((value(graze) - exact).abs() <= graze.error, "{graze:?}");
            assert!(graze.error < 1e-14, "{graze:?}");
        }
    }
}
