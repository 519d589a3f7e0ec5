//! Special points that are passed once are told once, with the period and the multipliers of the orbit there.

use crate::periodic::{GRAZES, branch_spec, nearest, orbit, over, value, with};
use chatter::analysis::periodic::{
    Beside, Branch, Distinct, End, Spec, SpecialKind, Start, Told, branches,
};
use std::ops::ControlFlow;

/// Dry friction on the second of two masses: where its rate turns between two crossings of another surface a crossing comes in. Orbits
/// found on both sides of each of these values have one stay more or less.
#[test]
fn a_touch_under_friction_is_told_once() {
    const RUBBED: &str = r#"
[parameters]
omega = 0.9
[flight]
x = "v"
v = "cos(omega*t) - x - 0.5*(x - y) - 0.05*v"
y = "w"
w = "0.5*(x - y) - y - 0.05*w - 0.2*sign(w)"
[[contact]]
name = "stop"
gap = "0.8 - x"
impulse = { v = -1 }
restitution = 0.7
[initial]
x = 0
v = 0
y = 0
w = 0
"#;
    let found = over(&with(RUBBED, &[]), "omega", (0.7, 1.2), (40, 0.02));
    let special = &found[0].special;
    let touches = special.iter().filter(|s| s.kind == SpecialKind::Touch);
    let touches: Vec<f64> = touches.map(value).collect();
    let expected = [
        0.738_791_403_991_805_6,
        0.863_215_463_881_572_9,
        0.856_623_136_887_202_7,
        0.845_529_995_664_387_2,
        0.911_987_909_440_132_1,
        0.944_209_099_337_010_6,
        1.042_688_912_113_905_8,
    ];
    assert_eq!(touches.len(), expected.len(), "{touches:?}");
    assert!((touches.iter().zip(expected)).all(|(touch, at)| (touch - at).abs() < 1e-12));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
}

/// An oscillator that excites itself and just reaches its stop: beyond, nothing tells where a period begins.
#[test]
fn the_graze_of_the_only_event_is_told_once() {
    const EXCITED: &str = r#"
[parameters]
s = 1.9
[flight]
x = "v"
v = "0.5*(1 - x^2)*v - x"
[[contact]]
name = "stop"
gap = "s - x"
impulse = { v = -1 }
restitution = 0.5
[initial]
x = 0.5
v = 0
"#;
    let found = over(&with(EXCITED, &[]), "s", (1.8, 2.2), (40, 0.05));
    let grazes = found[0].special.iter().filter(|s| GRAZES.contains(&s.kind));
    let grazes: Vec<f64> = grazes.map(value).collect();
    let [graze] = grazes[..] else {
        panic!("{grazes:?}");
    };
    assert!((graze - 2.002_487_930_447_108_6).abs() < 1e-12);
}

/// Drag changes its sign with the rate that vanishes at a graze: the impact goes out, and its surface stays to be crossed.
#[test]
fn an_impact_goes_out_where_drag_turns() {
    const VALVE: &str = r#"
[parameters]
omega = 1.5
[flight]
x = "v"
v = "-0.3 + sin(omega*t) - x - 0.3*v*abs(v)"
[[contact]]
name = "seat"
gap = "x"
impulse = { v = 1 }
restitution = 0.5
[[contact]]
name = "limit"
gap = "0.8 - x"
impulse = { v = -1 }
restitution = 0.15
[initial]
x = 0.1
v = 0
"#;
    let found = over(&with(VALVE, &[]), "omega", (1.5, 2.0), (40, 0.02));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    let grazes = found[0].special.iter().filter(|s| GRAZES.contains(&s.kind));
    let grazes: Vec<_> = grazes.collect();
    let [graze] = grazes[..] else {
        panic!("{grazes:?}");
    };
    assert!(
        (value(graze) - 1.953_604_781_279_665).abs() < 1e-12,
        "{}",
        value(graze)
    );
    assert_eq!(graze.point.impacts, Some(1));
    assert_eq!(graze.persists, Some(true));
}

const TUBE: &str = r#"
[parameters]
omega = 1.7
[flight]
a = "p"
p = "-a - 0.08*p + cos(omega*t)"
b = "q"
q = "-6.25*b - 0.1*q + 0.6*cos(omega*t)"
[[contact]]
name = "mid"
gap = "0.4 - (a + 0.5*b)"
impulse = { p = -1, q = -0.5 }
restitution = 0.7
[[contact]]
name = "end"
gap = "0.3 + (a - 0.7*b)"
impulse = { p = 1, q = -0.7 }
restitution = 0.7
[initial]
a = 0
p = 0
b = 0
q = 0
"#;

