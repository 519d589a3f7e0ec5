//! What is told of each station of a branch is that orbit's, and no other's.

use crate::periodic::plane::curve_within;
use crate::periodic::{model, nearest, orbits_from, over, value, with};
use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, End, Known, Limits, Point, Spec, Special, SpecialKind, branches,
    settled,
};
use chatter::model::Model;
use chatter::numerics::{Complex, Real};
use std::ops::ControlFlow;

/// A ball on a table that moves with two harmonics.
const TABLE: &str = r#"
[parameters]
G = 1.5
[flight]
y = "v"
v = "-1"
[definitions]
tab = "G*(sin(t) + 0.3*sin(2*t + 0.7))"
[[contact]]
name = "table"
gap = "y - tab"
impulse = { v = 1 }
restitution = 0.5
[initial]
y = 3
v = 0
"#;

/// Two blocks and a belt whose friction falls with the velocity; the second is forced. There is no section.
const BLOCKS: &str = r#"
[parameters]
w = 1.1
A = 0.25
[flight]
x = "v"
v = "-x - 0.4*(x - y) - 0.05*v - 0.5*sign(v - 0.6)/(1 + 0.8*abs(v - 0.6))"
y = "u"
u = "-y - 0.4*(y - x) - 0.1*u + A*cos(w*t)"
[initial]
x = 0
v = 0
y = 0
u = 0
"#;

/// A harvester with two stops, each a spring with a damper, and a circuit.
const HARVESTER: &str = r#"
[parameters]
w = 0.8
[flight]
x = "v"
v = "-x - 0.04*v - 0.3*V + 0.35*cos(w*t) - if(x > 0.8, 20*(x - 0.8) + 0.2*v, 0) - if(x < -1, 20*(x + 1) + 0.2*v, 0)"
V = "0.3*v - 0.6*V"
[section.strobe]
surface = "sin(w*t)"
direction = "rising"
[initial]
x = 0
v = 0
V = 0
"#;

/// Orbits of so many impacts are closed anew.
const MOST: u64 = 5;

