//! Impacts whose friction stops what slides along the wall, and complete chatter that steps do not apply by themselves.

use crate::periodic::differences::{agree, differences};
use crate::periodic::{nearest, orbit, over, with};
use chatter::analysis::periodic::{End, SpecialKind};
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

/// A mass that bounces on a shaken table until it rests, and slides along it.
const ROUGH_TABLE: &str = r#"
[parameters]
A = 1.2
V = 5
[flight]
y = "v"
v = "-1 - 0.4*y - 0.1*u"
x = "u"
u = "-0.3*u - 0.8*x + 0.2*cos(1.7*t)"
[[contact]]
name = "table"
gap = "y - A*sin(1.7*t)/1.7^2"
impulse = { v = 1 }
restitution = 0.5
friction = { coefficient = 0.3, along = { u = 1 }, rate = "u - V" }
[initial]
y = 0.8
v = 0
x = 0
u = 0
"#;

/// Sliding all the time, or sticking between a stick and a slip, or from the end of chatter on.
#[test]
fn complete_chatter_at_a_rough_wall_has_the_multipliers_of_differences() {
    for set in [
        &[][..],
        &[("V", "0.4")],
        &[("V", "0.4"), ("A", "1.7")],
        &[("V", "0.4"), ("A", "1.85")],
    ] {
        let model = with(ROUGH_TABLE, set);
        let found = orbit(&model);
        assert_eq!(found.impacts, None, "{set:?}");
        assert!(found.residual < 1e-28, "{}", found.residual);
        agree(&found, &differences(&model, &found));
    }
}

/// What slides along feels nothing but the impulses of friction, which do not depend on it.
#[test]
fn friction_in_chatter_does_not_remember_the_rate_of_sliding() {
    let free = ROUGH_TABLE.replace(" - 0.1*u", "").replace(" - 0.8*x", "");
    let model = with(
        &free
            .replace("x = \"u\"\n", "")
            .replace("x = 0\n", "")
            .replace("0.3*u", "u"),
        &[],
    );
    let found = orbit(&model);
    let expected = (-found.period.to_f64()).exp();
    assert!(
        (found.multipliers[0].re - expected).abs() < 1e-13,
        "{:?} {expected}",
        found.multipliers
    );
}

/// What a rough table stops at each impact has no derivative there: what rounding leaves of one must not keep chatter from its end. The
/// multiplier that is not lost is that of differences by a program of its own, with flights by a Runge-Kutta method of order 8.
#[test]
fn chatter_ends_where_each_impact_stops_the_sliding() {
    let text = r#"
    [parameters]
    r = 0.15
    [flight]
    y = "v"
    v = "-10"
    x = "u"
    u = "-2*x - 0.3*u + 0.5*cos(4.8*t)"
    [[contact]]
    name = "table"
    gap = "y - 2.9/4.8*sin(4.8*t)"
    impulse = { v = 1 }
    restitution = "r"
    friction = { coefficient = 0.5, along = { u = 1 } }
    [initial]
    y = 0.3
    v = 0
    x = 0.1
    u = 0
    "#;
    for (r, multiplier) in [("0.1", 0.586_667_229_157), ("0.15", 0.586_112_074_27)] {
        let found = orbit(&with(text, &[("r", r)]));
        let m = &found.multipliers;
        assert!(
            (m[0].re - multiplier).abs() < 1e-9 && m[0].im == 0.0,
            "{m:?}"
        );
        assert!(m[1..].iter().all(|lost| lost.modulus() == 0.0), "{m:?}");
    }
}

/// A parcel on a conveyor: each of its impacts stops its sliding, so that it sticks from the end of chatter on. How it bounces has
/// nothing to do with how it slides, and the branch of what bounces alone ends at the same border.
#[test]
fn a_branch_goes_on_while_impacts_stop_the_sliding() {
    let rough = r#"
    [parameters]
    B = 1.9
    [flight]
    u = "1.3*cos(t + 0.5)"
    y = "v"
    v = "B*cos(t) - 1"
    [[contact]]
    name = "trough"
    gap = "y"
    impulse = { v = 1 }
    restitution = 0.2
    friction = { coefficient = 0.4, along = { u = 1 } }
    [initial]
    u = 0
    y = 0
    v = 0
    "#;
    let smooth: String = (rough.lines())
        .filter(|line| !line.contains("friction"))
        .map(|line| line.replace("u = \"1.3*cos(t + 0.5)\"", "u = \"-u\"") + "\n")
        .collect();
    let border_of = |text: &str| {
        let found = over(&with(text, &[]), "B", (1.7, 2.18425), (6, 0.01));
        assert_eq!(found[0].ends, [End::Range, End::ChatterBorder]);
        assert!(found[0].points.len() < 500, "{}", found[0].points.len());
        super::super::value(&nearest(&found, &[SpecialKind::ChatterBorder], 2.18))
    };
    let (of_both, alone) = (border_of(rough), border_of(&smooth));
    assert!((of_both - alone).abs() < 1e-9, "{of_both} {alone}");
}

/// Where each flight crosses a surface of the field, as the top of a flight under drag does.
#[test]
fn complete_chatter_across_surfaces_has_the_multipliers_of_differences() {
    for force in ["0.2*v*abs(v)", "0.08*sign(v - 0.3*cos(1.7*t))"] {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"-1 - {force} - 0.3*z\"\nz = \"v - z + 0.2*cos(1.7*t)\"\n\
             [[contact]]\nname = \"table\"\ngap = \"y - 1.2*sin(1.7*t)/1.7^2\"\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
             [initial]\ny = 0.8\nv = 0\nz = 0\n"
        );
        let model = with(&text, &[]);
        let found = orbit(&model);
        assert_eq!(found.impacts, None, "{force}");
        agree(&found, &differences(&model, &found));
    }
}

/// A ball with spin that friction stops from sliding at each impact, by which u + s vanishes but for rounding of what it was: in a flight u and s
/// die out at the rates 0.3 and 0.2, and friction changes them along (1, 2.5).
#[test]
fn friction_stops_two_states_at_once() {
    let text = r#"
[parameters]
G = 2
[flight]
u = "-0.3*u + 0.2*cos(t)"
s = "-0.2*s"
y = "v"
v = "-1"
[[contact]]
name = "floor"
gap = "y - G*sin(t)"
impulse = { v = 1 }
restitution = 0.3
friction = { coefficient = 0.3, along = { u = 1, s = 2.5 }, rate = "u + s" }
[initial]
u = 0.9
s = 0
y = 1
v = 0
"#;
    let found = orbit(&with(text, &[]));
    assert_eq!(found.impacts, Some(1));
    let period = found.period.to_f64();
    let (u, s) = ((-0.3 * period).exp(), (-0.2 * period).exp());
    let expected = (2.5 * u + s) / 3.5;
    let off = |m: &chatter::numerics::Complex| (m.re - expected).hypot(m.im);
    let nearest = found
        .multipliers
        .iter()
        .map(off)
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-12, "{:?} {expected}", found.multipliers);
}