/// Just before a closed branch comes back to where it began.
#[test]
fn the_last_gap_of_a_closed_branch_is_looked_at() {
    for step in [0.02, 0.0031 / 0.4] {
        let found = over(&with(TUBE, &[]), "omega", (1.5, 1.9), (80, step));
        assert!(found[0].ends.contains(&End::Closed));
        let special = nearest(
            &found,
            &[SpecialKind::PeriodDoubling],
            1.700_129_595_768_155_7,
        );
        assert!((value(&special) - 1.700_129_595_768_155_7).abs() < 1e-12);
    }
}

/// The period of an orbit under a forcing is the forcing's, to the last digit, at a graze of two impacts at once, too; and no
/// multiplier is told where it has a pole.
#[test]
fn a_double_graze_has_the_period_of_the_forcing() {
    const BELL: &str = r#"
[parameters]
omega = 1.25
[flight]
a = "p"
p = "-sin(a) - 0.1*p + 0.6*cos(omega*t)"
b = "q"
q = "-3*sin(b) - 0.05*q"
[[contact]]
name = "one"
gap = "0.35 - (b - a)"
impulse = { p = 0.2, q = -1 }
restitution = 0.5
[[contact]]
name = "other"
gap = "0.35 + (b - a)"
impulse = { p = -0.2, q = 1 }
restitution = 0.5
[initial]
a = 0.1
p = 0
b = 0
q = 0
"#;
    let found = over(&with(BELL, &[]), "omega", (1.19, 1.26), (40, 0.02));
    let grazes =
        (found.iter().flat_map(|branch| &branch.special)).filter(|s| GRAZES.contains(&s.kind));
    let grazes: Vec<_> = grazes.collect();
    assert!(grazes.len() > 1);
    for graze in grazes {
        assert!((value(graze) - 1.206_326_243_735_055_3).abs() < 1e-12);
        let forcing = core::f64::consts::TAU / value(graze);
        assert!(
            (graze.point.period / forcing - 1.0).abs() < 1e-13,
            "{}",
            graze.point.period
        );
        assert!(graze.point.multipliers.iter().all(|m| m.modulus() < 1e3));
    }
}

/// Both stops are met at once: without one impact the other has no rate either, and multipliers have a pole.
#[test]
fn a_graze_of_both_stops_has_no_multipliers() {
    const PENDULUM: &str = r#"
[parameters]
omega = 2
[flight]
x = "v"
v = "-(1 + 0.5*cos(omega*t))*sin(x) - 0.1*v"
[[contact]]
name = "up"
gap = "0.6 - x"
impulse = { v = -1 }
restitution = 0.7
[[contact]]
name = "down"
gap = "0.6 + x"
impulse = { v = 1 }
restitution = 0.7
[initial]
x = 0.1
v = 0
"#;
    let found = over(&with(PENDULUM, &[]), "omega", (1.6, 2.3), (40, 0.02));
    let specials = found.iter().flat_map(|branch| &branch.special);
    let grazes: Vec<_> = specials.filter(|s| GRAZES.contains(&s.kind)).collect();
    assert!(!grazes.is_empty());
    for graze in grazes {
        let largest = graze.point.multipliers.iter().map(|m| m.modulus());
        assert!(largest.fold(0.0, f64::max) < 1e3, "{graze:?}");
    }
}

/// Beyond the graze of its only impact a flight goes through the wall right after it: what is lost is the impact, however long the steps.
#[test]
fn an_impact_of_every_second_period_goes_out_at_its_graze() {
    const HARVESTER: &str = r#"
[parameters]
omega = 0.7524689
[flight]
x = "v"
v = "-x - 0.04*v - 0.3*q + 0.4*cos(omega*t)"
q = "0.3*v - q/2"
[[contact]]
name = "stop"
gap = "0.8 - x"
impulse = { v = -1 }
restitution = 0.6
[initial]
x = 0
v = 0
q = 0
"#;
    const GRAZE: f64 = 0.753_415_583_577_001_3;
    for (range, step) in [
        ((0.752, 0.7536), 0.02),
        ((0.7, 0.9), 0.02),
        ((0.7, 0.9), 0.1),
    ] {
        let found = over(&with(HARVESTER, &[]), "omega", range, (40, step));
        let grazes = found[0].special.iter().filter(|s| GRAZES.contains(&s.kind));
        let nearest = grazes.map(|s| (value(s) - GRAZE).abs()).fold(1.0, f64::min);
        assert!(nearest < 1e-13, "{range:?} {step}: {nearest:e}");
        let ends = &found[0].ends;
        assert!(
            !ends.iter().any(|end| matches!(end, End::Rounding(_))),
            "{ends:?}"
        );
    }
}

