//! Touches of surfaces and of the limits of sticking: where the motion has one, and nowhere else.

use crate::periodic::{orbit, over, value, with};
use chatter::analysis::periodic::{Branch, End, MarginKind, SpecialKind};
use core::f64::consts::TAU;

/// A block on a shaking table whose normal force varies.
const SHAKEN: &str = r#"
[parameters]
A = 0.6
B = 0.3
ph = 0.7
mu = 0.3
[flight]
u = "-mu*(1 - A*sin(t))*sign(u - B*cos(t + ph))"
[section.strobe]
surface = "sin(t)"
direction = "rising"
[initial]
u = 0.2
"#;

/// The same where a contact carries the block, and friction is that of the contact.
pub(in crate::periodic) const CONVEYED: &str = r#"
[parameters]
A = 0.6
B = 0.3
ph = 0.7
mu = 0.3
[flight]
x = "u"
u = "0"
y = "v"
v = "-1"
[[contact]]
name = "plane"
gap = "y - A*sin(t)"
impulse = { v = 1 }
restitution = 0.2
friction = { coefficient = "mu", along = { u = 1 }, rate = "u - B*cos(t + ph)" }
[section.strobe]
surface = "sin(t)"
direction = "rising"
[initial]
x = 0
u = 0
y = 0
v = "A"
"#;

fn touches(branch: &Branch, context: &str) -> Vec<f64> {
    let is_touch = |kind: SpecialKind| kind == SpecialKind::Touch;
    assert!(
        branch.special.iter().all(|special| is_touch(special.kind)),
        "{context}: {:?}",
        branch.special
    );
    let mut all: Vec<f64> = branch.special.iter().map(value).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn assert_near(found: &[f64], expected: &[f64], context: &str) {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(is_near),
        "{context}: {found:?}"
    );
}

/// The block sticks while B |sin(t + ph)| is less than mu (1 - A sin t), which the one reaches at two values of B, on one side each; the
/// others, where a stick has no length, by an exact integration.
fn of_the_block() -> [f64; 4] {
    let (a, ph, mu): (f64, f64, f64) = (0.6, 0.7, 0.3);
    let (middle, half) = (
        (mu * mu - (mu * a * ph.sin()).powi(2)).sqrt(),
        mu * a * ph.cos(),
    );
    [
        middle - half,
        middle + half,
        0.436_703_604_744_41,
        0.889_334_989_657_669,
    ]
}

