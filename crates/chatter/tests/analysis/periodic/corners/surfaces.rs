//! Surfaces that come into use, and crossings that come and go.

use crate::periodic::{branch_spec, model, orbit, over, value, with};
use chatter::analysis::periodic::{Beside, Branch, End, Spec, SpecialKind, branches};
use chatter::analysis::simulate::{self, simulate};
use chatter::flow::Occurrence;
use chatter::model::Model;
use std::ops::ControlFlow;

/// Beyond a wall friction is dry: only there it matters which way the mass moves.
const FRICTION_BEYOND: &str = r#"
[parameters]
a = 3
[flight]
x = "v"
v = "a*cos(t) - 0.2*v - x - if(x > 0.4, 5*(x - 0.4) + 0.2*sign(v), 0)"
[initial]
x = 0
v = 0
"#;

/// The rate has changed its sign since it mattered last: that was no crossing, and is none where it matters again.
#[test]
fn a_surface_that_comes_into_use_is_not_crossed() {
    let model = with(FRICTION_BEYOND, &[]);
    let spec = simulate::Spec::until(60.0);
    let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    let switches = run.events.iter().filter_map(|event| match event.detail {
        Occurrence::Switch { surface, side } => Some((surface, side)),
        _ => None,
    });
    let switches: Vec<_> = switches.collect();
    assert!(switches.len() > 20);
    // Into the wall, back by the rate, and out of it.
    for visit in switches.chunks_exact(3) {
        assert_ne!(visit[0].0, visit[1].0);
        assert_eq!(visit[0].0, visit[2].0);
        assert_ne!(visit[0].1, visit[2].1);
    }
}

#[test]
fn an_orbit_takes_surfaces_into_use() {
    let found = orbit(&with(FRICTION_BEYOND, &[]));
    assert_eq!(found.impacts, Some(0));
    assert!(found.residual < 1e-25, "{found:?}");
    assert!(found.is_stable());
}

/// An oscillator before a stop that is in its force.
fn stop(force: &str, w: &str) -> Model {
    let text = format!(
        "[parameters]\nw = 1.8\n[flight]\nx = \"v\"\nv = \"0.5*cos(w*t) - 0.06*v - x - {force}\"\n[section.s]\n\
         surface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0\n"
    );
    with(&text, &[("w", w)])
}

/// The frequency at which x + late v of the oscillator without its stop has the amplitude 0.2: (1 - w^2)^2 + (0.06 w)^2 is the square of 0.5/0.2 times
/// 1 + (late w)^2.
fn touched_at(late: f64) -> f64 {
    let half = 0.5 * (2.0 - 0.06_f64.powi(2) + 6.25 * late.powi(2));
    (half + (half * half - 1.0 + 6.25).sqrt()).sqrt()
}

