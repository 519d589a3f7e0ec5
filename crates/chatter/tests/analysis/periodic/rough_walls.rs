//! Impacts whose friction stops what slides along the wall.

use super::{orbit, with};
use chatter::numerics::Real;

/// What can slide along the wall is at rest: a displacement of its rate is stopped by the next impact, one of its place swings from there
/// for a period, y = e^(-t/10) (cos wt + sin wt/(10 w)).
#[test]
fn friction_stops_what_is_nearly_at_rest() {
    let text = r#"
    [flight]
    x = "v"
    v = "-0.1*v - x + 2.5*cos(2.3*t)"
    y = "u"
    u = "-0.2*u - 0.3*y"
    [[contact]]
    name = "wall"
    gap = "0.4 - x"
    impulse = { v = -1 }
    restitution = 0.7
    friction = { coefficient = 0.2, along = { u = 1 } }
    [initial]
    x = 0
    v = 0.2
    y = 0
    u = 0
    "#;
    let found = orbit(&with(text, &[]));
    let period = found.period.to_f64();
    let w = 0.29_f64.sqrt();
    let swings = (-0.1 * period).exp() * ((w * period).cos() + 0.1 / w * (w * period).sin());
    let product = 0.49 * (-0.1 * period).exp();
    let m = &found.multipliers;
    assert_eq!(m.len(), 4);
    assert!(
        (m[0].modulus() * m[1].modulus() - product).abs() < 1e-9,
        "{m:?}"
    );
    assert!((m[2].re - swings).abs() < 1e-9, "{m:?} {swings}");
    assert_eq!(m[3].modulus(), 0.0);
}