/// A branch without the symmetry of another leaves that at one branch point and comes back at a second one, goes on as its own mirror
/// image, and closes: beside a fold, which steps go past. It is listed once, and gone around once.
#[test]
fn a_branch_between_two_branch_points_is_listed_once() {
    const STOPS: &str = r#"
[parameters]
omega = 2
[flight]
x = "v"
v = "cos(omega*t) - 0.1*v - x"
[[contact]]
name = "right"
gap = "0.5 - x"
impulse = { v = -1 }
restitution = 0.7
[[contact]]
name = "left"
gap = "0.5 + x"
impulse = { v = 1 }
restitution = 0.7
[initial]
x = 0
v = 0.5
"#;
    let found = over(&with(STOPS, &[]), "omega", (0.5, 3.5), (20, 0.01));
    let ends: Vec<_> = found.iter().map(|branch| &branch.ends).collect();
    let closed = [End::Closed, End::Closed];
    assert_eq!(ends.len(), 3, "{ends:?}");
    assert!(ends[1..].iter().all(|ends| **ends == closed), "{ends:?}");
    for branch in &found[1..] {
        let met = branch.special.iter();
        let met = met.filter(|special| special.kind == SpecialKind::BranchPoint);
        assert_eq!(met.count(), 2);
    }
}

/// Followed from two places, a branch has some of its special points a turn of the forcing further, which at another frequency
/// takes another time.
#[test]
fn a_branch_is_known_whatever_the_turn_of_its_phase() {
    const STOP: &str = r#"
[parameters]
omega = 1.5
s = 1
[flight]
x = "v"
v = "cos(omega*t + s) - 0.1*v - x"
[[contact]]
name = "stop"
gap = "0.5 - x"
impulse = { v = -1 }
restitution = 0.7
[initial]
x = 0
v = 0.5
"#;
    const RANGE: (f64, f64) = (0.5, 3.0);
    let model = with(STOP, &[]);
    let what = branch_spec(&model, ("omega", RANGE), (20, 0.05), Beside::default());
    let start = Start::from(&orbit(&model));
    let mut distinct = Distinct::new(&model, &Spec::default(), &what).unwrap();
    let from = |omega: &str| over(&with(STOP, &[("omega", omega)]), "omega", RANGE, (20, 0.05));
    let (one, other) = (from("1.5").swap_remove(0), from("2.2").swap_remove(0));
    let fold = |branch: &Branch| {
        let folds = branch
            .special
            .iter()
            .filter(|s| s.kind == SpecialKind::Fold);
        folds
            .min_by(|a, b| value(a).total_cmp(&value(b)))
            .cloned()
            .unwrap()
            .point
    };
    let turn = (fold(&one).state[2] - fold(&other).state[2]) / fold(&one).period;
    assert!((turn - 1.0).abs() < 1e-6, "{turn}");
    assert_eq!(distinct.add(&start, vec![one.clone()]).unwrap().len(), 1);
    let again = distinct.add(&start, vec![one, other]);
    assert_eq!(again.unwrap().len(), 1);
}

