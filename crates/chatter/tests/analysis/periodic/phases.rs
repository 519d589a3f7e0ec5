//! Orbits of what is driven through lookups, floors and steps, and of events that share an instant.

use super::{orbit, over, with};
use chatter::numerics::{Complex, Real};
use core::f64::consts::TAU;

fn near(found: Complex, (re, im): (f64, f64)) -> bool {
    (found.re - re).abs() + (found.im.abs() - im).abs() < 1e-9
}

/// A linear oscillator driven by a table: its multipliers are those without the drive.
#[test]
fn a_phase_in_a_table_alone_is_a_phase() {
    const DRIVEN: &str = r#"
[table.f]
x = [0, 1, 2, 3, 4, 5]
y = [0, 0.4, 1, 0.5, -0.3, 0]
kind = "periodic-cubic"
[flight]
ph = "3"
x = "v"
v = "-x - 0.1*v + f(ph)"
[initial]
ph = 0
x = 0
v = 0
"#;
    let found = orbit(&with(DRIVEN, &[]));
    let period = 5.0 / 3.0;
    assert!((found.period.to_f64() - period).abs() < 1e-14);
    let (size, turn) = ((-0.05_f64 * period).exp(), 0.9975_f64.sqrt() * period);
    let expected = (size * turn.cos(), size * turn.sin());
    assert_eq!(found.multipliers.len(), 2);
    assert!(
        near(found.multipliers[0], expected),
        "{:?}",
        found.multipliers
    );
}

/// An oscillator that settles slowly within the middle piece of its spring's table, x = Re F e^(i w t) / (1 - w^2 + 0.1 i w): it is told from the first turn of
/// its force, however late it has settled, and steps along the branch are not spent on when that was.
#[test]
fn an_orbit_beside_a_table_is_told_from_the_first_turn() {
    const MEASURED: &str = r#"
[parameters]
w = 1.8
[table.spring]
x = [-3, -1, -0.5, 0.5, 1, 3]
y = [-9, -1.5, -0.5, 0.5, 1.5, 9]
kind = "linear"
[flight]
x = "v"
v = "0.4*cos(w*t) - 0.1*v - spring(x)"
[section.strobe]
surface = "sin(w*t)"
direction = "rising"
[initial]
x = 0.1
v = 0
"#;
    let found = over(&with(MEASURED, &[]), "w", (1.7, 1.9), (8, 0.03)).swap_remove(0);
    assert!(found.points.len() < 60, "{}", found.points.len());
    for point in &found.points {
        let w = point.parameter();
        let (re, im) = (1.0 - w * w, 0.1 * w);
        let size = 0.4 / (re * re + im * im);
        let (x, v, t) = (point.state[0], point.state[1], point.state[2]);
        let off = (x - size * re).hypot(v - size * w * im);
        assert!(off < 1e-12, "{w}: {:?}", point.state);
        assert!((-1e-12..TAU / w + 1e-12).contains(&t), "{w}: {t}");
    }
}

#[test]
fn time_in_a_step_of_a_saw_alone_is_a_phase() {
    const SWITCHED: &str = r#"
[flight]
x = "v"
v = "-x - 0.1*v + step(0.4 - mod(t, 1))"
[initial]
x = 0
v = 0
"#;
    let found = orbit(&with(SWITCHED, &[]));
    assert!((found.period.to_f64() - 1.0).abs() < 1e-14);
    let (size, turn) = ((-0.05_f64).exp(), 0.9975_f64.sqrt());
    let expected = (size * turn.cos(), size * turn.sin());
    assert!(
        near(found.multipliers[0], expected),
        "{:?}",
        found.multipliers
    );
}

#[test]
fn a_saw_forgets() {
    const SAW: &str = "[flight]\nph = 1\nx = \"-x + mod(ph, 2)\"\n[initial]\nph = 0\nx = 0\n";
    let found = orbit(&with(SAW, &[]));
    assert!((found.period.to_f64() - 2.0).abs() < 1e-14);
    let [only] = &found.multipliers[..] else {
        panic!("{:?}", found.multipliers);
    };
    assert!((only.re - (-2.0_f64).exp()).abs() < 1e-14);
}

