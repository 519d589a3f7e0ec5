//! Rest on a surface that no side changes the rate of, but only the acceleration: preloaded springs and joints (docs/piecewise.md).

use super::run;
use chatter::analysis::simulate::{Outcome, SimulateError, Simulation, Spec, simulate};
use chatter::flow::{EventKind, FlowError};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use std::ops::ControlFlow;

fn ends_at(run: &Simulation<f64>, expected: &[f64], within: f64) {
    assert_eq!(run.outcome, Outcome::Horizon);
    for (x, expected) in run.state.iter().zip(expected) {
        assert!((x - expected).abs() <= within, "{x} {expected}");
    }
}

fn kinds(run: &Simulation<f64>) -> Vec<EventKind> {
    let kinds = run.events.iter().map(|event| event.detail.kind());
    kinds.flatten().collect()
}

/// A preloaded joint rests for as long as it is pushed by less than its preload: x'' = -sign(x) - x + a sin t from rest. Then
/// x + 1 follows the forced oscillator from x = x' = 0 at sin t0 = 1/a, in resonance: x = -1 + a (sin t - t cos t)/2 + A cos t + B sin t.
#[test]
fn a_preloaded_joint_rests_until_it_is_pushed_by_more() {
    let text = |push: f64| {
        format!(
            "[flight]\nx = \"v\"\nv = \"-sign(x) - x + {push}*sin(t)\"\n[initial]\nx = 0\nv = 0\n"
        )
    };
    let rests = run::<f64>(&text(0.9), 40.0);
    ends_at(&rests, &[0.0, 0.0], 0.0);
    let push = 1.5;
    let run = run::<f64>(&text(push), 1.7);
    let leaves = (1.0 / push).asin();
    let events: Vec<f64> = run.events.iter().map(|event| event.time).collect();
    assert!((events[0] - leaves).abs() < 1e-14, "{events:?}");
    let forced = |t: f64| -1.0 + push * (t.sin() - t * t.cos()) / 2.0;
    let forced_rate = |t: f64| push * t * t.sin() / 2.0;
    let (x0, v0, s, c) = (
        -forced(leaves),
        -forced_rate(leaves),
        leaves.sin(),
        leaves.cos(),
    );
    let (a, b) = (x0 * c - v0 * s, x0 * s + v0 * c);
    let t = 1.7_f64;
    let expected = [
        forced(t) + a * t.cos() + b * t.sin(),
        forced_rate(t) - a * t.sin() + b * t.cos(),
    ];
    ends_at(&run, &expected, 1e-14);
}

/// In any unit of time and length, and mirrored, two of them that a spring couples move alike.
#[test]
fn preloaded_bodies_move_alike_in_all_units() {
    let end = |time: f64, length: f64| {
        let text = format!(
            "[flight]\nx = \"v/{time:?}\"\nv = \"(-sign(x/({length:?})) - x/({length:?}) + 1.5*sin(t/{time:?}) \
             - 0.4*(x - y)/({length:?}) - 0.3*v/({length:?}))*({length:?})/{time:?}\"\ny = \"w/{time:?}\"\n\
             w = \"(-0.1*sign(y/({length:?})) - y/({length:?}) + 0.4*(x - y)/({length:?}) - 0.2*w/({length:?}))*({length:?})/{time:?}\"\n\
             [initial]\nx = 0\nv = 0\ny = 0\nw = 0\n"
        );
        let run = run::<f64>(&text, 20.0 * time);
        let left = kinds(&run)
            .into_iter()
            .filter(|&kind| kind == EventKind::Leave)
            .count();
        let state: Vec<f64> = run.state[..4].iter().map(|x| x / length).collect();
        (state, left)
    };
    let (expected, left) = end(1.0, 1.0);
    assert!(left >= 1);
    for (time, length) in [(0.37, 1.0), (13.0, 0.21), (1.0, -3.0), (1e-4, 25.4)] {
        let (state, same) = end(time, length);
        assert_eq!(same, left);
        for (x, expected) in state.iter().zip(&expected) {
            assert!((x - expected).abs() < 1e-13, "{x} {expected}");
        }
    }
}

/// A body that rests so is thrown off by an impact, and from the very surface: v = (1 + r) m2 w/(m1 + m2) after it.
#[test]
fn an_impact_throws_a_preloaded_body_off_its_rest() {
    for (start, speed) in [(-1.0, 1.3), (-0.7, 0.9), (-3.0, 2.1)] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-sign(x) - x\"\ny = \"w\"\nw = \"0\"\n[[contact]]\nname = \"hit\"\ngap = \"x - y\"\n\
             impulse = {{ v = 1, w = -0.5 }}\nrestitution = 0.6\n[initial]\nx = 0\nv = 0\ny = {start:?}\nw = {speed:?}\n"
        );
        let hit = -start / speed;
        let run = run::<f64>(&text, hit + 0.3);
        assert_eq!(kinds(&run), [EventKind::Impact, EventKind::Leave]);
        let rate = 1.6 * speed / 1.5;
        let expected = [
            -1.0 + 0.3_f64.cos() + rate * 0.3_f64.sin(),
            rate * 0.3_f64.cos() - 0.3_f64.sin(),
            0.3 * (speed - rate / 2.0),
            speed - rate / 2.0,
        ];
        ends_at(&run, &expected, 1e-14);
    }
}