/// A free mass in a cavity of a driven one: where its symmetric orbit touches both walls at once the branch goes on with both impacts; what strikes one of them
/// goes around by way of its mirror image, through that place and through where it meets the symmetric one, and is closed.
#[test]
fn what_strikes_one_wall_comes_back_by_way_of_its_mirror_image() {
    const DAMPER: &str = r#"
[parameters]
omega = 1.6
[flight]
x = "v"
v = "cos(omega*t) - 0.04*v - x"
y = "w"
w = "-0.01*w"
[[contact]]
name = "right"
gap = "1.2 - (y - x)"
impulse = { v = 0.15, w = -1 }
restitution = 0.7
[[contact]]
name = "left"
gap = "1.2 + (y - x)"
impulse = { v = -0.15, w = 1 }
restitution = 0.7
[initial]
x = 0
v = 0.5
y = 0
w = 0.3
"#;
    let found = over(&with(DAMPER, &[]), "omega", (1.0, 2.4), (3, 0.05));
    let [symmetric, lone] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(symmetric.ends, [End::Impacts(3), End::Range]);
    let last = symmetric.points.last().unwrap();
    assert!((last.parameter() - 2.4).abs() < 1e-9);
    // By return maps with forty digits.
    let tori = (symmetric.special.iter()).filter(|s| s.kind == SpecialKind::NeimarkSacker);
    let tori: Vec<f64> = tori.map(value).collect();
    let off = |omega: f64| tori.iter().any(|found| (found - omega).abs() < 1e-11);
    assert!(
        off(1.759_999_879_288_5) && off(2.195_679_128_249_7),
        "{tori:?}"
    );
    assert_eq!(lone.ends, [End::Closed, End::Closed]);
    let (both, one) = (1.022_062_775_269, 1.234_191_681_569_6);
    for (branch, expected) in [(symmetric, vec![both, both]), (lone, vec![both, one, one])] {
        let grazes = branch.special.iter().filter(|s| s.kind.is_graze());
        let mut grazes: Vec<f64> = grazes.map(value).collect();
        grazes.sort_by(f64::total_cmp);
        assert_eq!(grazes.len(), expected.len(), "{grazes:?}");
        let mut pairs = grazes.iter().zip(&expected);
        assert!(
            pairs.all(|(told, expected)| (told - expected).abs() < 1e-12),
            "{grazes:?}"
        );
        let meets = branch
            .special
            .iter()
            .filter(|s| s.kind == SpecialKind::BranchPoint);
        assert_eq!(meets.count(), 1);
    }
}

