//! Branches and their special points against reference values in quadruple precision, and against each other.

use super::plane::curve_within;
use super::{GRAZES, branch_spec, model, nearest, over, value, with};
use chatter::analysis::periodic::{
    Beside, BranchSpec, End, Known, Law, Limits, Point, Spec, SpecialKind, Told, Unbounded,
    branches,
};
use std::ops::ControlFlow;

pub const TWO_SIDED: &str = r#"
[parameters]
omega = 2.6
sigma = 0.2
zeta = 0.05
r = 0.7
[flight]
x = "v"
v = "-x - 2*zeta*v + cos(omega*t)"
[[contact]]
name = "right"
gap = "sigma - x"
impulse = { v = -1 }
restitution = "r"
[[contact]]
name = "left"
gap = "sigma + x"
impulse = { v = 1 }
restitution = "r"
[initial]
x = 0
v = 0
"#;

pub const TWO_MASSES: &str = r#"
[parameters]
omega = 1.35
[flight]
x1 = "v1"
x2 = "v2"
v1 = "-(x1 - x2) - 0.04*(v1 - v2) + cos(omega*t)"
v2 = "((x1 - x2) + 0.04*(v1 - v2) - x2 - 0.04*v2)/2"
[[contact]]
gap = "-x1"
impulse = { v1 = -1 }
restitution = 0.8
[initial]
x1 = -1
v1 = 0
x2 = 0
v2 = 0
"#;

#[test]
fn arcs_of_the_valve_from_graze_to_graze() {
    let found = over(
        &model("pressure_relief_valve", &[("q", "0.020185")]),
        "q",
        (0.02018, 0.02026),
        (60, 0.02),
    );
    let one = |kinds: &[SpecialKind], at: f64, impacts: u64| {
        let special = nearest(&found, kinds, at);
        assert_eq!(special.point.impacts, Some(impacts), "{special:?}");
        let off = (value(&special) - at).abs();
        assert!(
            off < 2e-14 && off < 4.0 * special.error,
            "{off:e} {:e}",
            special.error
        );
        special
    };
    let graze = one(&GRAZES, 0.020_248_774_288_446_609, 36);
    assert!((graze.point.multipliers[0].re - 3.049_416_692_656_386).abs() < 1e-9);
    assert!((graze.point.period - 3.525_214_451_454_273).abs() < 1e-12);
    assert_eq!(graze.persists, Some(false));
    one(
        &[SpecialKind::PeriodDoubling],
        0.020_187_230_871_066_755,
        37,
    );
    one(&[SpecialKind::Fold], 0.020_182_579_910_832_31, 37);
    let graze = one(&GRAZES, 0.020_209_433_153_759_982, 37);
    assert!((graze.point.multipliers[0].re - 2.912_921_220_219_534).abs() < 1e-9);
}

/// The mark of a border is where the branch is told, at its section, and not where the border's orbit is released.
#[test]
fn a_border_is_marked_at_the_section() {
    let valve = model("pressure_relief_valve", &[("q", "0.02005")]);
    let at_section = Spec {
        section: Some(0),
        ..Spec::default()
    };
    let beside = Beside {
        doublings: 0,
        branch_points: 0,
    };
    let what = branch_spec(&valve, ("q", (0.02004, 0.02006)), (5, 0.05), beside);
    let found = branches(&valve, &at_section, &what, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    });
    let found = found.unwrap();
    let border = nearest(&found, &[SpecialKind::ChatterBorder], 0.02005);
    let last = (found.iter().flat_map(|branch| &branch.points))
        .filter(|point| point.impacts.is_none())
        .max_by(|a, b| a.parameter().total_cmp(&b.parameter()))
        .unwrap();
    assert!((border.point.state[2] - last.state[2]).abs() < 1e-12);
    for (marked, x) in border.point.state.iter().zip(&last.state) {
        assert!((marked - x).abs() < 1e-3 * x.abs(), "{marked} {x}");
    }
}