fn along(
    model: &Model,
    spec: &Spec,
    (name, range): (&str, (f64, f64)),
    longest_step: f64,
) -> Vec<Branch> {
    let spec_of_branch = BranchSpec {
        parameter: model.parameter_index(name).unwrap(),
        limits: Limits {
            range,
            other: None,
            impacts: 40,
            points: 5000,
            longest_step,
        },
        beside: Beside::default(),
    };
    branches(model, spec, &spec_of_branch, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Closes the orbit of each station anew, from the state and period that are told, and compares the characteristic polynomials.
fn tell_their_own(model: &Model, name: &str, found: &[Branch]) {
    let points = found.iter().flat_map(|branch| &branch.points);
    let points = points.filter(|point| point.impacts.is_some_and(|impacts| impacts <= MOST));
    let points: Vec<&Point> = points.collect();
    assert!(points.len() > 40, "{}", points.len());
    for point in points {
        let value = point.parameter();
        let mut there = model.clone();
        there.set_parameter(name, &format!("{value:?}")).unwrap();
        let spec = Spec {
            through: Some((point.state.clone(), point.period)),
            ..Spec::default()
        };
        // The orbit itself is between the steps to both sides.
        let closed = along(&there, &spec, (name, (value - 1e-4, value + 1e-4)), 1.0);
        let off = |own: &&Point| (own.parameter() - value).abs();
        let own = (closed[0].points.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let own = own.unwrap();
        assert!(off(&own) < 1e-14 * value, "{value}");
        let sum = |all: &[Complex]| all.iter().map(|m| m.re).sum::<f64>();
        let (told, own) = (sum(&point.multipliers), sum(&own.multipliers));
        assert!(
            (told - own).abs() < 1e-6 * own.abs().max(1.0),
            "{value}: {told} is told, {own} is right"
        );
    }
}

#[test]
fn stations_tell_their_own_multipliers() {
    let table = with(TABLE, &[]);
    let found = along(&table, &Spec::default(), ("G", (0.8, 3.0)), 0.02);
    tell_their_own(&table, "G", &found);
    let value = |special: &Special| special.point.parameter();
    let mut special = found.iter().flat_map(|branch| &branch.special);
    assert!(special.any(|special| {
        special.kind == SpecialKind::PeriodDoubling
            && (value(special) - 1.189_228_473_388_968_4).abs() < 1e-12
    }));
    let ball = model("bouncing_ball_on_table", &[("Gamma", "3")]);
    let all = orbits_from(&ball, (2, 60, 0));
    let through = (all.iter())
        .find(|orbit| orbit.impacts == Some(1) && (orbit.period.to_f64() - 0.2).abs() < 1e-9);
    let through = through.unwrap();
    let start: Vec<f64> = through.start.iter().map(|x| x.to_f64()).collect();
    let spec = Spec {
        through: Some((start, through.period.to_f64())),
        ..Spec::default()
    };
    let found = along(&ball, &spec, ("Gamma", (1.0, 4.0)), 0.02);
    tell_their_own(&ball, "Gamma", &found);
}

/// The zeros of a function are those of the state after one event, also where a touch changes which events there are.
#[test]
fn one_event_is_told_from_along_a_branch() {
    let blocks = with(BLOCKS, &[]);
    let spec = Spec {
        monitors: vec!["x - 0.4".to_owned()],
        ..Spec::default()
    };
    let found = along(&blocks, &spec, ("w", (0.6, 1.8)), 0.03);
    let special = found.iter().flat_map(|branch| &branch.special);
    let zeros = special.filter(|special| special.kind == SpecialKind::Monitor);
    let mut zeros: Vec<f64> = zeros.map(|special| special.point.parameter()).collect();
    zeros.sort_by(f64::total_cmp);
    assert_eq!(zeros.len(), 2, "{zeros:?}");
    for (zero, known) in zeros.iter().zip([0.916_722_9, 1.080_386_4]) {
        assert!((zero - known).abs() < 1e-7, "{zero}");
    }
}

#[test]
fn constants_are_not_watched() {
    let blocks = with(BLOCKS, &[]);
    let spec = Spec {
        monitors: vec!["1".to_owned()],
        ..Spec::default()
    };
    let found = settled(&blocks, &spec, &mut |_| ControlFlow::Continue(()));
    let said = found.unwrap_err().to_string();
    assert!(said.contains("is a constant"), "{said}");
}

/// Beyond where arcs end the orbit of complete chatter is the one whose border they end at, whatever lies farther away.
#[test]
fn what_is_followed_beyond_a_border_comes_back_to_it() {
    let table = with(TABLE, &[]);
    let found = over(&table, "G", (0.8, 3.0), (30, 0.01));
    let special = found.iter().flat_map(|branch| &branch.special);
    let borders = special.filter(|special| special.kind == SpecialKind::ChatterBorder);
    let values: Vec<f64> = borders.map(|border| border.point.parameter()).collect();
    assert!(
        values
            .iter()
            .any(|value| (value - 1.502_067_032_634_1).abs() < 1e-12),
        "{values:?}"
    );
    let chatters = found.iter().flat_map(|branch| &branch.points);
    let mut chatters = chatters.filter(|point| point.impacts.is_none());
    assert!(chatters.all(|point| (1.502..1.5221).contains(&point.parameter())));
}

/// The Ikeda map, by a clock that an event sets back.
const IKEDA: &str = r#"
[flight]
x = "0"
y = "0"
s = "1"
[definitions]
th = "0.4 - 6/(1 + x^2 + y^2)"
[[event]]
name = "tick"
surface = "s - 1"
direction = "rising"
reset = { x = "1 + 0.9*(x*cos(th) - y*sin(th))", y = "0.9*(x*sin(th) + y*cos(th))", s = "0" }
[initial]
x = 0.1
y = 0.1
s = 0
"#;

/// Three fixed points, a cycle of two points and two of three, by Newton's method on the map itself.
#[test]
fn events_count_as_returns_of_maps() {
    let found = orbits_from(&with(IKEDA, &[]), (3, 60, 0));
    let periods: Vec<f64> = found.iter().map(|orbit| orbit.period.to_f64()).collect();
    assert_eq!(periods.len(), 6, "{periods:?}");
    for (period, known) in periods.iter().zip([1.0, 1.0, 1.0, 2.0, 3.0, 3.0]) {
        assert!((period - known).abs() < 1e-12, "{periods:?}");
    }
}

/// Towards a touch the equations become singular by rounding: no row of a curve of doublings is told from there.
#[test]
#[ignore = "takes half a minute"]
fn a_curve_of_doublings_has_none_without() {
    let blocks = with(BLOCKS, &[]);
    let known = Known {
        kind: SpecialKind::PeriodDoubling,
        monitor: None,
        state: vec![
            0.176_407_336_748_431_37,
            0.6,
            -0.260_830_329_134_056_96,
            0.792_737_591_869_060_1,
            4.795_107_572_362_171,
        ],
        period: 6.803_784_937_584_993,
    };
    let limits = Limits {
        range: (0.1, 0.5),
        other: None,
        impacts: 60,
        points: 2000,
        longest_step: 0.05,
    };
    let told = (&known, 0.923_483_820_376_281_2);
    let curve = curve_within(&blocks, ["w", "A"], told, &limits).unwrap();
    assert!(curve.points.len() > 20, "{}", curve.points.len());
    for point in &curve.points {
        let off = |m: &Complex| (m.re + 1.0).hypot(m.im);
        let nearest = point
            .multipliers
            .iter()
            .map(off)
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-3, "{point:?}");
    }
    // It ends where the stick comes to nothing, whatever the steps.
    assert_eq!(curve.ends, [(); 2].map(|()| End::At(SpecialKind::Touch)));
    let touches = curve.special.iter();
    let mut touches: Vec<&Special> = touches
        .filter(|special| special.kind == SpecialKind::Touch)
        .collect();
    touches.sort_by(|a, b| a.point.parameter().total_cmp(&b.point.parameter()));
    let places = [0.158_601_264_827, 0.450_336_642_339];
    assert_eq!(touches.len(), places.len(), "{touches:?}");
    for (touch, place) in touches.iter().zip(places) {
        let off = (touch.point.parameter() - place).abs();
        assert!(off < 1e-11 && touch.error < 1e-10, "{touch:?}");
    }
}

/// Where the side changes on which doubled orbits lie is a property of the curve: the same from stations anywhere on it. Doubled orbits at
/// a finite distance tell it to 1e-4 only, since the orbit is next to a touch. (Found as well by Newton's method on the map of two periods of an
/// integration of its own, DOP853 between switches, at distances that are halved.)
#[test]
#[ignore = "takes half a minute"]
fn generalised_doublings_depend_on_no_step() {
    let blocks = with(BLOCKS, &[("A", "0.4678169389908977")]);
    let known = Known {
        kind: SpecialKind::PeriodDoubling,
        monitor: None,
        state: vec![
            0.3302691530675326,
            0.6,
            -0.019057964263635995,
            1.010412190184603,
            5.449400958035778,
        ],
        period: 7.222152833300791,
    };
    for longest_step in [0.1, 0.3] {
        let limits = Limits {
            range: (0.458, 0.482),
            other: None,
            impacts: 60,
            points: 2000,
            longest_step,
        };
        let told = (&known, 0.869_987_862_650_635_3);
        let curve = curve_within(&blocks, ["w", "A"], told, &limits).unwrap();
        let special = curve.special.iter();
        let sides = special.filter(|s| s.kind == SpecialKind::GeneralisedDoubling);
        let mut found: Vec<f64> = sides.map(|special| special.point.parameter()).collect();
        found.sort_by(f64::total_cmp);
        let expected = [0.463_042_496_379_018, 0.477_709_258_577_911];
        assert_eq!(found.len(), 2, "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{longest_step}: {found}");
        }
    }
}

/// A follower on a cam of two harmonics: its chatter is complete from W = 40.93 to 42.21.
const CAM: &str = r#"
[parameters]
W = 41.5
[flight]
y = "v"
v = "-60*y - 1.5*v - 40"
[definitions]
lift = "0.2*(1 - cos(W*t)) + 0.05*(1 - cos(2*W*t))"
[[contact]]
name = "cam"
gap = "y - lift"
impulse = { v = 1 }
restitution = 0.3
[initial]
y = 1
v = 0
"#;

/// Beyond a border the orbits with so many impacts are those that accumulate there, and not those that other motions come to: at every
/// step.
#[test]
fn arcs_beyond_a_border_come_back_to_it() {
    let cam = with(CAM, &[]);
    for longest_step in [0.03, 0.1] {
        let found = over(&cam, "W", (39.0, 45.0), (10, longest_step));
        let borders = [40.926_705_525_294, 42.212_566_031_793];
        for border in borders {
            let special = found.iter().flat_map(|branch| &branch.special);
            let mut told = special.filter(|s| s.kind == SpecialKind::ChatterBorder);
            assert!(told.any(|s| (s.point.parameter() - border).abs() < 1e-11));
            let arcs = found.iter().filter(|branch| {
                let ends = [branch.points.first(), branch.points.last()];
                let mut ends = ends.into_iter().flatten();
                ends.any(|end| {
                    end.impacts.is_some_and(|impacts| impacts >= 9)
                        && (end.parameter() - border).abs() < 1e-3
                })
            });
            assert_eq!(arcs.count(), 1, "{longest_step}: {border}");
        }
        assert_eq!(found.len(), 3, "{longest_step}");
        let points = found.iter().flat_map(|branch| &branch.points);
        let periods = points.map(|point| point.period * point.parameter());
        let turn = core::f64::consts::TAU;
        assert!({ periods }.all(|turns| (turns - 2.0 * turn).abs() < 1e-9));
    }
}

/// A gear with play between two teeth, driven by a torque that swings.
const GEAR: &str = r#"
[parameters]
T1 = 0.56
[flight]
x = "v"
v = "0.4 + T1*cos(0.5*t) - 0.1*v"
[[contact]]
name = "drive"
gap = "20 - x"
impulse = { v = -1 }
restitution = 0.65
[[contact]]
name = "coast"
gap = "x + 20"
impulse = { v = 1 }
restitution = 0.65
[section.strobe]
surface = "sin(0.5*t)"
direction = "rising"
[initial]
x = 0
v = 0
"#;

/// From complete chatter the arcs beyond its border are found, however few impacts are followed. Fold and doubling of nine impacts are those of the
/// impact map by its closed-form flights in 30 digits.
#[test]
fn arcs_beyond_the_border_of_chatter_are_found() {
    let found = over(&with(GEAR, &[]), "T1", (0.555, 0.6), (9, 0.1));
    let [chatters, arcs] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert!(chatters.ends.contains(&End::ChatterBorder));
    let border = nearest(&found, &[SpecialKind::ChatterBorder], 0.595);
    assert!((value(&border) - 0.595_011_214_149_952_8).abs() < 1e-13);
    assert!(arcs.ends.contains(&End::Impacts(9)), "{:?}", arcs.ends);
    let special = arcs.special.iter().map(|special| &special.point);
    let mut all = arcs.points.iter().chain(special);
    assert!(all.all(|point| point.impacts.is_some_and(|impacts| impacts <= 9)));
    for (kind, place) in [
        (SpecialKind::Fold, 0.597_250_184_461_502_9),
        (SpecialKind::PeriodDoubling, 0.597_459_920_434_091_4),
    ] {
        let told = nearest(&found, &[kind], place);
        assert_eq!(told.point.impacts, Some(9));
        assert!((value(&told) - place).abs() < 1e-13, "{told:?}");
    }
}

/// Beyond where a stop is touched multipliers change as the root of the distance does: a station that is nearer to it than it is known to, where they are
/// made of rounding, is that point.
#[test]
fn no_station_is_nearer_to_a_touch_than_that_is_known() {
    let mut beyond = 0;
    for (start, step) in [("0.785", 0.05), ("0.7914", 0.01), ("0.7914", 0.02)] {
        let harvester = with(HARVESTER, &[("w", start)]);
        let range = ("w", (0.78, 0.8));
        let found = along(&harvester, &Spec::default(), range, step);
        let branch = &found[0];
        let is_touch = |special: &&Special| special.kind == SpecialKind::Touch;
        let touches: Vec<&Special> = branch.special.iter().filter(is_touch).collect();
        let [touch] = touches[..] else {
            panic!("{step}: {}", touches.len());
        };
        let at = touch.point.parameter();
        assert!((at - 0.791_275_644_963_109_5).abs() < 1e-14, "{step}: {at}");
        let all = branch.points.iter().enumerate();
        let near = all.filter(|(_, point)| (point.parameter() - at).abs() < 1e-6);
        for (place, point) in near {
            let off = point.parameter() - at;
            assert_eq!(place >= touch.place, off > 0.0, "{step}: {off}");
            let both = point.multipliers.iter().zip(&touch.point.multipliers);
            let changed = both
                .map(|(a, b)| (a.re - b.re).hypot(a.im - b.im))
                .fold(0.0, f64::max);
            let most = 0.01 + 60.0 * off.abs().sqrt();
            assert!(changed < most, "{step}: {off} {changed}");
            beyond += usize::from(off > 0.0);
        }
    }
    assert!(beyond > 10, "{beyond}");
}
