//! Orbits against reference values in quadruple precision, and against laws.

use super::{model, nearest, orbit, orbits_from, over, settles, value, with};
use chatter::analysis::border::BorderSpec;
use chatter::analysis::border_search::border_near;
use chatter::analysis::periodic::{MarginKind, PeriodicError, Spec, SpecialKind, settled};
use chatter::analysis::universal::Universal;
use chatter::numerics::Real;
use proptest::prelude::*;
use std::ops::ControlFlow;

pub const VALVE4: &str = r#"
[parameters]
q = 0.019
kappa = 1.25
delta = 10
beta = 20
gamma = 0.3
c = 0.004
r = 0.6
[flight]
y1 = "y2"
y2 = "-kappa*y2 - y1 - delta + y3"
y3 = "beta*(y4 - y1*sqrt(y3))"
y4 = "gamma*(q - y4 - c*(y3 - delta))"
[[contact]]
gap = "y1"
impulse = { y2 = 1 }
restitution = "r"
[initial]
y1 = 0
y2 = 0
y3 = 10
y4 = 0.019
"#;

/// Of four states complete chatter leaves one multiplier beside the trivial one.
#[test]
fn a_valve_of_four_states_with_complete_chatter() {
    let orbit = orbit(&with(VALVE4, &[]));
    assert_eq!(orbit.impacts, None);
    // The matrix exponential of the linear field in contact, from where chatter ends to the release.
    assert!((orbit.period.to_f64() - 3.037_206_317_799_137).abs() < 1e-12);
    let found = orbit.multipliers[0];
    assert!(
        (found.re - 0.427_687_267_438_056_3).abs() < 1e-10,
        "{found:?}"
    );
    assert!(orbit.multipliers[1..].iter().all(|m| m.modulus() == 0.0));
}