#[test]
fn a_branch_with_complete_chatter_ends_at_the_border() {
    let found = over(
        &model("pressure_relief_valve", &[("q", "0.02")]),
        "q",
        (0.02, 0.02007),
        (52, 0.05),
    );
    let border = nearest(&found, &[SpecialKind::ChatterBorder], 0.02005);
    assert!(
        (value(&border) - 0.020_056_005_689_312_284).abs() < 1e-13,
        "{}",
        value(&border)
    );
    assert!(
        found
            .iter()
            .any(|branch| branch.ends.contains(&End::ChatterBorder))
    );
    // Beyond it the cascade is followed, too.
    let most = found
        .iter()
        .flat_map(|branch| &branch.points)
        .filter_map(|point| point.impacts);
    assert!(most.max() > Some(50));
}

#[test]
fn pitchfork_and_graze_of_an_oscillator_between_two_stops() {
    let found = over(&with(TWO_SIDED, &[]), "omega", (1.9, 3.0), (60, 0.01));
    let pitchfork = nearest(&found[..1], &[SpecialKind::BranchPoint], 2.5);
    assert!((value(&pitchfork) - 2.542_111_080_123_326_5).abs() < 1e-11);
    let graze = nearest(&found[1..], &GRAZES, 2.04);
    assert!((value(&graze) - 2.041_451_695_925_873).abs() < 1e-13);
    let m = graze.point.multipliers[0];
    assert!((m.re + 0.230_067_738_457_173_8).abs() + (m.im - 0.351_512_136_229_696_2).abs() < 1e-9);
}

#[test]
fn tori_of_two_masses() {
    let found = over(&with(TWO_MASSES, &[]), "omega", (1.15, 1.4), (60, 0.01));
    for at in [1.212_416_918_341_172_3, 1.263_087_195_029_196_6] {
        let special = nearest(&found, &[SpecialKind::NeimarkSacker], at);
        assert!((value(&special) - at).abs() < 1e-12, "{}", value(&special));
        assert_eq!(special.point.impacts, Some(1));
    }
}

#[test]
fn special_points_do_not_depend_on_steps_or_starts() {
    let range = (0.607, 0.609);
    let of = |omega: &str, step: f64| {
        let model = model("impact_oscillator", &[("omega", omega), ("r", "0.5")]);
        over(&model, "omega", range, (11, step))
    };
    for found in [of("0.6081", 0.01), of("0.6081", 0.05), of("0.6088", 0.02)] {
        for (kinds, at, impacts) in [
            (&GRAZES[..], 0.608_193_037_535_510_8, 9),
            (&[SpecialKind::Fold][..], 0.608_257_537_739_327_9, 10),
            (&GRAZES[..], 0.607_701_126_906_327_9, 10),
        ] {
            let special = nearest(&found, kinds, at);
            assert!(
                (value(&special) - at).abs() < 3e-14,
                "{} {at}",
                value(&special)
            );
            assert_eq!(special.point.impacts, Some(impacts));
        }
    }
}

#[test]
fn folds_and_grazes_in_two_parameters() {
    let text = [("omega", "0.6081"), ("r", "0.5")];
    let model = model("impact_oscillator", &text);
    let found = over(&model, "omega", (0.607, 0.609), (11, 0.01));
    for (kinds, at, expected) in [
        (
            &GRAZES[..],
            0.608_193_037_535_510_8,
            0.620_793_560_659_722_9,
        ),
        (
            &[SpecialKind::Fold][..],
            0.608_257_537_739_327_9,
            0.620_843_960_024_853_1,
        ),
    ] {
        let special = nearest(&found, kinds, at);
        let known = Known {
            kind: special.kind,
            monitor: None,
            state: special.point.state.clone(),
            period: special.point.period,
        };
        let limits = Limits {
            range: (0.49, 0.51),
            other: None,
            impacts: 60,
            points: 2000,
            longest_step: 0.02,
        };
        let told = (&known, value(&special));
        let curve = curve_within(&model, ["omega", "r"], told, &limits).unwrap();
        assert_eq!(curve.ends, [End::Range, End::Range]);
        let first = &curve.points[0].parameters;
        assert!((first[1] - 0.49).abs() < 1e-14);
        assert!(
            (first[0] - expected).abs() < 1e-13,
            "{} {expected}",
            first[0]
        );
    }
}