/// Swings between a relay a sign(x) and friction b sign(v), a > b, from rest at x0: each rises and falls for
/// sqrt(2 x0) (1/sqrt(a - b) + sqrt(a - b)/(a + b)), and the next one is shorter by sqrt((a - b)/(a + b)). So they end in rest, which a push
/// that grows as t ends at a + b: from there x is a cubic.
#[test]
fn ever_shorter_swings_end_in_rest() {
    fn check<R: Real>([a, b]: [f64; 2], [time, length]: [f64; 2], within: f64) {
        let text = |push: &str| {
            format!(
                "[flight]\nx = \"v/{time:?}\"\nv = \"(-{a:?}*sign(x/({length:?})) - {b:?}*sign(v/({length:?})) + {push})*({length:?})/{time:?}\"\n\
                 [initial]\nx = \"0.5*({length:?})\"\nv = 0\n"
            )
        };
        let first = 1.0 / (a - b).sqrt() + (a - b).sqrt() / (a + b);
        let ends = first / (1.0 - ((a - b) / (a + b)).sqrt());
        let rests = run::<R>(&text("0"), time * (ends + 3.0));
        assert_eq!(rests.outcome, Outcome::Horizon, "{a} {b} {time} {length}");
        assert!(rests.state[..2].iter().all(|x| x.to_f64() == 0.0));
        let last = rests.events.last().map(|event| event.time.to_f64() / time);
        assert!(
            last.is_some_and(|last| (last - ends).abs() < within),
            "{a} {b}: {last:?} {ends}"
        );
        let push = format!("if(t/{time:?} > {ends:?}, t/{time:?}, 0)");
        let pushed = run::<R>(&text(&push), time * (a + b + 1.0));
        assert_eq!(pushed.outcome, Outcome::Horizon, "{a} {b} {time} {length}");
        let [x, v] = [0, 1].map(|k| pushed.state[k].to_f64() / length);
        assert!(
            (x - 1.0 / 6.0).abs() < 1e-12 && (v - 0.5).abs() < 1e-12,
            "{a} {b} {time} {length}: {x} {v}"
        );
    }
    for (time, length) in [(1.0, 1.0), (0.37, 25.4), (13.0, -3.0), (1e-5, 0.21)] {
        check::<f64>([5.0, 3.0], [time, length], 1e-13);
        check::<f64>([4.0, 1.0], [time, length], 1e-13);
    }
    check::<DoubleDouble>([5.0, 3.0], [1.0, 1.0], 1e-15);
}

/// A preloaded joint with friction that is forced comes to rest where closed forms of its swings do, followed in fifty digits until they
/// are shorter than 1e-18, and stays, as 0.9 < 1 + 0.3.
#[test]
fn a_forced_joint_comes_to_rest_between_preload_and_friction() {
    let text = "[flight]\nx = \"v\"\nv = \"-sign(x) - x - 0.3*sign(v) + 0.9*sin(t)\"\n[initial]\nx = 0.5\nv = 0\n";
    let run = run::<f64>(text, 25.0);
    ends_at(&run, &[0.0, 0.0], 0.0);
    let mut slides = (run.events.iter()).filter(|e| e.detail.kind() == Some(EventKind::Slide));
    let slides = slides.find(|event| event.state[0].abs() < 1e-20);
    let rests = slides.map(|event| event.time);
    assert!(
        rests.is_some_and(|t| (t - 9.745_127_853_782_658).abs() < 1e-12),
        "{rests:?}"
    );
}

/// Where the force leads away on both sides, rest is only one of the motions there: that is said.
#[test]
fn rest_on_a_repelling_force_is_not_unique() {
    let text = "[flight]\nx = \"v\"\nv = \"sign(x)\"\n[initial]\nx = 0\nv = 0\n";
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let refused = simulate::<f64>(
        &model,
        &Spec::until(1.0),
        &mut |_| ControlFlow::Continue(()),
    );
    assert!(matches!(
        refused,
        Err(SimulateError::Start(FlowError::NotUnique { time, .. })) if time == 0.0
    ));
}

/// A spring between dry frictions that comes to rest at their very limit stays: that it is pulled by a rounding error beyond is no
/// motion. It swings from 3 mu to -mu, is kicked each turn and brought to rest at 3 mu.
#[test]
fn what_stops_at_the_limit_of_friction_stays() {
    for k in 0..12 {
        let kick = 1.4 + 0.1 * f64::from(k);
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-x - 0.3*sign(v)\"\n[[event]]\nname = \"kick\"\nsurface = \"sin(t)\"\n\
             direction = \"rising\"\nreset = {{ v = \"v + {kick:?}\" }}\n[[event]]\nname = \"brake\"\nsurface = \"x - 0.9\"\n\
             direction = \"rising\"\nreset = {{ v = 0 }}\n[initial]\nx = 0\nv = 0\n"
        );
        // At the end of the 30th turn it has long been at rest.
        ends_at(
            &run(&text, 30.0 * std::f64::consts::TAU - 0.1),
            &[-0.3, 0.0],
            1e-13,
        );
    }
}
