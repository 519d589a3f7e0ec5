//! Stays on a surface that come and go along a branch, and steps that would lead to another one.

use crate::periodic::{model, orbit, over, settles, value, with};
use chatter::analysis::periodic::{Branch, End, PeriodicError, SpecialKind};

/// A mass on dry ground that hits a stop: the rate that vanishes where an impact grazes is the one that friction turns with.
const ROUGH_GROUND: &str = r#"
[parameters]
omega = 0.8
[flight]
x = "v"
v = "cos(omega*t) - x - 0.04*v - 0.15*sign(v)"
[[contact]]
name = "stop"
gap = "0.4 - x"
impulse = { v = -1 }
restitution = 0.6
[initial]
x = 0
v = 0
"#;

fn points(branch: &Branch) -> Vec<(SpecialKind, f64)> {
    let mut all: Vec<_> = (branch.special.iter())
        .map(|special| (special.kind, value(special)))
        .collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

fn assert_points(branch: &Branch, expected: &[(SpecialKind, f64)], context: &str) {
    let found = points(branch);
    let is_same = |(a, b): (&(SpecialKind, f64), &(SpecialKind, f64))| {
        a.0 == b.0 && (a.1 - b.1).abs() < 1e-11 * b.1.abs()
    };
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(is_same),
        "{context}: {found:?}"
    );
}

/// Touches are where a stick of no length begins: 0.62963 and 0.67903 by an integrator of our own; at 0.55486 and 0.66609 the mass still goes
/// back before it sticks, and no more.
#[test]
fn a_branch_under_dry_friction_has_the_same_points_from_everywhere() {
    use SpecialKind::{Fold, ImpactGraze, Touch};
    let expected = [
        (Touch, 0.554_857_082_935_310_3),
        (Touch, 0.567_652_543_365_462_5),
        (ImpactGraze, 0.598_120_234_107_461_7),
        (Fold, 0.600_772_578_621_311_7),
        (Touch, 0.629_627_794_162_357_6),
        (Touch, 0.666_093_023_056_43),
        (Touch, 0.679_029_227_953_409_7),
        (ImpactGraze, 0.826_511_849_116_424_2),
        (Fold, 0.844_691_010_195_099_7),
    ];
    for (start, step) in [("0.8", 0.01), ("0.6", 0.01), ("0.7", 0.02)] {
        let model = with(ROUGH_GROUND, &[("omega", start)]);
        let found = over(&model, "omega", (0.54, 0.9), (40, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "from {start}");
        assert_points(&found[0], &expected, start);
    }
}

/// Two blocks on a belt: which of them leaves it first changes along the branch, and is nothing that ends it.
#[test]
fn two_ends_of_sticking_change_places() {
    let text = r#"
    [parameters]
    V = 0.5
    [definitions]
    first = "0.8*sign(v - V)/(1 + 2*abs(v - V))"
    second = "0.6*sign(u - V)/(1 + 2*abs(u - V))"
    [flight]
    x = "v"
    v = "-x - 0.7*(x - y) - 0.05*v - first"
    y = "u"
    u = "-y - 0.7*(y - x) - 0.05*u - second"
    [initial]
    x = 0.1
    v = 0
    y = -0.2
    u = 0
    "#;
    for start in ["0.3", "0.5"] {
        let model = with(text, &[("V", start)]);
        let found = over(&model, "V", (0.2, 0.95), (10, 0.01));
        assert_eq!(found[0].ends, [End::Range, End::Range], "from {start}");
        let doubling = (found[0].special.iter()).find(|s| s.kind == SpecialKind::PeriodDoubling);
        let doubling = doubling.map_or(f64::NAN, value);
        assert!((doubling - 0.212_138_067_595_685).abs() < 1e-12);
    }
}

/// The section is the surface at which the relay switches: which comes first is rounding. The period by the closed form of the
/// symmetric cycle.
#[test]
fn a_section_that_is_a_surface_of_the_model_splits_no_instant() {
    let found = orbit(&model("relay_feedback", &[]));
    assert!((found.period.high() - 3.679_750_670_864_798).abs() < 1e-13);
    let expected = [0.147_448_76, 0.000_108_911_22];
    for (multiplier, expected) in found.multipliers.iter().zip(expected) {
        assert!((multiplier.re / expected - 1.0).abs() < 1e-6 && multiplier.im == 0.0);
    }
}

/// Where branches lie close to each other, a long step that goes straight on may end on the other one.
#[test]
fn a_long_step_leads_to_no_other_branch() {
    let model = model("impact_oscillator", &[("omega", "3.0"), ("zeta", "-0.05")]);
    let [long, short] = [0.01, 0.004].map(|step| {
        let found = over(&model, "omega", (2.7, 3.3), (40, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "step {step}");
        points(&found[0])
    });
    assert!(long.len() > 30);
    assert_eq!(long.len(), short.len());
    for (a, b) in long.iter().zip(&short) {
        assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-11, "{a:?} {b:?}");
    }
}

/// A ball comes to rest on a shaken table and sticks where it does, which may be elsewhere: all of that is periodic, which is told though the place
/// of the table is zero wherever the force begins anew.
#[test]
fn what_sticks_to_a_shaken_table_for_ever_is_one_of_many() {
    for unit in [1e-3, 1.0, 1e3] {
        let text = format!(
            "[flight]\ny = 'v/{unit:?}'\nv = '(-9.81 - 2*y - 0.1*v)/{unit:?}'\nx = 'u/{unit:?}'\n\
             u = '(-2*x - 0.3*u + 0.5*cos(6.562*t/{unit:?}))/{unit:?}'\n[[contact]]\nname = 't'\n\
             gap = 'y - 0.7963/6.562*sin(6.562*t/{unit:?})'\nimpulse = {{ v = 1 }}\nrestitution = 0.3714\n\
             friction = {{ coefficient = 0.2105, along = {{ u = 1 }} }}\n[initial]\ny = 0.3\nv = 0\nx = 0.1\nu = 0\n"
        );
        let found = settles(&with(&text, &[]));
        assert!(
            matches!(found, Err(PeriodicError::OneOfMany { least }) if least < 1e-9),
            "{unit}: {found:?}"
        );
    }
}

/// An oscillator that is kicked where it passes a place, and forced, goes round a torus: its largest exponent is 0 within 1e-4. Its nearest return
/// is told, and not how corrections of what is no orbit end.
#[test]
fn motion_on_a_torus_does_not_repeat() {
    let text = "[flight]\nx = 'v'\nv = '-x - 0.1468*v - 0.3*x^3 + 0.2*cos(2.579*t)'\n\
                [[event]]\nname = 'kick'\nsurface = 'x - 0.1'\ndirection = 'rising'\nreset = { v = '0.9*v + 0.714', x = 'x + 0.05' }\n\
                [initial]\nx = 0\nv = 1\n";
    match settles(&with(text, &[])) {
        Err(PeriodicError::NotRepeated { nearest, .. }) => {
            assert!(nearest > 1e-7 && nearest < 1e-2)
        }
        found => panic!("{found:?}"),
    }
}