/// Gears with backlash: the force is that of a spring beyond a play.
const GEARS: &str = r#"
[parameters]
w = 1.5
[flight]
x = "v"
v = "0.12 + 0.35*cos(w*t) - 0.1*v - 4*if(x > 0.2, x - 0.2, if(x < -0.2, x + 0.2, 0))"
[initial]
x = 0.25
v = 0
"#;

/// Where an orbit touches a surface it gains a crossing and the way back, or loses them, and goes on; that is no fold.
#[test]
fn a_branch_goes_on_where_a_surface_is_touched() {
    let gears = with(GEARS, &[]);
    let found = over(&gears, "w", (1.4, 1.9), (5, 0.01));
    let branch = &found[0];
    let touches = || (branch.special.iter()).filter(|s| s.kind == SpecialKind::Touch);
    assert!(
        touches().any(|s| (value(s) - 1.444_708_207_627_67).abs() < 1e-12),
        "{:?} {:?}",
        branch
            .special
            .iter()
            .map(|s| (s.kind, value(s)))
            .collect::<Vec<_>>(),
        branch.ends
    );
    for special in &branch.special {
        let near = |m: &chatter::numerics::Complex| (m.re - 1.0).hypot(m.im) < 1e-7;
        let is_fold = special.kind == SpecialKind::Fold;
        assert!(!is_fold || special.point.multipliers.iter().any(near));
    }
    let ends: Vec<String> = branch.ends.iter().map(End::to_string).collect();
    assert!(!ends.iter().any(|end| end.contains("touched")), "{ends:?}");
    // Beside the touch the orbits are motions, with the same multipliers.
    let place = touches().next().unwrap().place;
    for at in [place.saturating_sub(12), place + 12] {
        let point = &branch.points[at.min(branch.points.len() - 1)];
        let w = format!("{:?}", point.parameter());
        let spec = Spec {
            through: Some((point.state.clone(), point.period)),
            ..Spec::default()
        };
        let what = BranchSpec {
            parameter: gears.parameter_index("w").unwrap(),
            limits: Limits {
                range: (point.parameter() - 1e-7, point.parameter() + 1e-7),
                other: None,
                impacts: 5,
                points: 2,
                longest_step: 0.5,
            },
            beside: Beside::default(),
        };
        let model = with(GEARS, &[("w", &w)]);
        let again = branches(&model, &spec, &what, Vec::new(), &mut |_| {
            ControlFlow::Continue(())
        });
        let again = again.unwrap();
        let same = (again[0].points.iter())
            .min_by(|a, b| {
                let off = |p: &Point| (p.parameter() - point.parameter()).abs();
                off(a).total_cmp(&off(b))
            })
            .unwrap();
        assert!((same.period - point.period).abs() < 1e-6 * point.period);
        for (a, b) in same.multipliers.iter().zip(&point.multipliers) {
            assert!((a.re - b.re).hypot(a.im - b.im) < 1e-3, "{a:?} {b:?}");
        }
    }
}

/// From a graze on a branch is followed with one more impact, and back without it.
#[test]
fn there_and_back_is_the_same_branch() {
    let model = |omega: &str| model("impact_oscillator", &[("omega", omega), ("r", "0.5")]);
    let (a, b) = (
        over(&model("0.6081"), "omega", (0.6075, 0.609), (11, 0.01)),
        over(&model("0.6088"), "omega", (0.6075, 0.609), (11, 0.013)),
    );
    let of = |found: &[chatter::analysis::periodic::Branch]| {
        let mut values: Vec<(u64, String, i64)> = (found[0].special.iter())
            .map(|s| {
                (
                    s.point.impacts.unwrap_or(0),
                    s.kind.name().to_owned(),
                    (value(s) * 1e12).round() as i64,
                )
            })
            .collect();
        values.sort();
        values
    };
    assert_eq!(of(&a), of(&b));
    assert!(a[0].special.len() >= 4);
}