/// Orbits that cross the section two and three times, and have no other events, are one orbit at each crossing: Roessler's doubled orbits are
/// followed to where they meet the simple ones and no farther, and a closed branch of Langford's is gone around once and not three times.
#[test]
fn orbits_told_from_sections_alone_are_told_once() {
    let roessler = "[parameters]\nc = 2.5\n[flight]\nx = \"-y - z\"\ny = \"x + 0.2*y\"\nz = \"0.2 + z*(x - c)\"\n[section.y]\n\
                    surface = \"y\"\ndirection = \"falling\"\n[initial]\nx = 2\ny = 1\nz = 0.1\n";
    let model = with(roessler, &[]);
    let beside = Beside {
        doublings: 1,
        branch_points: 0,
    };
    let spec = branch_spec(&model, ("c", (2.0, 4.0)), (8, 0.02), beside);
    let found = branches(&model, &Spec::default(), &spec, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let [simple, doubled] = &found[..] else {
        panic!("{}", found.len());
    };
    assert_eq!(simple.ends, [End::Range, End::Range]);
    let ends = [&doubled.ends[0], &doubled.ends[1]];
    assert!(ends.contains(&&End::Again(SpecialKind::BranchPoint)) && ends.contains(&&End::Range));
    let of = |branch: &Branch, kind: SpecialKind| {
        let all = branch.special.iter().filter(|s| s.kind == kind);
        all.map(value).collect::<Vec<f64>>()
    };
    let (first, meets) = (
        of(simple, SpecialKind::PeriodDoubling),
        of(doubled, SpecialKind::BranchPoint),
    );
    assert_eq!((first.len(), meets.len()), (1, 1));
    assert!((first[0] - meets[0]).abs() < 1e-12);
    assert_eq!(of(doubled, SpecialKind::PeriodDoubling).len(), 1);

    let langford = "[parameters]\nlam = 0.9\n[flight]\nx = \"(z - 0.7)*x - 3.5*y\"\ny = \"3.5*x + (z - 0.7)*y\"\n\
                    z = \"0.6 + lam*z - z^3/3 - (x^2 + y^2)*(1 + 0.25*z) + 0.1*z*x^3\"\n[section.s]\nsurface = \"y\"\n\
                    direction = \"rising\"\n[initial]\nx = 0.5\ny = 0\nz = 0.5\n";
    let found = over(&with(langford, &[]), "lam", (0.3, 1.0), (8, 0.02));
    let branch = &found[0];
    assert_eq!(branch.ends, [End::Closed, End::Closed]);
    assert_eq!(of(branch, SpecialKind::Fold).len(), branch.special.len());
    assert_eq!(branch.special.len(), 2);
}

/// A mass between two stops, its own mirror image but for half a period: what begins in a symmetric model comes in pairs, and goes by way of its mirror
/// image on the branch that it leaves. The doubling by closed forms of the flights, in forty digits.
const FREE_PLAY: &str = r#"
[parameters]
om = 1
[flight]
x = "v"
v = "cos(om*t) - 0.1*v"
[[contact]]
name = "right"
gap = "1 - x"
impulse = { v = -1 }
restitution = 0.7
[[contact]]
name = "left"
gap = "1 + x"
impulse = { v = 1 }
restitution = 0.7
[initial]
x = 0.1
v = 0.3
"#;

/// The branch from here, and those that leave at its doublings; how many orbits were told of on the way.
fn doubled_once(start: &str, range: (f64, f64)) -> (Vec<Branch>, usize) {
    let model = with(FREE_PLAY, &[("om", start)]);
    let beside = Beside {
        doublings: 1,
        branch_points: 0,
    };
    let spec = branch_spec(&model, ("om", range), (20, 0.03), beside);
    let mut told = 0;
    let found = branches(&model, &Spec::default(), &spec, Vec::new(), &mut |what| {
        told += usize::from(matches!(what, Told::Orbit(_)));
        ControlFlow::Continue(())
    });
    (found.unwrap(), told)
}

#[test]
fn of_mirror_images_one_is_followed() {
    let (found, _) = doubled_once("1", (0.96, 1.16));
    let [simple, doubled] = &found[..] else {
        panic!("{} branches", found.len());
    };
    let doublings = (simple.special.iter()).filter(|s| s.kind == SpecialKind::PeriodDoubling);
    let all: Vec<f64> = doublings
        .chain(
            doubled
                .special
                .iter()
                .filter(|s| s.kind == SpecialKind::BranchPoint),
        )
        .map(value)
        .collect();
    let off = all.iter().map(|at| (at - 0.972_027_423_620_860_4).abs());
    assert!(all.len() == 3 && { off }.all(|off| off < 1e-12), "{all:?}");
}

/// A branch of doubled orbits that leads from one doubling to another is not followed from there once more.
#[test]
fn nothing_is_followed_where_doubled_orbits_end() {
    let (found, told) = doubled_once("0.842", (0.8, 0.87));
    let [simple, _, doubled] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(simple.special.len(), 3);
    let again = End::Again(SpecialKind::BranchPoint);
    assert_eq!(doubled.ends, [again.clone(), again]);
    let listed: usize = found
        .iter()
        .map(|branch| branch.points.len() + branch.special.len())
        .sum();
    // Those beside special points are not listed.
    assert!(told < listed + listed / 10, "{told} orbits for {listed}");
}

/// A mass in guides that rub, against a stop at rest.
const GUIDED: &str = r#"
[parameters]
b = 1.059
[flight]
x = "v"
v = "1.5*cos(1.3*t) - x - b - 0.06*v - 0.25*sign(v)"
[[contact]]
name = "stop"
gap = "x"
impulse = { v = 1 }
restitution = 0.6
[initial]
x = 0.5
v = 0
"#;

/// The touches of a branch over b that goes through its range, as `expected`.
fn check_the_guided((start, range, step): (&str, (f64, f64), f64), expected: &[f64]) {
    let found = over(&with(GUIDED, &[("b", start)]), "b", range, (40, step));
    let touches: Vec<f64> = found[0].special.iter().map(value).collect();
    assert_eq!(touches.len(), expected.len(), "{touches:?}");
    assert!((touches.iter().zip(expected)).all(|(touch, at)| (touch - at).abs() < 1e-13));
    assert_eq!(found[0].ends, [End::Range, End::Range]);
}

/// A mass that rests against a stop by complete chatter, pressed upon by friction guides. Where it comes to hold at the top of its flight for a moment the field
/// turns back as the fall begins, by the flight in forty digits; and where the pull is no more than load and friction it rests for good. Beside that chatter comes to
/// nothing, and its lowest flights are solved for backwards in time as well.
#[test]
fn a_touch_beside_chatter_is_told_once() {
    check_the_guided(("1.04", (1.03, 1.2), 0.2), &[1.059_919_261_099_330_9]);
}

/// From where the mass rests all along, told from the instant at which it is pulled most: just there it begins to open.
#[test]
fn what_is_told_from_where_it_begins_to_open_goes_on_beyond() {
    check_the_guided(("1.3", (1.249_99, 1.3), 0.5), &[1.25]);
}

/// The same up to where the mass comes to rest all along.
#[test]
#[ignore = "takes ten seconds"]
fn touches_beside_chatter_are_told_once() {
    check_the_guided(
        ("1.059", (1.058, 1.3), 0.5),
        &[1.059_919_261_099_330_9, 1.25],
    );
}
