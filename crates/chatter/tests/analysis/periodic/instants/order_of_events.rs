//! Orbits whose events change their order, or come to nothing: sections and knots that chatter passes, contacts that begin to open,
//! states that die out.

use crate::periodic::{HELD, PENDULUM, model, orbit, orbits_from, over, value, with};
use chatter::analysis::exponents::{Spec as Averages, exponents};
use chatter::analysis::periodic::{Branch, End, MarginKind, SpecialKind};
use chatter::analysis::simulate::{Spec as Until, simulate};
use chatter::numerics::Real;
use core::f64::consts::TAU;
use std::ops::ControlFlow;

/// Chatter ends at the time of the strobe at a = 1.6815; that is nothing that happens to the orbit.
#[test]
fn chatter_may_pass_the_section() {
    let found = over(&with(HELD, &[("a", "1.3")]), "a", (1.1, 2.0), (40, 0.02));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].ends, [End::Range, End::Range]);
    assert!(found[0].special.is_empty(), "{:?}", found[0].special);
    assert!(found[0].points.iter().all(|point| point.impacts.is_none()));
    // Told at the section all along.
    let phase = |state: &[f64]| (state[2] / TAU - (state[2] / TAU).round()).abs();
    assert!(found[0].points.iter().all(|p| phase(&p.state) < 1e-12));
}

/// At a = 1 the contact force touches zero: the contact opens there, and chatter begins with nothing. From both sides.
#[test]
fn a_branch_goes_on_where_a_contact_begins_to_open() {
    for start in ["0.5", "1.1"] {
        let found = over(&with(HELD, &[("a", start)]), "a", (0.5, 2.0), (40, 0.02));
        let Branch {
            special,
            ends,
            points,
        } = &found[0];
        assert_eq!(*ends, [End::Range, End::Range], "from {start}");
        let [touch] = &special[..] else {
            panic!("{special:?}");
        };
        assert_eq!(touch.kind, SpecialKind::Touch);
        assert_eq!(touch.point.impacts, Some(0));
        assert!((value(touch) - 1.0).abs() <= touch.error, "{touch:?}");
        for point in points {
            let opens = point.parameter() > 1.0;
            assert_eq!(point.impacts.is_none(), opens, "a {}", point.parameter());
        }
    }
}

/// A mass on a stop that a force of two harmonics throws up once a period; at b = 1 + a it is zero at its other crest, too, for an instant,
/// and beyond the contact opens there as well. What hangs on it swings on: its multipliers have the modulus exp(-0.04 pi).
#[test]
fn a_branch_goes_on_where_a_contact_that_rests_after_chatter_begins_to_open() {
    for (length, rate, steps) in [(1.0, 1.0, 2), (1e3, 1e-3, 1), (1e-3, 40.0, 1)] {
        let text = format!(
            "[parameters]\na = 0.3\nb = 1.3\nL = {length:?}\nw = {rate:?}\n[flight]\nx = 'v'\n\
             v = 'L*w^2*(-1 + a*cos(w*t) + b*cos(2*w*t)) - 0.1*w*v - w^2*x'\nz = 'q'\n\
             q = '-1.3*w^2*z - 0.04*w*q - 0.4*w^2*x'\n[[contact]]\nname = 'stop'\ngap = 'x'\n\
             impulse = {{ v = 1 }}\nrestitution = 0.4\n[section.strobe]\nsurface = 'sin(w*t)'\n\
             direction = 'rising'\n[initial]\nx = 0\nv = 0\nz = 0\nq = 0\n"
        );
        let ways = [0.2, 0.02].into_iter().take(steps);
        for (start, step) in ways.flat_map(|step| ["1.29", "1.31"].map(|start| (start, step))) {
            let context = format!("{length} {rate} from {start} by {step}");
            let found = over(&with(&text, &[("b", start)]), "b", (1.28, 1.32), (60, step));
            let branch = &found[0];
            assert_eq!(branch.ends, [End::Range, End::Range], "{context}");
            let told: Vec<_> = branch.special.iter().map(|s| (s.kind, value(s))).collect();
            let [touch] = &branch.special[..] else {
                panic!("{context}: {told:?}");
            };
            assert_eq!(touch.kind, SpecialKind::Touch, "{context}");
            assert_eq!(touch.persists, Some(true), "{context}");
            assert!((value(touch) - 1.3).abs() < 1e-12, "{context}: {touch:?}");
            let modulus = touch.point.multipliers[0].modulus();
            assert!(
                (modulus - (-0.04 * TAU / 2.0).exp()).abs() < 1e-9,
                "{context}: {modulus}"
            );
        }
    }
}