/// A wheel without a rim that walks downhill: on the flattest slope on which it does each step just passes over the top, where it could
/// stand for ever.
#[test]
fn a_branch_ends_where_its_orbit_comes_to_a_saddle() {
    const WHEEL: &str = r#"
[parameters]
slope = 0.08
[flight]
th = "om"
om = "sin(th)"
[[event]]
name = "spoke"
surface = "th - 0.25 - slope"
direction = "rising"
reset = { th = "th - 0.5", om = "om*cos(0.5)" }
[initial]
th = -0.17
om = 0.4
"#;
    let found = over(&with(WHEEL, &[]), "slope", (0.01, 0.2), (20, 0.02));
    let End::Saddle(saddle) = &found[0].ends[0] else {
        panic!("{:?}", found[0].ends);
    };
    assert_eq!(saddle.names, ["th", "om"]);
    assert_eq!(saddle.state, [0.0, 0.0]);
    assert!((saddle.rate - 1.0).abs() < 1e-12, "{saddle:?}");
    assert!(saddle.period > 20.0, "{saddle:?}");
    // The energy at the top is nothing: of what a step loses by its impact the slope gives back.
    let slope = found[0].points[0].parameter();
    let off = |slope: f64| {
        let top = 1.0 - (0.25 - slope).cos();
        let before = top + (slope - 0.25).cos() - (slope + 0.25).cos();
        before * 0.5_f64.cos().powi(2) - top
    };
    assert!(off(slope).abs() < 1e-8, "{slope}");
    let unbounded = saddle.unbounded.as_ref().unwrap();
    let (beyond, near) = (
        unbounded.value - unbounded.error,
        unbounded.value + unbounded.error,
    );
    assert!(
        off(beyond) * off(near) <= 0.0 && unbounded.error < 1e-10,
        "{unbounded:?}"
    );
}

