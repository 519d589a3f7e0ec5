//! Events with a reset that an orbit comes to touch.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, Point};

/// An oscillator whose reset to a state of adhesion comes with the corner of a spring, at x = -s, which it reaches with F = s |1 - w^2 + 2 i z w|. The spring alone would
/// be touched, and the motion go on; the reset is another matter, and with it the motion does not come back.
#[test]
fn an_event_that_comes_with_a_corner_is_not_left_out() {
    let (w, z, s) = (0.9_f64, 0.02_f64, 0.8_f64);
    let touch = s * (1.0 - w * w).hypot(2.0 * z * w);
    let text = "[parameters]\nF = 0.11\n[flight]\nx = \"v\"\nv = \"-x - 0.04*v + F*cos(0.9*t) + 5*max(-x - 0.8, 0) - if(n > 0.5, 0.2, 0)\"\n\
        n = \"0\"\n[[event]]\nname = \"touch\"\nsurface = \"x + 0.8\"\ndirection = \"falling\"\nreset = { n = 1 }\n[[event]]\nname = \"rupture\"\n\
        surface = \"x + 0.5\"\ndirection = \"rising\"\nreset = { n = 0 }\n[section.s]\nsurface = \"sin(0.9*t)\"\ndirection = \"rising\"\n\
        [initial]\nx = 0\nv = 0\nn = 0\n";
    for step in [0.03, 0.1] {
        let found = over(&with(text, &[]), "F", (0.1, 0.2), (8, step)).swap_remove(0);
        let (first, last) = (&found.ends[0], &found.ends[1]);
        assert_eq!(*first, End::Range, "{step}");
        assert!(
            matches!(last, End::Lost(why) if why.contains("no motion leads beyond")),
            "{step}: {last:?}"
        );
        let place = found.special.last().map(value).unwrap_or(f64::NAN);
        assert!((place - touch).abs() < 1e-14, "{step}: {place}");
        let beyond = |point: &Point| point.parameters[0] > touch;
        assert!(!found.points.iter().any(beyond), "{step}");
    }
}

/// The reset of an event sets to zero what is zero already: it is touched where F / |1 - w^2 + 2 i z w| = 1/2, and the same motion goes on, with and without it.
#[test]
fn an_event_that_changes_nothing_is_passed_both_ways() {
    let (w, z) = (0.9_f64, 0.02_f64);
    let touch = 0.5 * (1.0 - w * w).hypot(2.0 * z * w);
    let text = "[parameters]\nF = 0.05\n[flight]\nx = \"v\"\nv = \"-x - 0.04*v + F*cos(0.9*t) - if(n > 0.5, 0.2, 0)\"\n\
        n = \"0\"\n[[event]]\nname = \"rupture\"\nsurface = \"x + 0.5\"\ndirection = \"rising\"\nreset = { n = 0 }\n\
        [section.s]\nsurface = \"sin(0.9*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0\nn = 0\n";
    for (start, step) in [("0.05", 0.01), ("0.05", 0.1), ("0.12", 0.01), ("0.12", 0.1)] {
        let found = over(&with(text, &[("F", start)]), "F", (0.04, 0.14), (8, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{start} {step}");
        let [told] = &found[0].special[..] else {
            panic!("{start} {step}: {:?}", found[0].special);
        };
        assert!(
            (value(told) - touch).abs() < 1e-15,
            "{start} {step}: {}",
            value(told)
        );
        assert_eq!(told.persists, Some(true), "{start} {step}");
    }
}