/// Force and reset change where x = 0: of the two the surface is crossed first, in each period.
#[test]
fn a_switch_and_a_reset_at_one_instant_keep_their_order() {
    const BOTH: &str = r#"
[parameters]
om = 1.7
[flight]
x = "v"
v = "-x - 0.2*v + cos(om*t) - 0.1*sign(x)"
[[event]]
name = "k"
surface = "x"
direction = "either"
reset = { v = "0.8*v" }
[initial]
x = 0.1
v = 0
"#;
    for om in ["0.7", "1.7", "2.3"] {
        let found = orbit(&with(BOTH, &[("om", om)]));
        let forcing = core::f64::consts::TAU / om.parse::<f64>().unwrap();
        let periods = found.period.to_f64() / forcing;
        assert!((periods - 1.0).abs() < 1e-12, "om = {om}: {periods}");
    }
}

/// A ball whose restitution falls with speed, in chaos: what it settles to by chance is no orbit that it stays at.
#[test]
fn chaos_is_not_stable() {
    const BALL: &str = r#"
[definitions]
table = "cos(3*t)/3"
[flight]
y = "v"
v = "-1"
[[contact]]
name = "table"
gap = "y - table"
impulse = { v = 1 }
restitution = "0.9/(1 + 0.3*abs(v + sin(3*t)))"
[initial]
y = 1
v = 0
"#;
    let found = orbit(&with(BALL, &[]));
    assert_eq!(found.multipliers.len(), 2);
    assert!(!found.is_stable());
}

/// What rounds away beside the largest multiplier is zero: right is 1.28e-19, by the product of all.
#[test]
fn multipliers_below_rounding_are_zero() {
    const DAMPER: &str = r#"
[flight]
x = "v"
v = "cos(0.9*t) - 0.04*v - x"
y = "w"
w = "0"
[[contact]]
name = "right"
gap = "1 - (y - x)"
impulse = { v = 0.1, w = -1 }
restitution = 0.6
[[contact]]
name = "left"
gap = "1 + (y - x)"
impulse = { v = -0.1, w = 1 }
restitution = 0.6
[initial]
x = 0
v = 1
y = 0.1
w = 0.5
"#;
    let found = orbit(&with(DAMPER, &[]));
    let last = found.multipliers.last().unwrap();
    assert_eq!((last.re, last.im), (0.0, 0.0), "{:?}", found.multipliers);
}

/// A wheel that an uneven field drags round with it, once a period: the angle turns, and it and its rate may be displaced. The product of
/// both multipliers is what damping leaves of an area.
#[test]
fn a_phase_that_is_driven_round_has_its_multiplier() {
    let text = r#"
[flight]
x = "v"
v = "-0.1*(v - 1) - 0.5*(sin(x)*cos(t) - 0.8*cos(x)*sin(t))"
[initial]
x = 0.1
v = 1
"#;
    let found = super::orbit(&super::with(text, &[]));
    let [one, other] = &*found.multipliers else {
        panic!("{:?}", found.multipliers);
    };
    let product = one.re * other.re - one.im * other.im;
    let left = (-0.2 * core::f64::consts::PI).exp();
    assert!((product - left).abs() < 1e-12, "{product}");
}

/// A force of no size drives nothing: the cycle is that of the equations without it, whatever its clock, and beside it, as the force grows, orbits have
/// its period.
#[test]
fn a_force_of_no_size_is_no_clock() {
    let kicked = |force: &str| {
        let text = format!(
            "[parameters]\nF = 0\n[flight]\nx = 'u'\nu = '-0.1*u - sin(x){force}'\n[[event]]\nname = 'kick'\n\
             surface = 'x - 0.05'\ndirection = 'rising'\nreset = {{ u = 'u + 0.25*(1 - 0.3*u)' }}\n[initial]\nx = 1\nu = 0\n"
        );
        with(&text, &[])
    };
    let (driven, alone) = (kicked(" + F*cos(t)"), orbit(&kicked("")));
    let found = orbit(&driven);
    assert!((found.period - alone.period).to_f64().abs() < 1e-12);
    assert!((found.multipliers[0].re - alone.multipliers[0].re).abs() < 1e-10);
    let branches = over(&driven, "F", (0.1, 0.3), (4, 0.1));
    let mut periods = branches[0].points.iter().map(|point| point.period);
    assert!(periods.all(|period| (period - TAU).abs() < 1e-12));
}