/// The particle of an impact damper: where both its impacts graze at once one of them is left, which comes to nothing, and beyond
/// the particle may rest anywhere. Complete chatter there is none to look for, and none is.
#[test]
fn a_lone_impact_that_comes_to_nothing_is_no_chatter() {
    let damper = r#"
[parameters]
d = 4
[flight]
X = "V"
V = "0.1*cos(t) - 0.04*V - X"
z = "u"
u = "0"
[[contact]]
name = "right"
gap = "d/2 - (z - X)"
impulse = { V = 0.1, u = -1 }
restitution = 0.5
[[contact]]
name = "left"
gap = "d/2 + (z - X)"
impulse = { V = -0.1, u = 1 }
restitution = 0.5
[section.strobe]
surface = "sin(t)"
direction = "rising"
[initial]
X = 0
V = 1
z = 0
u = 0.3
"#;
    let limits = Limits {
        range: (0.5, 8.0),
        other: None,
        impacts: 60,
        points: 5000,
        longest_step: 0.03,
    };
    let model = with(damper, &[]);
    let spec = BranchSpec {
        parameter: model.parameter_index("d").unwrap(),
        limits,
        beside: Beside::default(),
    };
    let found = branches(&model, &Spec::default(), &spec, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let [branch] = &*found else {
        panic!("{} branches", found.len());
    };
    let is_at_rest = |end: &End| matches!(end, End::Lost(why) if why.contains("at rest"));
    assert!(branch.ends.iter().any(is_at_rest), "{:?}", branch.ends);
}

/// Arcs of a bell and its clapper, which strikes either side, have two impacts more each and accumulate at a chatter border, T = 0.14806159387952. Where a
/// twelfth or an eleventh impact would begin, flights are 3e4 roundoffs high, and rounding decides at which orbit no solution is found any more.
#[test]
fn arcs_end_in_rounding_where_no_solution_is_found_for_it() {
    let bell = r#"
[parameters]
T = 0.1480605
[flight]
x = "v"
v = "-sin(x) - 0.02*v + 0.01*(u - v) + if(abs(x) < 0.26, T*sign(v), 0)"
y = "u"
u = "-1.6*sin(y) - 0.1*(u - v)"
[[contact]]
name = "right"
gap = "0.5 - (y - x)"
impulse = { u = -1, v = 0.1 }
restitution = 0.05
[[contact]]
name = "left"
gap = "0.5 + (y - x)"
impulse = { u = 1, v = -0.1 }
restitution = 0.05
[section.mid]
surface = "x"
direction = "rising"
[initial]
x = 0.3
v = 0
y = -0.1
u = 0
"#;
    for (start, longest_step) in [("0.1480605", 0.3), ("0.1480609", 0.1)] {
        let model = with(bell, &[("T", start)]);
        let range = ("T", (0.14806, 0.1480615));
        let spec = branch_spec(&model, range, (40, longest_step), Beside::default());
        let mut ends = String::new();
        // What lies beyond the border is looked for after its end.
        let mut until_its_end = |told: Told<'_>| match told {
            Told::Record(record) => {
                let text = serde_json::to_string(record).unwrap();
                ends.extend(
                    ["Rounding", "Lost"]
                        .iter()
                        .filter(|end| text.contains(*end))
                        .copied(),
                );
                match ends.is_empty() {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                }
            }
            _ => ControlFlow::Continue(()),
        };
        let _ = branches(
            &model,
            &Spec::default(),
            &spec,
            Vec::new(),
            &mut until_its_end,
        );
        assert_eq!(ends, "Rounding", "from {start}");
    }
}

/// A linear map doubles at a = -1 and nowhere else, so that its doubled orbits lie to neither side.
#[test]
fn doublings_of_linear_maps_have_no_side() {
    let text = r#"
    [parameters]
    a = -0.5
    [flight]
    x = "0"
    s = "1"
    [[event]]
    name = "tick"
    surface = "s - 1"
    direction = "rising"
    reset = { x = "a*x + 0.1*a", s = "0" }
    [initial]
    x = 0.1
    s = 0.0
    "#;
    let found = over(&with(text, &[]), "a", (-2.0, 0.5), (4, 0.01));
    let [special] = &found[0].special[..] else {
        panic!("{:?}", found[0].special);
    };
    assert_eq!(special.kind, SpecialKind::PeriodDoubling);
    assert!((value(special) + 1.0).abs() < 1e-13);
    assert_eq!(special.above, None);
}

/// On an orbit that stays clear of a backlash a shaft whose stiffness varies is linear: where it doubles, at either end of the resonance,
/// a place that is known to rounding alone tells no side.
#[test]
fn doublings_of_linear_orbits_have_no_side() {
    let text = r#"
    [parameters]
    omega = 1.8
    [flight]
    x = "v"
    v = "0.2 + 0.15*cos(omega*t + 0.4) - 0.08*v - (1 + 0.25*cos(omega*t))*(x - clamp(x, -0.5, 0.5))"
    [initial]
    x = 0.8
    v = 0
    "#;
    for start in ["1.7", "1.8", "2.1"] {
        let model = with(text, &[("omega", start)]);
        let found = over(&model, "omega", (1.6, 2.2), (100, 0.02));
        let doublings: Vec<_> = (found[0].special.iter())
            .filter(|special| special.kind == SpecialKind::PeriodDoubling)
            .collect();
        assert_eq!(doublings.len(), 2, "from {start}: {:?}", found[0].special);
        for doubling in doublings {
            assert_eq!(doubling.above, None, "from {start}: {}", value(doubling));
        }
    }
}