/// A part on a pan that shakes along its slope: at A sin(b) = cos(a) the pan just carries it at one crest, and beyond throws it there. From both sides:
/// from that of chatter flights shrink to nothing, by jerk alone in the end.
#[test]
fn a_part_goes_on_where_its_pan_begins_to_throw_it() {
    let touch: f64 = 0.1_f64.cos() / 0.6_f64.sin();
    // At the lesser coefficient friction stops the part only at impacts that come just as it turns.
    for (start, friction) in [(1.74, 0.4), (1.79, 0.4), (1.74, 0.2)] {
        let text = format!(
            "[parameters]\nA = {start}\n[flight]\ny = 'v'\nv = '-cos(0.1) + A*sin(0.6)*sin(t)'\nx = 'u'\n\
                 u = '-sin(0.1) + A*cos(0.6)*sin(t) - 0.05*u'\n[[contact]]\nname = 'pan'\ngap = 'y'\nimpulse = {{ v = 1 }}\n\
                 restitution = 0.3\nfriction = {{ coefficient = {friction}, along = {{ u = 1 }} }}\n[section.s]\nsurface = 'sin(t)'\n\
                 direction = 'rising'\n[initial]\ny = 0.1\nv = 0\nx = 0\nu = 0\n"
        );
        let branch = over(&with(&text, &[]), "A", (1.72, 1.8), (40, 0.05)).swap_remove(0);
        let context = format!("from {start}, {friction}");
        assert_eq!(branch.ends, [End::Range, End::Range], "{context}");
        let told: Vec<_> = branch.special.iter().map(|s| (s.kind, value(s))).collect();
        let [(SpecialKind::Touch, at)] = told[..] else {
            panic!("{context}: {told:?}");
        };
        assert!((at - touch).abs() < 1e-12, "{context}: {told:?}");
        for point in &branch.points {
            let opens = point.parameter() > touch;
            assert_eq!(
                point.impacts.is_none(),
                opens,
                "{context} {}",
                point.parameter()
            );
        }
    }
}

/// The same where it depends on the state when that crest comes, of a hopper with a light foot. The touch is that of impacts and flights by
/// matrix exponentials in 30 digits.
#[test]
fn a_hopper_goes_on_where_its_foot_begins_to_lift_twice() {
    const HOPPER: &str = "[parameters]\nF0 = 1.65\n[definitions]\nF = '20*(1 - x + y) - 1.5*(u - v)'\n[flight]\nx = 'u'\n\
                          u = '-1 + F + F0*cos(2*t)'\ny = 'v'\nv = '-1 - F/0.3'\n[[contact]]\nname = 'ground'\ngap = 'y'\n\
                          impulse = { v = 1 }\nrestitution = 0.6\n[section.strobe]\nsurface = 'sin(2*t)'\ndirection = 'rising'\n\
                          [initial]\nx = 1\nu = 0\ny = 0.05\nv = 0\n";
    for step in [0.05, 0.01] {
        let found = over(&with(HOPPER, &[]), "F0", (1.64, 1.7046), (60, step));
        let touches = found[0].special.iter();
        let touches: Vec<f64> = touches
            .filter(|special| special.kind == SpecialKind::Touch)
            .map(value)
            .collect();
        let [touch] = touches[..] else {
            panic!("{step}: {:?} {:?}", found[0].ends, found[0].special);
        };
        assert!(
            (touch - 1.704_504_447_306_841).abs() < 1e-11,
            "{step}: {touch}"
        );
        assert_eq!(found[0].ends, [End::Range, End::Range], "{step}");
    }
}