fn check_the_block(model: &str, walks: &[(&str, f64)]) {
    for &(start, step) in walks {
        let context = format!("from {start} by {step}");
        let found = over(&with(model, &[("B", start)]), "B", (0.1, 3.0), (4, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{context}");
        assert_near(&touches(&found[0], &context), &of_the_block(), &context);
    }
}

/// Where steps begin on a surface that they have just crossed, rounding says on which side.
#[test]
fn dry_friction_has_the_same_touches_from_everywhere() {
    let walks = [("0.12", 0.02), ("0.3", 0.01), ("1", 0.01), ("1", 0.003)];
    check_the_block(SHAKEN, &walks);
}

#[test]
fn friction_of_contacts_has_the_same_touches_as_a_surface() {
    check_the_block(CONVEYED, &[("0.3", 0.01), ("1.2", 0.01)]);
}

/// A neuron that integrates, leaks and fires at a threshold which swings: with V = I (1 - exp(-2 pi/w)) before each reset, the orbit folds at
/// A = |V - 1| and fires at a tangent at A^2 = ((I - V)/w)^2 + (V - 1)^2, beyond which there is none.
#[test]
fn an_event_that_is_only_touched_ends_the_branch_once() {
    let text = r#"
    [parameters]
    I = 1.5
    A = 0.2
    w = 6.0
    [flight]
    v = "I - v"
    [[event]]
    name = "fire"
    surface = "v - 1 - A*sin(w*t)"
    direction = "rising"
    reset = { v = "0" }
    [initial]
    v = 0.0
    "#;
    let found = over(&with(text, &[]), "A", (0.0, 0.6), (4, 0.01));
    let fires = 1.5 * (1.0 - (-TAU / 6.0_f64).exp());
    let expected = [
        (SpecialKind::Touch, ((1.5 - fires) / 6.0).hypot(fires - 1.0)),
        (SpecialKind::Fold, (fires - 1.0).abs()),
    ];
    let special = &found[0].special;
    assert_eq!(special.len(), 2, "{special:?}");
    for (special, (kind, at)) in special.iter().zip(expected) {
        assert_eq!(special.kind, kind);
        assert!((value(special) - at).abs() < 1e-14, "{special:?}");
    }
    assert!(matches!(found[0].ends[0], End::Lost(_)));
    assert_eq!(found[0].ends[1], End::Range);
}

/// A thermostat with two lags: the temperature falls through `ref - h` ever slower, and touches nothing.
#[test]
fn an_event_that_leaves_the_state_on_its_surface_is_not_touched_at_once() {
    let text = r#"
    [parameters]
    k = 3.0
    h = 0.2
    ref = 0.2001
    tau = 0.5
    [flight]
    x = "y - x"
    y = "(k*q - y)/tau"
    q = "0"
    [[event]]
    name = "off"
    surface = "x - ref - h"
    direction = "rising"
    reset = { q = "0" }
    [[event]]
    name = "on"
    surface = "x - ref + h"
    direction = "falling"
    reset = { q = "1" }
    [initial]
    x = 0.0
    y = 0.0
    q = 1
    "#;
    let found = over(&with(text, &[]), "ref", (0.200_001, 0.2002), (4, 0.03));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    assert!(found[0].special.is_empty(), "{:?}", found[0].special);
}

/// All touches of a branch over w that goes through its range, with every change one that persists.
fn all_through(model: &str, (start, range, step): (&str, (f64, f64), f64)) -> Vec<f64> {
    let context = format!("from {start} by {step}");
    let found = over(&with(model, &[("w", start)]), "w", range, (4, step));
    assert_eq!(found[0].ends, [End::Range, End::Range], "{context}");
    for special in &found[0].special {
        assert_eq!(special.persists, Some(true), "{context}: {special:?}");
    }
    touches(&found[0], &context)
}

/// A rotor whirls beside a soft stator, pulled down a little: it touches where 0.9 is the radius of its free whirl, with s = w^2
/// 9 ((1 - s)^2 + 0.04 s) = s^2. Of the stays at the stator that begin and end farther on several are short at once.
#[test]
fn a_rotor_has_the_same_touches_whichever_way_it_comes() {
    let text = r#"
    [parameters]
    w = 0.97
    [definitions]
    rr = "hypot(x, y)"
    fn = "5*max(1 - 1/rr, 0)"
    [flight]
    x = "u"
    u = "-0.2*u - x + 0.3*w^2*cos(w*t) - fn*x"
    y = "v"
    v = "-0.2*v - y + 0.3*w^2*sin(w*t) - fn*y - 0.1"
    [section.strobe]
    surface = "sin(w*t)"
    direction = "rising"
    [initial]
    x = 0.1
    u = 0.0
    y = 0.1
    v = 0.0
    "#;
    let s = (17.64 - (17.64_f64 * 17.64 - 4.0 * 8.0 * 9.0).sqrt()) / 16.0;
    let expected = [s.sqrt(), 0.975_873_182_359_320_6, 0.977_018_684_516_001_3];
    for (start, step) in [("0.97", 0.03), ("0.92", 0.05)] {
        let found = all_through(text, (start, (0.88, 0.99), step));
        assert_near(&found, &expected, start);
    }
}

/// Where the way back to the belt takes no time the equations are solved by no time at all, too, and say nothing of where the touch is.
#[test]
fn a_slip_that_comes_to_nothing_is_one_touch_at_all_steps() {
    let text = r#"
    [parameters]
    w = 0.93
    [flight]
    x = "v"
    v = "-x - 0.1*v - 0.3*sign(v - 0.2) + 1.5*cos(w*t)"
    [[contact]]
    name = "stop"
    gap = "0.8 - x"
    impulse = { v = -1 }
    restitution = 0.7
    [section.z]
    surface = "cos(w*t)"
    direction = "rising"
    [initial]
    x = 0
    v = 0
    "#;
    let expected = [0.948_092_428_095_925, 0.970_804_957_367_472];
    for (start, step) in [("0.93", 0.02), ("0.93", 0.05), ("0.99", 0.05)] {
        assert_near(
            &all_through(text, (start, (0.9, 1.0), step)),
            &expected,
            start,
        );
    }
}

/// The force of a lift that begins with a corner touches there the value at which a check valve opens.
#[test]
fn a_surface_that_is_touched_by_a_corner_of_the_field_is_told() {
    let text = r#"
    [parameters]
    w = 19.2
    [definitions]
    lift = "max(-0.02 + 0.03*sin(w*t), 0)"
    f = "max(8000*(lift + l - y), 0)"
    [flight]
    y = "v"
    v = "f - 400*y - 30 - 5*v"
    l = "-f/80000 + if(f < 50, 4*(0.002 - (l-y)), 0)"
    [initial]
    y = 0.05
    v = 0
    l = 0.06
    "#;
    for step in [0.05, 0.2] {
        let found = all_through(text, ("19.2", (19.16, 19.21), step));
        assert_near(&found, &[19.172_557_924_786_36], "by the corner");
    }
}

/// A capsule that moves itself by a mass inside: where its stick is left for an instant, and comes back at once. Its touches are the same from
/// everywhere and at all steps, and no branches meet there.
#[test]
fn a_stick_that_is_left_for_an_instant_is_one_touch_at_all_steps() {
    let text = "[parameters]\nom = 1.081\nal = 1.759\n[flight]\nx = 'y'\np = 'q'\n\
                y = 'al*cos(om*t) - x + p - 2*0.04298*(y - q) - 10.24*max(x - p - 0.05, 0)'\n\
                q = '(x - p + 2*0.04298*(y - q) + 10.24*max(x - p - 0.05, 0) - 0.9503*sign(q))/3.56'\n\
                [section.strobe]\nsurface = 'sin(om*t)'\ndirection = 'rising'\n[initial]\nx = 0\ny = 0.1\np = 0\nq = 0\n";
    let expected = [
        1.100_299_640_258_281,
        1.166_271_099_105_743,
        1.425_999_412_261_856,
        1.797_287_768_820_052,
    ];
    for (start, high, step) in [
        ("1.15", 2.5, 0.02),
        ("1.759", 2.5, 0.02),
        ("1.759", 1.9, 0.04),
    ] {
        let context = format!("from {start} to {high} by {step}");
        let found = over(
            &with(text, &[("al", start)]),
            "al",
            (1.098, high),
            (4, step),
        );
        assert_eq!(found[0].ends, [End::Range, End::Range], "{context}");
        assert_near(&touches(&found[0], &context), &expected, &context);
    }
}

/// A capsule that a mass inside drives by a spring, dampers and a stop, on a floor with dry friction. Where one touch is come to Newton's method goes from
/// there to the next one, a thousandth of the range on: nothing comes of that, and it is told where it is come to, whichever way.
#[test]
fn touches_are_told_in_order_whichever_way_they_are_come_to() {
    const CAPSULE: &str = "[parameters]\nal = 1.398\n[flight]\nx = 'y'\n\
        y = 'al*cos(1.221*t) - x + p - 0.12458*(y - q) - 13.91*max(x - p - 0.05, 0)'\np = 'q'\n\
        q = '(x - p + 0.12458*(y - q) + 13.91*max(x - p - 0.05, 0) - 0.6179*sign(q))/2.472'\n\
        [section.strobe]\nsurface = 'sin(1.221*t)'\ndirection = 'rising'\n[initial]\nx = 0\ny = 0.1\np = 0\nq = 0\n";
    let range = (0.9, 2.5);
    let up = over(&with(CAPSULE, &[]), "al", range, (80, 0.012));
    let mut model = with(CAPSULE, &[("al", "2.1234862686280342")]);
    for (state, start) in [
        ("x", "1.5762845165254946"),
        ("y", "1.6392911315301741"),
        ("p", "1.0910040338488685"),
        ("q", "-0.04781072915421519"),
    ] {
        model.set_initial(state, start).unwrap();
    }
    let touches = |found: &[Branch]| -> Vec<f64> {
        let all = found[0].special.iter();
        let touches = all.filter(|special| special.kind == SpecialKind::Touch);
        touches.map(value).collect()
    };
    let first = touches(&up);
    assert!(first.len() > 2 && first.is_sorted(), "{first:?}");
    for step in [0.0119, 0.02, 0.006] {
        let other = touches(&over(&model, "al", range, (80, step)));
        let off = first.iter().zip(&other).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(
            first.len() == other.len() && off < 1e-12,
            "{step}: {first:?} {other:?}"
        );
    }
}

/// Contacts open with no rate and no acceleration, and what rounding leaves of these lets the gap begin below zero: the flight to the first
/// impact has no least gap. The table falls away from the ball where f (cos t + 0.05 sin t) is 1.
#[test]
fn a_contact_that_opens_is_not_touched_where_it_does() {
    for (unit, time) in [(1.0, 1.0), (1e3, 1e-2)] {
        let text = format!(
            "[parameters]\nf = 1\n[flight]\nx = 'v'\nv = '-{} - {}*v'\n[[contact]]\nname = 'table'\n\
             gap = 'x - {unit}*f*cos(t/{time})'\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n\
             [initial]\nx = '{unit}*f'\nv = 0\n",
            unit / (time * time),
            0.05 / time
        );
        let model = with(&text, &[("f", "1.01")]);
        let branch = over(&model, "f", (0.99, 1.01), (80, 0.01)).swap_remove(0);
        let found = touches(&branch, "opening");
        assert_near(&found, &[1.0 / 1.0025_f64.sqrt()], "opening");
        for f in ["1", "1.0005", "1.002", "1.006"] {
            let found = orbit(&with(&text, &[("f", f)]));
            let mut kinds = found.margins.iter().map(|margin| margin.kind);
            assert!(
                kinds.all(|kind| kind != MarginKind::LeastGap),
                "{f}: {found:?}"
            );
        }
    }
}
