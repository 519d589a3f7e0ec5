//! What events alone move, as the switch of a converter: it is to come back, too.

use super::{orbits_from, over, value, with};
use chatter::analysis::periodic::SpecialKind;
use chatter::numerics::Real;

/// A boost converter in peak current mode: a clock closes the switch, and the current opens it.
const BOOST: &str = r#"
[parameters]
I = 6.87
[flight]
i = "if(s > 0.5, 10, 10 - v)"
v = "if(s > 0.5, -v/20, i - v/20)"
s = "0"
[[event]]
name = "clock"
surface = "sin(2*pi*t)"
direction = "rising"
reset = { s = 1 }
[[event]]
name = "peak"
surface = "i - I"
direction = "rising"
reset = { s = 0 }
[initial]
i = 5
v = 15
s = 1
"#;

/// By matrix exponentials with thirty digits there are one orbit of one period and one of two in which the current opens the switch in each. In one of two in which
/// it did so but once it would do it after 0.9992 of the first: none is found that begins with the switch open and ends with it closed.
#[test]
fn an_orbit_begins_with_the_switch_as_it_ends() {
    let found = orbits_from(&with(BOOST, &[]), (2, 40, 1));
    assert_eq!(found.len(), 2, "{found:?}");
    let [simple, doubled] = [&found[0], &found[1]].map(|orbit| &orbit.multipliers);
    let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-12, "{found} {exact}");
    near(simple[0].re, -1.801_598_555_007_95);
    near(simple[1].re, 0.883_250_472_574_443_1);
    near(doubled[0].re + doubled[1].re, 0.820_800_199_561_96);
    near(doubled[0].modulus().powi(2), 0.680_207_228_841_688_8);
    assert!((found[1].period.to_f64() - 2.0).abs() < 1e-14);
}

/// Where the current peaks just at the tick of the clock, with matrix exponentials in thirty digits: a bit less of it and the switch opens for a moment before the
/// tick, a bit more and it does so once in two periods.
#[test]
fn a_peak_at_the_tick_of_the_clock_is_told_from_everywhere() {
    for (start, range, step) in [
        ("5.79", (5.0, 8.0), 0.1),
        ("5.5", (5.0, 8.0), 0.03),
        ("6.5", (5.0, 8.0), 0.1),
    ] {
        let found = over(&with(BOOST, &[("I", start)]), "I", range, (1, step));
        let told: Vec<_> = (found[0].special.iter())
            .map(|special| (special.kind, value(special)))
            .collect();
        let [(SpecialKind::Touch, at)] = told[..] else {
            panic!("{start} {told:?}");
        };
        assert!((at - 6.876_820_295_668_92).abs() < 1e-11, "{start} {at}");
    }
}
