//! Orbits with many impacts next to a chatter border.

use crate::periodic::{over, with};
use chatter::analysis::periodic::SpecialKind;

/// A ball on a shaken table, whose flights next to its border are hardly higher than rounding of where it is. The product of both multipliers is 0.3^2 for
/// each impact; in doubles it came out as 3000 times that, and -1 as -1.0001.
#[test]
fn multipliers_are_known_though_flights_are_hardly_higher_than_rounding() {
    let text = "[parameters]\nA = 1.94694\n[flight]\nx = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\n\
        gap = \"x - A*cos(t)\"\nimpulse = { v = 1 }\nrestitution = 0.3\n[section.s]\nsurface = \"sin(t)\"\n\
        direction = \"rising\"\n[initial]\nx = 1.98\nv = 0\n";
    let found = over(&with(text, &[]), "A", (1.94, 1.95), (80, 0.1));
    let told = found.iter().flat_map(|branch| &branch.special);
    let mut doublings = told.filter(|special| special.kind == SpecialKind::PeriodDoubling);
    let doubling = doublings.find(|special| special.point.impacts == Some(23));
    let doubling = doubling.expect("a doubling of orbits with 23 impacts");
    let [through, other] = doubling.point.multipliers[..] else {
        panic!("{:?}", doubling.point.multipliers);
    };
    assert!((through.re + 1.0).abs() < 1e-6, "{through:?}");
    let product = 0.09_f64.powi(23);
    assert!((other.re / product + 1.0).abs() < 1e-3, "{other:?}");
}