/// th' = a - sin(th) goes around in 2 pi / sqrt(a^2 - 1): two equilibria come about on the orbit at a = 1.
#[test]
fn a_period_that_grows_as_an_inverse_root_is_told_with_where_it_ends() {
    let text = "[parameters]\na = 1.5\n[flight]\nth = \"a - sin(th)\"\nx = \"cos(th) - x\"\n[section.s]\nsurface = \"sin(th)\"\n\
                direction = \"rising\"\n[initial]\nth = 0\nx = 0\n";
    let found = over(&with(text, &[]), "a", (0.5, 2.0), (8, 0.02));
    let End::Unbounded(unbounded) = &found[0].ends[0] else {
        panic!("{:?}", found[0].ends);
    };
    let off = (unbounded.value - 1.0).abs();
    assert!(
        off <= unbounded.error && unbounded.error < 1e-6,
        "{unbounded:?}"
    );
    let Law::InverseRoot(factor) = unbounded.law else {
        panic!("{unbounded:?}");
    };
    let expected = core::f64::consts::TAU / 2.0_f64.sqrt();
    let off = (factor - expected).abs();
    assert!(
        off <= unbounded.law_error && off < 1e-3 * expected,
        "{unbounded:?}"
    );
}

/// A period that grows as a logarithm where the parameter comes to this value, and the rate in it.
fn logarithm_to(end: &End, value: f64) -> (&Unbounded, f64) {
    let End::Unbounded(unbounded) = end else {
        panic!("{end:?}");
    };
    let off = (unbounded.value - value).abs();
    assert!(
        off <= unbounded.error && unbounded.error < 1e-12,
        "{unbounded:?}"
    );
    let Law::Logarithm(rate) = unbounded.law else {
        panic!("{unbounded:?}");
    };
    (unbounded, rate)
}

/// A thermostat with one lag: x falls to its lower threshold ref - h as exp(-t), for ever if that is zero.
#[test]
fn a_period_that_grows_as_a_logarithm_is_told_with_where_it_ends() {
    let text = "[parameters]\nh = 0.2\nref = 1\n[flight]\nx = \"2*q - x\"\nq = \"0\"\n[[event]]\nname = \"off\"\n\
                surface = \"x - ref - h\"\ndirection = \"rising\"\nreset = { q = 0 }\n[[event]]\nname = \"on\"\n\
                surface = \"x - ref + h\"\ndirection = \"falling\"\nreset = { q = 1 }\n[initial]\nx = 0\nq = 1\n";
    let branch = &over(&with(text, &[]), "ref", (0.1, 2.0), (8, 0.02))[0];
    for (end, expected) in branch.ends.iter().zip([0.2, 1.8]) {
        let (unbounded, rate) = logarithm_to(end, expected);
        assert!((rate - 1.0).abs() < 1e-3, "{unbounded:?}");
    }
}

/// x grows as exp(k t) from where it is taken back to, up to 1: from ever nearer to zero it takes -log(p)/k, and the orbit is no point.
#[test]
fn an_orbit_that_is_taken_back_to_an_equilibrium_does_not_shrink() {
    let text = "[parameters]\np = 0.5\nk = 1.7\n[flight]\nx = \"k*x\"\n[[event]]\nname = \"top\"\nsurface = \"x - 1\"\n\
                direction = \"rising\"\nreset = { x = \"p - P\" }\n[initial]\nx = 0.3\n";
    for place in ["0", "0.2"] {
        let text = text.replace('P', place);
        let branch = &over(&with(&text, &[]), "p", (-0.5, 0.9), (8, 0.02))[0];
        let (unbounded, rate) = logarithm_to(&branch.ends[0], place.parse().unwrap());
        let off = (rate - 1.7).abs();
        assert!(off <= unbounded.law_error && off < 1e-6, "{unbounded:?}");
    }
}