fn border_margin(model: &chatter::model::Model, section: Option<usize>) -> Option<f64> {
    let spec = Spec {
        section,
        ..Spec::default()
    };
    let found = settled(model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    let mut margins = found.margins.iter();
    let border = margins.find(|margin| margin.kind == MarginKind::Border)?;
    assert!((0.0..found.period.to_f64()).contains(&border.time));
    Some(border.value)
}

/// Where the orbit begins at the release point X is M times how far the parameter is from the border, and beyond it X lies on the
/// lap of the universal map whose number is that of the impacts.
#[test]
fn the_margin_of_a_border_is_its_coordinate() {
    let at = |q: f64| model("pressure_relief_valve", &[("q", &format!("{q:?}"))]);
    let valve = at(0.02);
    let border = border_near::<f64>(&valve, &BorderSpec::new("q"), 0.02).unwrap();
    let (value, slope) = (border.value.value, border.exact.unfolding_rate.value);
    for (off, tolerance) in [(-1e-5, 0.05), (-1e-6, 0.02), (-1e-7, 0.01), (-1e-8, 0.005)] {
        let model = at(value + off);
        let found = border_margin(&model, None).unwrap() / (slope * off);
        assert!((found - 1.0).abs() < tolerance, "{off}: {found}");
        for section in 0..model.sections.len() {
            let other = border_margin(&model, Some(section)).unwrap() / (slope * off);
            assert!((other - found).abs() < 1e-6, "{section}: {found} {other}");
        }
    }
    let universal = Universal::<f64>::new(0.8).unwrap();
    let (end, eta) = (universal.lap_end(), universal.constants().eta);
    for (q, impacts) in [(0.0203, 34), (0.02019, 37), (0.0201, 42)] {
        let model = at(q);
        let found = border_margin(&model, None).unwrap();
        let lap = (found / end).ln() / eta.ln();
        let number = orbit(&model).impacts.unwrap();
        assert_eq!(number, impacts);
        assert!(
            (f64::from(impacts as i32) - 2.0..=f64::from(impacts as i32)).contains(&lap),
            "{q}: {found}, lap {lap}"
        );
    }
    // What never comes near release has none.
    let dropped = model("impact_oscillator", &[("omega", "2.8")]);
    assert_eq!(border_margin(&dropped, None), None);
}

/// A block on a seesaw chatters against its end until friction holds it in the air: the margin is -b/a where chatter ends, of the accelerations of fall and rise, down to
/// where its last impacts are rounding.
#[test]
fn the_margin_of_chatter_against_friction_is_what_flights_fall_with() {
    const SEESAW: &str = "[parameters]\nw = 1\n[definitions]\nth = '0.5*sin(w*t)'\n[flight]\nx = 'u'\n\
        u = '-sin(th) + x*(0.5*w*cos(w*t))^2 - 0.2*cos(th)*sign(u)'\n[[contact]]\nname = 'right'\ngap = '1.5 - x'\nimpulse = { u = -1 }\n\
        restitution = 0.4\n[[contact]]\nname = 'left'\ngap = '1.5 + x'\nimpulse = { u = 1 }\nrestitution = 0.4\n[initial]\nx = 0\nu = 0\n";
    for w in [1.1_f64, 1.03, 0.94, 0.93961, 0.939609665] {
        let found = orbit(&with(SEESAW, &[("w", &w.to_string())]));
        let mut margins = found.margins.iter();
        let border = margins.find(|margin| margin.kind == MarginKind::Border);
        let border = border.unwrap_or_else(|| panic!("{w}: {:?}", found.margins));
        let time = found.start[2].to_f64() + border.time;
        let (tilt, turns) = (0.5 * (w * time).sin(), 0.5 * w * (w * time).cos());
        let (pull, friction) = (-tilt.sin() - 1.5 * turns * turns, 0.2 * tilt.cos());
        let expected = -(pull + friction) / (pull - friction);
        let off = (border.value - expected).abs();
        assert!(off < 1e-12, "{w}: {} {expected}", border.value);
    }
}

/// Of an orbit that begins at rest on the contact, whatever rounding has left beside it there.
#[test]
fn an_orbit_that_begins_on_its_contact_has_a_margin_at_every_distance() {
    const TWO_MASSES: &str = "[parameters]\nw = 0.35\n[flight]\nx = 'v'\nv = '-x - 0.15*v + 0.6*(y - x) + cos(w*t)'\n\
        y = 'u'\nu = '(0.6*(x - y) - 0.15*u)/0.5'\n[[contact]]\ngap = '-y'\nimpulse = { u = -1 }\nrestitution = 0.8\n\
        [section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0\nv = 0\ny = -0.5\nu = 0\n";
    let at = |w: f64| with(TWO_MASSES, &[("w", &format!("{w:?}"))]);
    let border = border_near::<f64>(&at(0.3833), &BorderSpec::new("w"), 0.3833).unwrap();
    let (value, slope) = (border.value.value, border.exact.unfolding_rate.value);
    for (part, tolerance) in [(1e-3, 0.12), (3e-4, 0.07), (1e-4, 0.05), (1e-5, 0.02)] {
        let off = -part * value;
        let found = border_margin(&at(value + off), None).expect("a border") / (slope * off);
        assert!((found - 1.0).abs() < tolerance, "{part}: {found}");
    }
}

/// Where the motion comes back to nothing, an orbit of few periods beside it is told.
#[test]
fn chaos_and_tori_have_short_orbits() {
    for omega in ["2.35", "2.4", "2.7"] {
        let text = "[parameters]\nw = 2.4\n[flight]\nx = 'v'\nv = '-x - 0.1*v + cos(w*t)'\n[[contact]]\ngap = '0.15 - x'\n\
            impulse = { v = -1 }\nrestitution = '0.8/(1 + 0.2*v^2)'\n[initial]\nx = 0\nv = 0\n";
        let found = orbit(&with(text, &[("w", omega)]));
        let periods =
            found.period.to_f64() * omega.parse::<f64>().unwrap() / core::f64::consts::TAU;
        assert!(
            (periods - periods.round()).abs() < 1e-12 && periods < 4.5,
            "{periods}"
        );
        assert!(found.residual < 1e-25);
    }
}

/// A section is no part of the motion: multipliers and period are the same wherever they are taken.
#[test]
fn no_section_changes_an_orbit() {
    let of = |level: &str| {
        let mut model = model("pressure_relief_valve", &[("q", "0.0203")]);
        model.sections[0].surface = model.parse_expression(level).unwrap();
        orbit(&model)
    };
    let (a, b) = (of("y3 - 9.7"), of("y3 - 9.5"));
    assert!(a.start != b.start);
    assert!((a.period.to_f64() - b.period.to_f64()).abs() < 1e-14);
    for (m, n) in a.multipliers.iter().zip(&b.multipliers) {
        assert!((m.re - n.re).abs() + (m.im - n.im).abs() < 1e-12);
    }
}

/// x' = v, v' = -x - 2 zeta v + F cos(w t) without a wall: the closed solution, and e^(-2 zeta P) for both multipliers.
#[test]
fn without_contact_the_multipliers_are_those_of_the_linear_system() {
    let text = "[flight]\nx = 'v'\nv = '-x - 0.1*v + cos(1.3*t)'\n[initial]\nx = 0\nv = 0\n";
    let found = orbit(&with(text, &[]));
    let period = core::f64::consts::TAU / 1.3;
    assert!((found.period.to_f64() - period).abs() < 1e-14);
    let modulus = (-0.05 * period).exp();
    for m in &found.multipliers {
        assert!((m.modulus() - modulus).abs() < 1e-12, "{m:?}");
    }
    let denominator = (1.0 - 1.69_f64).powi(2) + (0.13_f64).powi(2);
    let phase = 1.3 * found.start[2].to_f64();
    let x = ((1.0 - 1.69) * phase.cos() + 0.13 * phase.sin()) / denominator;
    assert!((found.start[0].to_f64() - x).abs() < 1e-12);
}

/// Den Hartog's amplitude, and one period of the forcing however the section lies to the switch.
#[test]
fn dry_friction_turns_at_den_hartogs_amplitude() {
    let found = orbit(&model("forced_coulomb_oscillator", &[]));
    assert!((found.period.to_f64() - core::f64::consts::TAU / 0.6).abs() < 1e-13);
    assert!((found.start[0].to_f64().abs() - 1.535_601_809_280_87).abs() < 1e-12);
    assert!(found.is_stable());
}

/// Where everything rests there is no orbit, and a period of what has none is refused.
#[test]
fn what_is_no_orbit_is_said() {
    let error = settled(&model("bouncing_ball", &[]), &Spec::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_err();
    assert!(error.to_string().contains("comes to rest"), "{error}");
    let given = Spec {
        period: Some("2".to_owned()),
        ..Spec::default()
    };
    let valve = model("pressure_relief_valve", &[]);
    let error = settled(&valve, &given, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(
        error.to_string().contains("do not depend on time"),
        "{error}"
    );
    // An angle that is driven around besides: with equal states the spring is not what it was.
    let text = "[flight]\nth = 'om'\nom = '0.5*t - th - 0.3*om - 0.4*sign(om) + 0.1*cos(2*t)'\n[initial]\nth = 0\nom = 0.5\n";
    let half = Spec {
        period: Some("pi".to_owned()),
        ..Spec::default()
    };
    let error = settled(&with(text, &[]), &half, &mut |_| ControlFlow::Continue(()));
    assert!(matches!(error, Err(PeriodicError::NoRepeat { .. })));
    let oscillator = model("impact_oscillator", &[]);
    let error = settled(&oscillator, &given, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(error.to_string().contains("repeat after"), "{error}");
}

/// An orbit of many impacts stretches by thousands one way: what the other way is left does not drown in its rounding. By
/// Liouville their product is what volumes shrink by.
#[test]
fn small_multipliers_do_not_drown_in_large_ones() {
    let text = "[flight]\nx = 'v'\nv = '-x - 0.362946697614734*v + cos(2.2757224799201263*t)'\n[[contact]]\n\
        gap = '0.2207665698688728 - x'\nimpulse = { v = -1 }\nrestitution = 0.3\n[initial]\nx = -0.5\nv = 0\n";
    let found = orbits_from(&with(text, &[]), (12, 12, 1));
    let mut most = 0.0_f64;
    for orbit in &found {
        let [large, small] = orbit.multipliers[..] else {
            panic!("{:?}", orbit.multipliers);
        };
        let impacts = orbit.impacts.unwrap();
        let logarithm =
            -0.362946697614734 * orbit.period.to_f64() + 2.0 * impacts as f64 * 0.3_f64.ln();
        let product = large.re * small.re - large.im * small.im;
        assert!(
            (product.abs().ln() - logarithm).abs() < 1e-6,
            "{product:e} {logarithm}"
        );
        most = most.max(large.modulus());
    }
    assert!(most > 500.0, "{most}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Liouville: the product of multipliers is what a period shrinks volumes by, e^(-c P) r^2 for each impact.
    #[test]
    fn volumes_shrink_as_they_must(
        c in 0.02_f64..0.4,
        r in 0.3_f64..0.9,
        omega in 1.7_f64..2.6,
        sigma in -0.2_f64..0.4,
    ) {
        let text = format!(
            "[flight]\nx = 'v'\nv = '-x - {c:?}*v + cos({omega:?}*t)'\n[[contact]]\ngap = '{sigma:?} - x'\n\
             impulse = {{ v = -1 }}\nrestitution = {r:?}\n[initial]\nx = -0.5\nv = 0\n"
        );
        let found = settles(&with(&text, &[]));
        if let Ok(orbit) = found
            && let Some(impacts) = orbit.impacts
        {
            let product = orbit.multipliers.iter().fold((1.0, 0.0), |(re, im), m| {
                (re * m.re - im * m.im, re * m.im + im * m.re)
            });
            let expected = (-c * orbit.period.to_f64()).exp() * r.powi(2 * impacts as i32);
            prop_assert!((product.0 - expected).abs() < 1e-10, "{} {}", product.0, expected);
            prop_assert!(orbit.residual < 1e-20);
        }
    }
}

/// Every orbit of one period of a linear oscillator with one impact solves a quadratic: both are found, and no more.
#[test]
fn all_orbits_of_one_impact_are_found() {
    let model = model("impact_oscillator", &[("omega", "2.7"), ("r", "0.8")]);
    let found = orbits_from(&model, (1, 60, 1));
    let one: Vec<_> = found
        .iter()
        .filter(|orbit| orbit.impacts == Some(1))
        .collect();
    assert!(!one.is_empty() && one.len() <= 2, "{}", one.len());
    for orbit in &one {
        assert!((orbit.period.to_f64() - core::f64::consts::TAU / 2.7).abs() < 1e-12);
        let product = orbit.multipliers[0].re * orbit.multipliers[1].re
            - orbit.multipliers[0].im * orbit.multipliers[1].im;
        assert!((product - 0.64).abs() < 1e-11);
    }
}

/// An oscillator whose motion dies out crosses its section for ever, until there are no numbers that small: that is rest.
#[test]
fn what_dies_out_is_an_equilibrium() {
    const DAMPED: &str = r#"
[parameters]
d = 0.25
[flight]
x = "v"
v = "-2*d*(1 - x^2)*v - x"
[section.down]
surface = "x"
direction = "falling"
[initial]
x = 0.1
v = 0
"#;
    for damping in ["0.01", "0.25", "0.9"] {
        let model = with(DAMPED, &[("d", damping)]);
        let found = settles(&model);
        assert!(
            matches!(found, Err(PeriodicError::Equilibrium { .. })),
            "{damping}: {:?}",
            found.map(|orbit| orbit.period)
        );
    }
}

/// A wall that is struck on the way to a limit cycle alone is of the past: the cycle is that without it.
#[test]
fn what_happens_on_the_way_to_a_limit_cycle_is_forgotten() {
    const EXCITED: &str = r#"
[parameters]
wall = 2.5
[flight]
x = "v"
v = "0.5*(1 - x^2)*v - x"
[[contact]]
name = "wall"
gap = "wall - x"
impulse = { v = -1 }
restitution = 0.5
[section.mid]
surface = "x"
direction = "rising"
[initial]
x = 0
v = 6
"#;
    let struck = orbit(&with(EXCITED, &[]));
    let free = orbit(&with(EXCITED, &[("wall", "9")]));
    assert_eq!((struck.impacts, free.impacts), (Some(0), Some(0)));
    assert!((struck.period.to_f64() - free.period.to_f64()).abs() < 1e-14);
    assert!(struck.is_stable() && (struck.period.to_f64() - 6.380_675_801_77).abs() < 1e-10);
}

/// A block that is thrown off a floor with friction: impacts slow it, or stop it.
#[test]
fn orbits_with_friction_in_impacts_are_closed() {
    const SLED: &str = r#"
[parameters]
A = 1.1
[flight]
x = "u"
u = "-0.5*x - 0.1*u + 0.5*cos(t)"
y = "v"
v = "-1 + A*cos(t)"
[[contact]]
name = "floor"
gap = "y"
impulse = { v = 1 }
restitution = 0.5
friction = { coefficient = 0.3, along = { u = 1 }, rate = "u" }
[initial]
x = 0.2
u = 0
y = 0
v = 0
"#;
    for amplitude in ["1.1", "1.5"] {
        let found = orbit(&with(SLED, &[("A", amplitude)]));
        assert!(found.is_stable() && found.residual < 1e-25, "{amplitude}");
        assert_eq!(found.impacts, None, "{amplitude}");
        assert!((found.period.to_f64() - core::f64::consts::TAU).abs() < 1e-12);
    }
}

/// To and fro across its section a pendulum's angle is no phase: its limit cycle, its rest, and its free swings, one of many.
#[test]
fn a_pendulum_is_told_from_its_section() {
    let pendulum = |torque: &str| {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"{torque} - sin(x)\"\n[section.down]\nsurface = \"x\"\ndirection = \"rising\"\n\
             [initial]\nx = 1\nv = 0\n"
        );
        settles(&with(&text, &[]))
    };
    let cycle = pendulum("-0.1*v + 0.3*v*(1 - v^2)").unwrap();
    assert!(cycle.is_stable() && cycle.section == Some(0));
    assert!((cycle.trivial_multiplier.unwrap() - 1.0).abs() < 1e-10);
    let rest = pendulum("-0.05*v");
    assert!(matches!(rest, Err(PeriodicError::Equilibrium { .. })));
    let swing = pendulum("0");
    let is_one_of_many = |swing: &Result<_, PeriodicError>| matches!(swing, Err(PeriodicError::OneOfMany { least }) if (least - 1.0).abs() < 1e-3);
    assert!(is_one_of_many(&swing));
    // So is each of a stiffening spring, though equations in longer numbers, which are as singular, have another solution.
    for amplitude in ["0.3", "1", "2", "5"] {
        let text = format!(
            "[flight]\nx = 'v'\nv = '-x - x^3'\n[section.up]\nsurface = 'x'\ndirection = 'rising'\n[initial]\n\
             x = {amplitude}\nv = 0\n"
        );
        let swing = settles(&with(&text, &[]));
        assert!(is_one_of_many(&swing), "{amplitude}");
    }
}

/// A state that stands still is what the rest settles by: there is an orbit for each of its values, and all but it dies out.
#[test]
fn what_dies_out_beside_one_of_many_is_told() {
    let text = "[flight]\nx = 'v'\nv = '-x - 0.1*v + z - max(x - 0.2, 0) + cos(t)'\nz = '0'\n[initial]\nx = 0.1\nv = 0\nz = 0.3\n";
    let found = settles(&with(text, &[]));
    // Liouville: both multipliers that are not one have the product exp(-0.2 pi).
    let bound = (-0.1 * core::f64::consts::PI).exp() + 1e-9;
    assert!(
        matches!(found, Err(PeriodicError::OneOfMany { least }) if least < bound),
        "{found:?}"
    );
}

/// A rotor whose equations repeat after a third of a turn, and its section after a turn; another section is none of it.
#[test]
fn a_rotor_is_told_from_its_section() {
    const ROTOR: &str = r#"
[flight]
th = "w"
w = "0.1*(1.2 - w)"
x = "-x + 0.05*sin(3*th)"
[section.mark]
surface = "sin(th)"
direction = "rising"
[section.passed_once]
surface = "th - 1"
direction = "rising"
[initial]
th = 0
w = 1
x = 0
"#;
    let orbit = orbit(&with(ROTOR, &[]));
    let period = core::f64::consts::TAU / 1.2;
    assert!((orbit.period.to_f64() - period).abs() < 1e-13);
    // x is driven by 0.05 sin(3.6 t): its part in phase with the cosine at the section.
    let x = -0.05 * 3.6 / (1.0 + 3.6 * 3.6);
    assert!((orbit.start[2].to_f64() - x).abs() < 1e-13);
}

/// A valve of five states, from a return that is not near: its equations have a solution whose flight goes through the seat.
#[test]
#[ignore = "takes ten seconds"]
fn no_flight_of_an_orbit_goes_through_a_wall() {
    let text = r#"
[flight]
y1 = "y2"
y2 = "-0.3*y2 - y1 - 3 + y3"
y3 = "4*(y4 - y1*sqrt(y3))"
y4 = "(y5 - y3 - 0.2*y4)/1.5"
y5 = "(0.76 - y4)/2"
[[contact]]
name = "seat"
gap = "y1"
impulse = { y2 = 1 }
restitution = 0.7
[section.open]
surface = "y3 - 3"
direction = "rising"
[initial]
y1 = 0.1
y2 = 0
y3 = 3
y4 = 0.6
y5 = 3.1
"#;
    let found = orbit(&with(text, &[]));
    assert!(
        found.margins.iter().all(|margin| margin.value > 0.0),
        "{:?}",
        found.margins
    );
}

/// A pendulum that comes to rest kicks a wheel, on which nothing depends and which turns on. What is left of the pendulum crosses its section
/// for ever, in numbers that are next to nothing.
#[test]
fn what_comes_to_rest_beside_a_wheel_that_turns_has_no_period() {
    const WHEEL: &str = r#"
[parameters]
drag = 0
[flight]
th = "om"
om = "-sin(th) - 0.1*om"
phi = "w"
w = "-drag*w"
[[contact]]
name = "kick"
gap = "th + 0.2"
impulse = { om = 1, w = -0.3 }
restitution = 0.5
[section.middle]
surface = "th"
direction = "rising"
[initial]
th = 1
om = 0
phi = 0
w = 0.3
"#;
    for drag in ["0", "0.001"] {
        let found = settles(&with(WHEEL, &[("drag", drag)]));
        let is_told = matches!(found, Err(PeriodicError::Eventless { time }) if time < 1e3);
        assert!(is_told, "{drag}: {found:?}");
    }
}

/// A rimless wheel on a slope whose spokes are short in turn, told by a counter: whatever moves that to and fro, how large it is is no
/// matter of the motion.
#[test]
fn a_counter_to_and_fro_comes_back() {
    let wheel = |(asks, counts): (&str, &str)| {
        let text = format!(
            r#"
[parameters]
alpha = 0.3
gamma = 0.15
[flight]
th = "om"
om = "sin(th)"
n = "0"
[[event]]
name = "heel"
surface = "th - gamma - alpha*(1 + 0.05*if({asks}, 1, -1))"
direction = "rising"
reset = {{ th = "gamma - alpha", om = "cos(2*alpha)*om", n = "{counts}" }}
[initial]
th = 0
om = 0.8
n = 0
"#
        );
        orbit(&with(&text, &[]))
    };
    let known = 0.6_f64.cos().powi(4);
    for (asks, counts) in [
        ("n > 0.5", "if(n > 0.5, 0, 1)"),
        ("n > 0.5", "1 - n"),
        ("n > 0.5", "mod(n + 1, 2)"),
        ("mod(n, 2) >= 1", "mod(n + 1, 2)"),
        ("mod(n, 2) >= 1", "n + 1"),
    ] {
        let found = wheel((asks, counts));
        let period = found.period.to_f64();
        assert!(
            (period - 1.893_074_051_1).abs() < 1e-9,
            "{asks}, {counts}: {period}"
        );
        assert!(
            (found.multipliers[0].re - known).abs() < 1e-9,
            "{asks}, {counts}"
        );
    }
}

/// Lorenz's orbits of up to four returns: the periods of all of them are known, and none that returns more often is among them.
#[test]
fn no_orbit_returns_more_often_than_was_asked_for() {
    let text = "[flight]\nx = \"10*(y - x)\"\ny = \"x*(28 - z) - y\"\nz = \"x*y - 8*z/3\"\n[section.z]\nsurface = \"z - 27\"\n\
                direction = \"rising\"\n[initial]\nx = 10\ny = 1\nz = 20\n";
    let known = [
        1.558_652_210_7,
        2.305_907_263_9,
        3.023_583_703_4,
        3.084_276_775_8,
    ];
    for orbit in orbits_from(&with(text, &[]), (4, 24, 1)) {
        let period = orbit.period.to_f64();
        assert!(
            known.iter().any(|known| (known - period).abs() < 1e-9),
            "{period}"
        );
    }
}

/// A ball that falls onto a table with drag: its first impact comes while the table's jerk is not yet of the sign that it has at release, and the
/// velocity changes its sign there. How near the border is is told all the same, and so how well a border is known.
#[test]
fn a_sequence_may_begin_before_its_jerk_is_that_of_release() {
    let text = r#"
    [parameters]
    w = 2.5831
    [flight]
    y = "v"
    v = "-1 - 0.1*v*abs(v)"
    [[contact]]
    name = "table"
    gap = "y - 0.22*sin(w*t)"
    impulse = { v = 1 }
    restitution = 0.6
    [initial]
    y = 0.5
    v = 0.3
    "#;
    let ball = with(text, &[]);
    let border = border_margin(&ball, None);
    assert!(border.is_some_and(|x| x < 0.0), "{border:?}");
    let told = [0.05, 0.2].map(|step| {
        let found = over(&ball, "w", (2.56, 2.6), (20, step));
        let border = nearest(&found, &[SpecialKind::ChatterBorder], 2.583_165);
        (value(&border), border.error)
    });
    let [(one, error), (other, other_error)] = told;
    assert!((one - other).abs() <= error + other_error, "{told:?}");
    assert!(error < 1e-5, "{told:?}");
}

/// A part on an oblique conveyor: the third impact of each period stops its sliding, which forgets how fast it was. The motion has settled after
/// hundreds of turns, where rounding of the time moves the trough by more than that of its velocity.
#[test]
fn an_impact_that_stops_what_slides_is_seen_after_many_turns() {
    let text = r#"
[parameters]
A = 2.95
[definitions]
along = "A*cos(0.5)*cos(t)"
[flight]
x = "u"
u = "0"
y = "v"
v = "-1"
[[contact]]
name = "trough"
gap = "y - A*sin(0.5)*sin(t)"
impulse = { v = 1 }
restitution = 0.4
friction = { coefficient = 0.3, along = { u = 1 }, rate = "u - along" }
[section.s]
surface = "sin(t)"
direction = "rising"
[initial]
x = 0
u = 0
y = 1
v = 0
"#;
    for a in ["2.95", "2.98", "3.1"] {
        let found = orbit(&with(text, &[("A", a)]));
        assert_eq!(found.impacts, None, "{a}");
        assert!(found.multipliers.iter().all(|m| m.modulus() < 1e-12), "{a}");
    }
}

/// Two modes that draw from each other grow without bound, and with the cube of a rate steps become ever shorter: that is told, and not waited for.
#[test]
fn what_grows_without_bound_is_not_followed_for_ever() {
    let text = "[flight]\nx = \"v\"\nv = \"0.5*v - x + 0.6*y\"\ny = \"w\"\nw = \"-1.25*y - 0.6*x - 0.1*w^3\"\n[section.down]\n\
        surface = \"v\"\ndirection = \"falling\"\n[initial]\nx = 0.3\nv = 0\ny = 0\nw = 0\n";
    let found = settles(&with(text, &[]));
    let is_told = matches!(found, Err(PeriodicError::EverShorterSteps { time, steps }) if time > 10.0 && steps > 100_000);
    assert!(is_told, "{:?}", found.err());
}

/// A force that is least at a corner, where no rate of it vanishes: on a shaker that turns at once it falls to 1 - amp; and on a cam through points, held by
/// a spring, at one of these, by another program's splines.
#[test]
fn a_force_may_be_least_at_a_corner() {
    let shaker = "[flight]\ny = \"v\"\nv = \"0.4*if(mod(t, 2) < 1.4, mod(t, 2)/1.4, (2 - mod(t, 2))/0.6) - 1 - 0.1*v\"\nz = \"y - z\"\n\
        [[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n[initial]\ny = 1\nv = 0\nz = 0\n";
    let cam = "[table.lift]\nx = [0, 40, 80, 120, 160, 200, 240, 280, 320, 360]\n\
        y = [0, 0.02, 0.12, 0.24, 0.3, 0.27, 0.16, 0.05, 0.01, 0]\nkind = \"periodic-cubic\"\n[flight]\ny = \"v\"\n\
        v = \"-30*(y + 0.6) - v\"\nangle = \"9\"\n[[contact]]\nname = \"cam\"\ngap = \"y - lift(angle*180/pi)\"\nimpulse = { v = 1 }\n\
        restitution = 0.45\n[section.turn]\nsurface = \"sin(angle)\"\ndirection = \"rising\"\n[initial]\ny = 0.5\nv = 0\nangle = 0\n";
    for (text, exact) in [(shaker, 0.6), (cam, 9.066_362_133_817)] {
        let found = orbit(&with(text, &[]));
        let of_kind =
            |m: &&chatter::analysis::periodic::Margin| m.kind == MarginKind::LeastReaction;
        let least: Vec<f64> = found
            .margins
            .iter()
            .filter(of_kind)
            .map(|m| m.value)
            .collect();
        assert_eq!(least.len(), 1, "{:?}", found.margins);
        assert!((least[0] - exact).abs() < 1e-9, "{least:?}");
    }
}