/// Impacts of complete chatter pass knots of the cam one by one, grazes of impacts beside them.
#[test]
#[ignore = "takes twenty seconds"]
fn chatter_may_pass_the_knots_of_a_table() {
    let found = over(&model("dwell_cam", &[]), "omega", (1.97, 2.05), (60, 0.01));
    let [branch] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(branch.ends, [End::Range, End::Range]);
    let grazes = branch.special.iter().map(|special| {
        assert_eq!(special.kind, SpecialKind::ImpactGraze);
        value(special)
    });
    let grazes: Vec<f64> = grazes.collect();
    let expected = [1.973_917_239_9, 1.987_882_281_6, 2.035_473_219_7];
    assert_eq!(grazes.len(), expected.len(), "{grazes:?}");
    assert!(
        grazes
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
}

/// x = 0 solves x'' + c x' + (1 + e cos t) x = 0: the product of its multipliers is exp(-2 pi c).
#[test]
fn what_dies_out_is_an_orbit_at_zero() {
    let text = "[parameters]\ne = 0.1\nc = 0.1\n[flight]\nx = \"v\"\nv = \"-(1 + e*cos(t))*x - c*v\"\n[[contact]]\nname = \"stop\"\ngap = \"1 - x\"\n\
                impulse = { v = -1 }\nrestitution = 0.5\n[section.strobe]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n[initial]\nx = 0.5\nv = 0\n";
    for (e, c) in [(0.0, 0.05), (0.05, 0.2), (0.1, 0.1), (0.3, 0.2)] {
        let found = orbit(&with(text, &[("e", &e.to_string()), ("c", &c.to_string())]));
        assert_eq!(found.impacts, Some(0));
        let all: f64 = found.multipliers.iter().map(|m| m.modulus()).product();
        assert!(
            (all / (-TAU * c).exp() - 1.0).abs() < 1e-10,
            "e {e}, c {c}: {all}"
        );
    }
}

#[test]
fn margins_say_what_they_are_of() {
    let found = orbit(&with(HELD, &[]));
    let kinds: Vec<MarginKind> = found.margins.iter().map(|margin| margin.kind).collect();
    assert!(kinds.contains(&MarginKind::LeastReaction), "{kinds:?}");
    assert!(!kinds.contains(&MarginKind::LeastGap), "{kinds:?}");
    let least = found
        .margins
        .iter()
        .find(|m| m.kind == MarginKind::LeastReaction);
    assert!((least.unwrap().value - 0.5).abs() < 1e-12);
}

/// A boost converter whose coil runs empty in each cycle: the current switches, and slides along zero. There is no contact, and no
/// chatter.
#[test]
fn several_events_at_one_instant_are_no_chatter() {
    let text = "[parameters]\nT = 10e-6\n[definitions]\non = \"step(0.4 - mod(t/T, 1))\"\n[flight]\n\
                i = \"if(on > 0.5, 12, if(i > 0, 12 - v, 1e6))/20e-6\"\nv = \"((1 - on)*i - v/60)/47e-6\"\n\
                [section.clock]\nsurface = \"sin(2*pi*t/T)\"\ndirection = \"rising\"\n[initial]\ni = 0.0\nv = 20.0\n";
    let found = orbit(&with(text, &[]));
    assert_eq!(found.impacts, Some(0));
    assert!((found.start[1].to_f64() - 25.536_207_823_755_72).abs() < 1e-11);
}

/// One direction is free of the contact and decays at a rate of 0.1; what complete chatter, or contact for ever, forgets has
/// none.
#[test]
fn exponents_forget_what_chatter_and_contact_forget() {
    let beside = "y = \"-0.1*y\"\n";
    let free = HELD
        .replace("- x\"\n", &format!("- x + 0.3*y\"\n{beside}"))
        .replace("v = 0\n", "v = 0\ny = 1\n");
    let spec = Averages {
        interval: TAU,
        transient: 150,
        intervals: 50,
    };
    let found = |text: &str, a: &str| {
        let model = with(text, &[("a", a)]);
        exponents(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    let chatters = found(&free, "1.9");
    assert!((chatters.values[0] + 0.1).abs() < 1e-10, "{chatters:?}");
    assert_eq!(chatters.values[1..], [f64::NEG_INFINITY; 2]);
    assert_eq!(found(HELD, "0.5").values, [f64::NEG_INFINITY; 2]);
}

/// A pendulum that hangs beside a wall which touches it at A = d: one graze, wherever its angle is counted from, and the fold of
/// the orbits with one impact.
#[test]
fn a_graze_from_rest_is_told_once() {
    let found = over(&with(PENDULUM, &[]), "A", (0.005, 0.1), (40, 0.01));
    let kinds: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, [SpecialKind::FlightGraze, SpecialKind::Fold]);
    assert!((value(&found[0].special[0]) - 0.05).abs() < 1e-12);
    assert!((value(&found[0].special[1]) - 0.013_440_262_5).abs() < 1e-9);
    assert!(found[0].points.len() < 400, "{}", found[0].points.len());
}

/// The section is crossed at a knot of the table in each turn, and which of the two comes first is rounding: the period is one turn.
#[test]
fn a_section_at_a_knot_does_not_lengthen_the_period() {
    const ROAD: &str = r#"
[parameters]
V = 1.1
[table.road]
x = [0, 1, 2, 3, 4, 5, 6]
y = [0, 0.3, 0.1, -0.2, 0.25, 0.05, 0]
kind = "periodic-cubic"
[flight]
s = "V"
x = "v"
v = "-(x - z) - 0.2*(v - w)"
z = "w"
w = "((x - z) + 0.2*(v - w) - 8*(z - 0.5*road(s)))/0.2"
[section.turn]
surface = "sin(2*pi*s/6)"
direction = "rising"
[initial]
s = 0
x = 0
v = 0
z = 0
w = 0
"#;
    for speed in ["1.03", "1.039", "1.1", "1.2", "1.3"] {
        let found = orbit(&with(ROAD, &[("V", speed)]));
        let period = 6.0 / speed.parse::<f64>().unwrap();
        let off = found.period.to_f64() / period - 1.0;
        assert!(off.abs() < 1e-12, "{speed}: {off:e}");
    }
}

/// A converter that switches where its voltage crosses a ramp, with the section at the very instant at which the ramp jumps back and
/// the converter switches as well: the period is one turn of the clock, and the multipliers are those of a product of two
/// matrix exponentials with its saltation.
#[test]
fn a_section_at_a_jump_does_not_lengthen_the_period() {
    const BUCK: &str = r#"
[parameters]
E = 22
[definitions]
ramp = "3.8 + 4.4*mod(t, 400e-6)/400e-6"
[flight]
v = "(i - v/22)/47e-6"
i = "(if(8.4*(v - 11.3) < ramp, E, 0) - v)/20e-3"
[section.clock]
surface = "sin(2*pi*t/400e-6)"
direction = "rising"
[initial]
v = 12
i = 0.5
"#;
    let found = orbit(&with(BUCK, &[]));
    let off = found.period.to_f64() / 400e-6 - 1.0;
    assert!(off.abs() < 1e-12, "{off:e}");
    let first = found.multipliers[0];
    assert!((first.re + 0.752_798_368_7).abs() < 1e-9, "{first:?}");
    assert!((first.im.abs() - 0.335_394_524_6).abs() < 1e-9, "{first:?}");
}

/// An oscillator under a force that is a table of time: its second turn is in other pieces of the table than the first.
#[test]
fn the_doubled_orbit_goes_on_in_later_pieces_of_a_table() {
    use crate::periodic::branch_spec;
    use chatter::analysis::periodic::{Beside, Spec, branches};
    let model = with(TRIANGLES, &[("F", "0.1")]);
    let beside = Beside {
        doublings: 1,
        branch_points: 0,
    };
    let spec = branch_spec(&model, ("F", (0.05, 0.25)), (5, 0.02), beside);
    let found = branches(&model, &Spec::default(), &spec, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(found.len(), 2);
    let doubling = super::super::nearest(&found, &[SpecialKind::PeriodDoubling], 0.193);
    assert_eq!(doubling.above, Some(true));
    let born = super::super::nearest(&found[1..], &[SpecialKind::BranchPoint], 0.193);
    assert!((value(&born) - value(&doubling)).abs() < 1e-12);
    assert!(
        found[1]
            .points
            .iter()
            .all(|point| (point.period / 12.0 - 1.0).abs() < 1e-9)
    );
    // Stable at first, as the doubling says.
    let first = |point: &&chatter::analysis::periodic::Point| {
        (0.1935..0.199).contains(&point.parameters[0])
    };
    assert!(
        found[1]
            .points
            .iter()
            .filter(first)
            .any(|point| point.is_stable())
    );
}

const TRIANGLES: &str = r#"
[parameters]
F = 0.4
[table.wave]
x = [0, 0.25, 0.75, 1]
y = [0, 1, -1, 0]
kind = "periodic-cubic"
[flight]
x = "v"
v = "-0.25*v + x - x^3 + F*wave(t/6)"
[section.clock]
surface = "sin(2*pi*t/6 - 1)"
direction = "rising"
[initial]
x = 1
v = 0
"#;

/// A loop from an impact before a knot to one after it has a leg that begins beyond its piece: no orbit, though its equations have a
/// solution. From many starts there is one orbit, and the motion from it comes back.
#[test]
fn a_leg_begins_within_its_piece() {
    const MESH: &str = r#"
[parameters]
om = 2
[table.mesh]
x = [0, 0.3, 0.5, 0.8, 1]
y = [1, 1.4, 1.4, 0.7, 1]
kind = "linear"
[flight]
p = "u"
u = "-0.16*u - mesh(mod(om*t/(2*pi), 1))*p + 0.3*cos(om*t)"
[[contact]]
gap = "0.05 - p"
impulse = { u = -1 }
restitution = 0.6
[section.strobe]
surface = "sin(om*t - 0.3)"
direction = "rising"
[initial]
p = 0
u = 0.1
"#;
    let model = with(MESH, &[]);
    let found = orbits_from(&model, (2, 60, 1));
    let [only] = &found[..] else {
        panic!("{} orbits", found.len());
    };
    let start: Vec<f64> = only.start.iter().map(|x| x.to_f64()).collect();
    let mut begun = model.clone();
    for (state, value) in model.states.iter().zip(&start) {
        begun.set_initial(&state.name, &value.to_string()).unwrap();
    }
    let until = start[2] + only.period.to_f64();
    let run = simulate::<f64>(&begun, &Until::until(until), &mut |_| {
        ControlFlow::Continue(())
    });
    let end = run.unwrap().state;
    for (a, b) in start[..2].iter().zip(&end) {
        assert!((a - b).abs() < 1e-12, "{start:?} {end:?}");
    }
}

/// A release at the very time of a jump of a force is one instant of two events, at which no cycle is told: another release is
/// found for that.
#[test]
fn a_release_may_share_its_instant_with_a_jump() {
    const SLAP: &str = r#"
[parameters]
r = 0.4
[definitions]
th = "10*t"
sb = "sin(th)/3"
side = "(200*if(mod(th, 4*pi) < pi, 1, 0.1) - 2.5*cos(th))*sb/sqrt(1 - sb^2)/0.5"
[flight]
y = "v"
v = "side - 2*v"
[[contact]]
name = "thrust"
gap = "1e-3 - y"
impulse = { v = -1 }
restitution = "r"
[[contact]]
name = "anti"
gap = "y + 1e-3"
impulse = { v = 1 }
restitution = "r"
[section.tdc]
surface = "sin(10*t/2)"
direction = "rising"
[initial]
y = 0
v = 0
"#;
    let orbit = orbit(&with(SLAP, &[]));
    assert!((orbit.period.to_f64() - 0.4 * core::f64::consts::PI).abs() < 1e-13);
    assert_eq!(orbit.impacts, None);
}

/// A magnet that a clock turns on and off holds a ball between floor and ceiling. Where the ball hits the floor as the clock ticks either may come
/// first, and the state after both is one: the branch goes on with the other order, and turns back there.
#[test]
fn an_impact_and_the_tick_of_a_clock_change_places() {
    let text = "[parameters]\nT = 2.0\nB = 3.0\n[flight]\ny = \"v\"\nv = \"-1 + if(m > 0.5, B*(1.2 - y), 0) - 0.1*v\"\nm = \"0\"\n\
                s = \"m - 0.7*s\"\n[[event]]\nname = \"tick\"\nsurface = \"sin(2*pi*t/T)\"\ndirection = \"either\"\n\
                reset = { m = \"if(m > 0.5, 0, 1)\" }\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
                [[contact]]\nname = \"top\"\ngap = \"1 - y\"\nimpulse = { v = -1 }\nrestitution = 0.5\n[initial]\ny = 0.5\nv = 0\nm = 0\ns = 0\n";
    for step in [0.02, 0.007] {
        let found = over(&with(text, &[]), "B", (1.9, 3.5), (8, step));
        let branch = &found[0];
        let touches = branch
            .special
            .iter()
            .filter(|special| special.kind == SpecialKind::Touch);
        let touches: Vec<_> = touches.collect();
        let [first, second] = [1.978_338_811_553_527, 1.954_857_459_088_327].map(|at| {
            let known = touches
                .iter()
                .find(|special| (value(special) - at).abs() < 1e-11);
            known.unwrap_or_else(|| panic!("{step}: {at} {:?}", branch.special.len()))
        });
        assert_eq!(
            (first.persists, second.persists),
            (Some(true), Some(false)),
            "{step}"
        );
        assert_eq!(branch.ends[1], End::Range, "{step}");
    }
}

/// A print hammer whose back stop is hit as the magnet is turned on: the branch turns back there, whether the pulse begins where a remainder jumps or
/// where a sine is zero. (The touches by DOP853 and Newton's method.)
#[test]
fn a_pulse_that_begins_where_a_remainder_jumps_changes_places_with_an_impact() {
    let spelled = [
        ("mod(t, T) < 0.5*T", 1.0),
        ("mod(t, T) < 0.5*T", 1e-3),
        ("sin(2*pi*t/T) > 0", 1.0),
    ];
    for (pulse, time) in spelled {
        let text = format!(
            "[parameters]\nI = 2.5\nT = {:?}\nw = {:?}\n[flight]\nx = 'v'\n\
             v = 'w^2*(if({pulse}, I, 0) - 2*(x + 0.1) - 8*max(x - 0.6, 0)^2) - 0.2*w*v'\n\
             [[contact]]\nname = 'platen'\ngap = '0.8 - x'\nimpulse = {{ v = -1 }}\nrestitution = 0.4\n\
             [[contact]]\nname = 'back'\ngap = 'x'\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
             [section.s]\nsurface = 'sin(2*pi*t/T - 1)'\ndirection = 'rising'\n[initial]\nx = 0.2\nv = 0\n",
            2.0 * time,
            1.0 / time
        );
        let branch = over(&with(&text, &[]), "I", (1.1, 3.5), (20, 0.02)).swap_remove(0);
        let context = format!("{pulse} {time}");
        let turns = branch
            .special
            .iter()
            .filter(|special| special.kind == SpecialKind::Touch);
        let turn = turns.min_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
        assert!(
            (value(turn) - 1.186_345_672_985_84).abs() < 1e-10,
            "{context}: {}",
            value(turn)
        );
        assert_eq!(turn.persists, Some(false), "{context}");
        assert_eq!(branch.ends, [End::Range, End::Range], "{context}");
    }
}

/// A tick that kicks a mass towards its wall: just before an impact they are one blow, just after it there is a second impact. So the branch ends where
/// they share an instant, and says that. There the mass is struck away at rate r (a + f), and comes back after one tick at rate a.
#[test]
fn a_branch_ends_where_the_order_of_two_blows_matters() {
    let (period, wall, drag, r): (f64, f64, f64, f64) = (4.9913, 0.354, 0.0673, 0.3818);
    for (length, time) in [(1.0, 1.0), (1e3, 1e-2)] {
        let text = format!(
            "[parameters]\nf = 0.6\n[flight]\nx = 'v'\nv = '-x/{} - {}*v'\ns = '1'\n[[event]]\nname = 'tick'\nsurface = 's - {}'\n\
             direction = 'rising'\nreset = {{ s = '0', v = 'v + {}*f' }}\n[[contact]]\nname = 'wall'\ngap = '{} - x'\n\
             impulse = {{ v = -1 }}\nrestitution = {r}\n[initial]\nx = {}\nv = 0\ns = 0\n",
            time * time,
            drag / time,
            period * time,
            length / time,
            wall * length,
            0.1 * length
        );
        let w = (1.0 - drag * drag / 4.0).sqrt();
        let (fade, (sin, cos)) = ((-0.5 * drag * period).exp(), (w * period).sin_cos());
        // From the wall at rate v to the wall: (x cos + (v + drag x/2) sin/w) fade = x.
        let slope = (wall / fade - wall * cos) * w / sin;
        let away = slope - 0.5 * drag * wall;
        let back = fade * (slope * cos - wall * w * sin) - 0.5 * drag * wall;
        let both = -away / r - back;
        for step in [0.02, 0.1] {
            let branch = over(&with(&text, &[]), "f", (0.5, 1.1), (6, step)).swap_remove(0);
            let touch = branch.special.last().unwrap();
            assert_eq!(touch.kind, SpecialKind::Touch, "{step}");
            assert!(
                (value(touch) - both).abs() < 1e-11,
                "{} {both}",
                value(touch)
            );
            let End::Lost(why) = &branch.ends[1] else {
                panic!("{step}: {:?}", branch.ends);
            };
            assert!(
                why.contains("the order in which they come matters"),
                "{why}"
            );
        }
    }
}