/// A soft stop that does not pull lets go before the mass has left it: within the stay beyond its surface is a corner that nothing asks for elsewhere. It is touched
/// where the amplitude without it is its place, whichever way, and from all starts.
#[test]
fn a_stay_with_a_corner_that_is_there_alone_comes_and_goes() {
    let exact = touched_at(0.0);
    for (start, step) in [
        ("1.8", 0.1),
        ("1.75", 0.03),
        ("1.86", 0.013),
        ("1.83", 0.3),
        ("1.95", 0.1),
    ] {
        let model = stop("if(x > 0.2, max(15*(x - 0.2) + 2*v, 0), 0)", start);
        let found = over(&model, "w", (1.7, 2.0), (4, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        let [touch] = &branch.special[..] else {
            panic!("{start} {step} {:?}", branch.special);
        };
        assert_eq!(touch.kind, SpecialKind::Touch);
        assert!(
            (value(touch) - exact).abs() < 1e-14,
            "{start} {step} {touch:?}"
        );
        assert_eq!(touch.point.multipliers.len(), 2, "{start} {step}");
    }
}

/// The same stop typed with a corner that is everywhere: as it is touched that shares the instant of the crossing and of the way back, which is one touch. The
/// corner itself is touched where its own amplitude is its place.
#[test]
fn a_stay_comes_and_goes_at_the_corner_of_what_does_not_pull() {
    let exact = [0.0, 2.0 / 15.0].map(touched_at);
    for (start, step) in [("1.8", 0.1), ("1.75", 0.2), ("1.79", 0.07), ("1.95", 0.1)] {
        let model = stop("max(15*(x - 0.2) + 2*v, 0)*step(x - 0.2)", start);
        let found = over(&model, "w", (1.7, 2.0), (4, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        let touches: Vec<f64> = branch.special.iter().map(value).collect();
        assert_eq!(touches.len(), 2, "{start} {step} {touches:?}");
        for (touch, exact) in touches.iter().zip(exact) {
            assert!((touch - exact).abs() < 1e-14, "{start} {step} {touches:?}");
        }
    }
}

/// The soft stop is touched from both sides: where all that happens is a crossing and the way back, too.
#[test]
fn the_only_crossing_may_come_and_go() {
    for start in ["0.05", "0.3"] {
        let model = model("soft_stop", &[("load", start)]);
        let found = over(&model, "load", (0.02, 0.4), (40, 0.02));
        assert_eq!(found[0].ends, [End::Range, End::Range], "from {start}");
        let kinds: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
        let expected = [SpecialKind::Touch, SpecialKind::Fold, SpecialKind::Fold];
        assert_eq!(kinds, expected, "from {start}");
        assert!((value(&found[0].special[0]) - 0.228_035_085_019_827).abs() < 1e-13);
    }
}

/// A graze while two blocks stick together by friction: the weakest impact parts them, and then the force is towards the wall. Beyond
/// it no orbit with one impact more is told.
#[test]
fn a_graze_that_parts_what_sticks_together_ends_the_branch() {
    let text = r#"
    [parameters]
    A = 3.0
    [flight]
    x = "u"
    u = "A*cos(1.7*t) - 4*x - 0.9*sign(u - v)"
    y = "v"
    v = "(0.9*sign(u - v) - 0.5*y)/0.6"
    [[contact]]
    name = "first"
    gap = "0.6 - x"
    impulse = { u = -1 }
    restitution = 0.55
    [[contact]]
    name = "left"
    gap = "y + 0.7"
    impulse = { v = 1 }
    restitution = 0.55
    [[contact]]
    name = "right"
    gap = "0.7 - y"
    impulse = { v = -1 }
    restitution = 0.3
    [initial]
    x = 0
    u = 0.5
    y = 0.1
    v = -0.2
    "#;
    let found = over(&with(text, &[]), "A", (2.0, 4.0), (20, 0.05));
    let special: Vec<_> = (found.iter().flat_map(|branch| &branch.special))
        .map(|special| (special.kind, value(special)))
        .collect();
    let fold = |at: f64| (at - 3.016_260_102).abs() < 1e-8;
    let graze = |at: f64| (at - 2.873_461_2).abs() < 1e-6;
    // A second slide comes in: the least value of u - v without it falls from 0.0221 at 2.05 over 0.0050 at 2.08 to zero.
    // At 2.4690 the blocks stick from 5.95e-4 before an impact, at 2.4702 they slip on to it, with other multipliers.
    // The impacts of both blocks change places: 5e-6 apart at 2.2869, 9e-6 the other way at 2.2870, with other multipliers.
    let touch = |at: f64| {
        [2.088_715_6, 2.286_937_8, 2.469_600_4]
            .iter()
            .any(|known| (at - known).abs() < 1e-6)
    };
    assert!(
        special.iter().all(|&(kind, at)| match kind {
            SpecialKind::Fold => fold(at),
            SpecialKind::FlightGraze | SpecialKind::ImpactGraze => graze(at),
            SpecialKind::Touch => touch(at),
            _ => false,
        }),
        "{special:?}"
    );
    assert!(special.iter().any(|&(_, at)| graze(at)), "{special:?}");
    let ends: Vec<String> = found[0].ends.iter().map(End::to_string).collect();
    assert!(
        ends.iter().any(|end| end.contains("that it slides along")),
        "{ends:?}"
    );
}

/// A spring that begins to push at x = 1: the field is continuous there.
const ONE_SIDED: &str = r#"
[parameters]
w = 1.25
k = 5
[flight]
x = "v"
v = "-0.1*v - x - k*max(x - 1, 0) + 0.5*cos(w*t)"
[initial]
x = 0
v = 0
"#;

/// Multipliers are those of the flow, whose product is known, however slowly the spring is reached; and where the amplitude of the linear
/// oscillator is that of the spring is a touch, told once, by whatever steps it is come to.
#[test]
fn a_spring_is_touched_once_and_multipliers_are_those_of_the_flow() {
    let c: f64 = 0.1;
    // (1 - w^2)^2 + c^2 w^2 = 1/4
    let (half, root) = (1.0 - 0.5 * c * c, (0.25 - c * c + 0.25 * c.powi(4)).sqrt());
    let touches = [(half - root).sqrt(), (half + root).sqrt()];
    for (start, step) in [("1.25", 0.006), ("1.25", 0.02), ("0.6", 0.02)] {
        let model = with(ONE_SIDED, &[("w", start)]);
        let found = over(&model, "w", (0.5, 1.9), (0, step));
        let [branch] = &found[..] else {
            panic!("{} branches", found.len())
        };
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        for point in &branch.points {
            let [one, two] = point.multipliers[..] else {
                panic!()
            };
            let (product, flow) = (one.times(two).re, (-c * point.period).exp());
            assert!(
                (product - flow).abs() < 1e-8 * flow,
                "{product} {flow} at {:?}",
                point.parameters
            );
        }
        let told: Vec<f64> = (branch.special.iter())
            .filter(|special| special.kind == SpecialKind::Touch)
            .map(value)
            .collect();
        assert_eq!(told.len(), 2, "{told:?} by {step} from {start}");
        let off = told.iter().zip(touches).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-13, "{told:?} {touches:?}");
        assert!(
            branch
                .special
                .iter()
                .all(|special| special.kind != SpecialKind::NeimarkSacker)
        );
    }
}

/// A stiff spring lets the period double as soon as it is touched, nearer than the first orbit beyond.
#[test]
fn a_doubling_next_to_a_touch_is_told_from_both_sides() {
    for (start, to) in [("0.7", 0.8), ("0.98", 1.0)] {
        let model = with(ONE_SIDED, &[("w", start), ("k", "200")]);
        let found = over(&model, "w", (0.65, to), (0, 0.05));
        let kinds: Vec<SpecialKind> = found[0]
            .special
            .iter()
            .map(|special| special.kind)
            .collect();
        assert_eq!(
            kinds[..2],
            [SpecialKind::Touch, SpecialKind::PeriodDoubling],
            "from {start}"
        );
        let [touch, doubling] = [0, 1].map(|index| value(&found[0].special[index]));
        assert!(
            (doubling - touch - 5.8e-7).abs() < 1e-8,
            "{touch} {doubling}"
        );
        assert_eq!(found[0].special[0].persists, Some(true));
    }
}

/// A chamber behind an orifice: its flow begins with a root wherever the pressure turns its sign. With y = sqrt(p) and dt = 2 y ds its equations
/// are smooth, y' = a cos t - y: so integrated, half of the orbit takes half a period from these phases.
#[test]
fn a_branch_goes_on_where_its_legs_begin_with_a_root() {
    let text = r#"
    [parameters]
    a = 0.3
    [flight]
    p = "a*cos(t) - sign(p)*sqrt(abs(p))"
    [initial]
    p = 0.2
    "#;
    for (start, step) in [("0.3", 0.03), ("0.5", 0.02)] {
        let found = over(&with(text, &[("a", start)]), "a", (0.2, 0.5), (4, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range]);
        assert!(branch.special.is_empty(), "{:?}", branch.special);
        let expected = [1.590_337_146_465_480_5, 1.815_867_076_962_969];
        let ends = [&branch.points[0], &branch.points[branch.points.len() - 1]];
        for (end, phase) in ends.into_iter().zip(expected) {
            let off = (end.state[1].rem_euclid(core::f64::consts::PI) - phase).abs();
            assert!(off < 1e-12, "{end:?}");
        }
    }
}

/// Springs with preload to both sides and a stop, spelled as a choice within a choice and as two choices: from above the surface of one spring the other
/// one's is asked for only beyond it. Seen from the orbit that only just stays above it a stay begins there, and the branch turns back. (Integrated with
/// scipy: at w = 0.5615932375 the surface is crossed at the rate 0.01, and both orbits are one at 0.56042795.)
#[test]
fn a_surface_within_a_choice_is_known_where_a_stay_begins() {
    let springs = [
        "if(x > s, P + k*(x - s), if(x < -s, -P + k*(x + s), 0))",
        "P*step(x - s) + k*max(x - s, 0) - P*step(-x - s) + k*min(x + s, 0)",
    ];
    let start = (
        vec![0.3, -0.01, 1.885_679_912_252_226_8],
        core::f64::consts::TAU / 0.561_593_237_487_019_1,
    );
    let told = springs.map(|spring| {
        let text = format!(
            "[parameters]\nw = 0.5615932374870191\nP = 0.15\nk = 3\ns = 0.3\n[flight]\nx = 'v'\n\
             v = '0.9*cos(w*t) - 0.06*v - 0.3*x - ({spring})'\n\
             [[contact]]\nname = 'stop'\ngap = '0.9 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.6\n\
             [initial]\nx = 0\nv = 0\n"
        );
        let model = with(&text, &[]);
        let follow = |model: &Model, through: (Vec<f64>, f64)| {
            let beside = Beside::default();
            let what = branch_spec(model, ("w", (0.55, 0.566)), (6, 0.05), beside);
            let spec = Spec { through: Some(through), ..Spec::default() };
            branches(model, &spec, &what, Vec::new(), &mut |_| ControlFlow::Continue(())).unwrap().swap_remove(0)
        };
        let points = |found: &Branch| {
            let all = found.special.iter().map(|special| (special.kind, value(special)));
            let mut all: Vec<(SpecialKind, f64)> = all.collect();
            all.sort_by(|a, b| a.1.total_cmp(&b.1));
            all
        };
        let found = follow(&model, start.clone());
        // The same from an orbit that stays above.
        let whole = found.points.iter().find(|point| point.parameters[0] < 0.5605).unwrap();
        let mut there = model.clone();
        there.set_parameter("w", &format!("{:?}", whole.parameters[0])).unwrap();
        let again = follow(&there, (whole.state.clone(), whole.period));
        let [one, other] = [points(&found), points(&again)];
        assert_eq!(one.len(), other.len(), "{one:?} and {other:?}, {:?} and {:?}", found.ends, again.ends);
        one
    });
    assert!(
        told[0]
            .iter()
            .zip(&told[1])
            .all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-12)
    );
    assert!(told[0].iter().any(
        |(kind, w)| *kind == SpecialKind::Touch && (w - 0.560_427_949_547_555_9).abs() < 1e-12
    ));
    assert_eq!(told[0].len(), told[1].len());
}
