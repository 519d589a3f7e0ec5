//! What stands at rest on several contacts with dry friction, however its forces are shared out, and when it breaks away.

use chatter::analysis::simulate::{EventKind, Outcome, Simulation, Spec, simulate};
use chatter::flow::Closed;
use chatter::model::Model;
use std::ops::ControlFlow;

const GRAVITY: f64 = 9.81;

/// Of a block: half its width and height, and how far above its centre it is pushed.
const WIDTH: f64 = 0.15;
const HEIGHT: f64 = 0.5;
const ABOVE: f64 = 0.3;

/// Units of length and time.
const UNITS: [(f64, f64); 2] = [(1.0, 1.0), (1e-3, 60.0)];

fn run(text: &str, until: f64) -> Simulation<f64> {
    let model = Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate::<f64>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("a legal start")
}

/// A rigid block of mass one on feet at these parts of half its width, pushed sideways by a function of z = t/T, in L/T^2.
fn block(feet: &[f64], mu: f64, push: &str, (length, time): (f64, f64)) -> String {
    let mut text = format!(
        r#"
        [parameters]
        L = {length:?}
        T = {time:?}
        mu = {mu:?}
        [definitions]
        b = "{WIDTH:?}*L"
        h = "{HEIGHT:?}*L"
        I = "(b^2 + h^2)/3"
        s = "sin(th)"
        c = "cos(th)"
        z = "t/T"
        F = "({push})*L/T^2"
        [flight]
        x = "u"
        u = "F"
        y = "v"
        v = "-{GRAVITY:?}*L/T^2"
        th = "w"
        w = "-F*{ABOVE:?}*L/I"
        [initial]
        x = 0
        u = 0
        y = "h"
        v = 0
        th = 0
        w = 0
        "#
    );
    for (index, part) in feet.iter().enumerate() {
        text += &format!(
            r#"
            [[contact]]
            name = "foot{index}"
            gap = "y + {part:?}*b*s - h*c"
            impulse = {{ v = 1, w = "({part:?}*b*c + h*s)/I" }}
            restitution = 0.2
            [contact.friction]
            coefficient = "mu"
            along = {{ u = 1, w = "(h*c - {part:?}*b*s)/I" }}
            rate = "u + w*(h*c - {part:?}*b*s)"
            "#
        );
    }
    text
}

fn all(feet: &[f64]) -> Closed {
    (0..feet.len()).fold(Closed::NONE, Closed::with)
}

fn times(run: &Simulation<f64>, kind: EventKind) -> Vec<f64> {
    let events = run.events.iter();
    let of_kind = events.filter(|event| event.detail.kind() == Some(kind));
    of_kind.map(|event| event.time).collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(
        off <= tolerance * expected.abs().max(1.0),
        "{found} {expected}"
    );
}

/// With mu > b/h feet that slid would throw the block over; at rest they do not slide.
#[test]
fn a_block_stands_on_its_feet_however_rough_they_are() {
    for feet in [&[-1.0, 1.0][..], &[1.0, -1.0]] {
        for mu in [0.1, 0.3, 0.31, 0.6, 1.0] {
            for unit @ (length, time) in UNITS {
                let run = run(&block(feet, mu, "0", unit), 2.0 * time);
                assert_eq!(run.outcome, Outcome::Horizon, "{feet:?} {mu} {unit:?}");
                assert_eq!(run.closed, all(feet), "{feet:?} {mu} {unit:?}");
                let counts = (run.counts.impacts, run.counts.releases);
                assert_eq!(counts, (0, 0), "{feet:?} {mu} {unit:?}");
                assert!(run.state[0].abs() < 1e-13 * length, "{:?}", run.state);
                assert_eq!(run.state[1], 0.0);
                close(run.state[2] / length, HEIGHT, 1e-15);
                assert!(run.state[4].abs() < 1e-25, "{:?}", run.state);
            }
        }
    }
}

/// Pushed by F = z it slides from mu g on, or tips at F (h + a) = g b, whichever comes first; sliding it tips at F a = g (b - mu h).
#[test]
fn a_block_that_is_pushed_slides_or_tips_at_the_right_force() {
    let tips = GRAVITY * WIDTH / (HEIGHT + ABOVE);
    for feet in [[-1.0, 1.0], [1.0, -1.0]] {
        for mu in [0.1, 0.15, 0.4, 1.0] {
            for (push, sign) in [("z", 1.0), ("-z", -1.0)] {
                for unit @ (length, time) in [(1.0, 1.0)] {
                    let until = if mu == 0.1 { 2.4 } else { 2.6 };
                    let run = run(&block(&feet, mu, push, unit), until * time);
                    assert_eq!(run.outcome, Outcome::Horizon, "{feet:?} {mu} {unit:?}");
                    let [slips, releases] =
                        [EventKind::Slip, EventKind::Release].map(|kind| times(&run, kind));
                    let slides = mu * GRAVITY;
                    let (slip, release) = match mu {
                        0.1 => (Some(slides), None),
                        0.15 => (Some(slides), Some(GRAVITY * (WIDTH - mu * HEIGHT) / ABOVE)),
                        _ => (None, Some(tips)),
                    };
                    assert_eq!(releases.len(), usize::from(release.is_some()), "{mu}");
                    // Which foot sticks beside the other may change before: the last slip is that of both.
                    if let Some(expected) = slip {
                        close(slips[slips.len() - 1] / time, expected, 1e-12);
                    }
                    for (found, expected) in releases.iter().zip(release) {
                        close(found / time, expected, 1e-12);
                    }
                    if mu == 0.1 {
                        let way = sign * (until - slides).powi(3) / 6.0;
                        close(run.state[0] / length, way, 1e-12);
                    }
                }
            }
        }
    }
}

/// A constant force: what tips does so from the start on. Angle and place after 0.3 units of time are those of a rod that turns about its
/// foot, J th'' = F x'(th) - g y'(th) - F a, by SciPy's DOP853 to 1e-13.
#[test]
fn a_block_under_a_force_tips_from_the_start_or_stands() {
    for feet in [[-1.0, 1.0], [1.0, -1.0]] {
        for mu in [0.25, 1.0] {
            for sign in [1.0, -1.0] {
                for unit @ (length, time) in UNITS {
                    let stands = run(&block(&feet, mu, &format!("{sign}*1.8"), unit), 0.3 * time);
                    assert_eq!(stands.outcome, Outcome::Horizon);
                    assert_eq!(stands.closed, all(&feet), "{feet:?} {mu} {sign} {unit:?}");
                    assert!(stands.state[4].abs() < 1e-25, "{:?}", stands.state);
                    let tips = run(&block(&feet, mu, &format!("{sign}*1.9"), unit), 0.3 * time);
                    assert_eq!(tips.outcome, Outcome::Horizon);
                    let front = feet.iter().position(|&part| part == sign);
                    let front = front.map(|foot| Closed::NONE.with(foot));
                    assert_eq!(Some(tips.closed), front, "{feet:?} {mu} {sign} {unit:?}");
                    close(tips.state[4], -sign * 0.006_678_723_915_811, 1e-13);
                    let place = sign * 0.003_342_682_521_441_5;
                    close(tips.state[0] / length, place, 1e-13);
                }
            }
        }
    }
}

/// A crate on a rough floor at a smooth wall, pushed to it by P - z: friction may hold part of that, or all; it leaves the wall once
/// friction is exceeded, at z = P + mu g, and slides off with the rest of the force.
#[test]
fn a_crate_rests_in_a_corner_whatever_share_friction_holds() {
    let floor = r#"
        [[contact]]
        name = "floor"
        gap = "y"
        impulse = { v = 1 }
        restitution = 0.2
        friction = { coefficient = 0.4, along = { u = 1 } }
    "#;
    let wall = r#"
        [[contact]]
        name = "wall"
        gap = "x"
        impulse = { u = 1 }
        restitution = 0.2
    "#;
    let holds = 0.4 * GRAVITY;
    for (first, second) in [(floor, wall), (wall, floor)] {
        for push in [5.0, 3.924, 3.9, 1.0, -1.0] {
            for (length, time) in UNITS {
                let text = format!(
                    r#"
                    [parameters]
                    L = {length:?}
                    T = {time:?}
                    [flight]
                    x = "u"
                    u = "(t/T - ({push:?}))*L/T^2"
                    y = "v"
                    v = "-{GRAVITY:?}*L/T^2"
                    {first}
                    {second}
                    [initial]
                    x = 0
                    u = 0
                    y = 0
                    v = 0
                    "#
                );
                let run = run(&text, 12.0 * time);
                assert_eq!(run.outcome, Outcome::Horizon, "{push} {length} {time}");
                let releases = times(&run, EventKind::Release);
                assert_eq!(releases.len(), 1, "{push} {length} {time}");
                close(releases[0] / time, push + holds, 1e-12);
                let way = (12.0 - push - holds).powi(3) / 6.0;
                close(run.state[0] / length, way, 1e-11);
            }
        }
    }
}

/// Rough on both sides of a corner: a run from what another one says in its middle is the rest of that one. It leaves the wall where
/// 3 sin(2 t) - 1 = mu (g - 5.85 sin(3.4 t)), by bisection in SciPy.
#[test]
fn a_crate_in_a_rough_corner_goes_on_as_if_it_had_not_been_stopped() {
    let text = |(t, state): (f64, &[f64])| {
        format!(
            r#"
            [flight]
            x = "u"
            u = "3*sin(2*t) - 1"
            y = "v"
            v = "5.85*sin(3.4*t) - {GRAVITY:?}"
            [[contact]]
            name = "floor"
            gap = "y"
            impulse = {{ v = 1 }}
            restitution = 0.5
            friction = {{ coefficient = 0.4, along = {{ u = 1 }} }}
            [[contact]]
            name = "wall"
            gap = "x"
            impulse = {{ u = 1 }}
            restitution = 0.4
            friction = {{ coefficient = 0.4, along = {{ v = 1 }} }}
            [initial]
            t = {t:?}
            x = {:?}
            u = {:?}
            y = {:?}
            v = {:?}
            "#,
            state[0], state[1], state[2], state[3]
        )
    };
    let from = text((0.0, &[0.3, 0.0, 0.2, 0.0]));
    let whole = run(&from, 14.9);
    assert_eq!(whole.outcome, Outcome::Horizon);
    let releases = times(&whole, EventKind::Release);
    assert_eq!(releases.len(), 1);
    close(releases[0], 13.237_814_854_859_34, 1e-13);
    for split in [5.9, 6.1, 7.0, 9.5, 12.0, 13.2, 13.4] {
        let first = run(&from, split);
        let rest = run(&text((split, &first.state)), 14.9);
        assert_eq!(rest.outcome, Outcome::Horizon, "{split}");
        for (found, expected) in rest.state.iter().zip(&whole.state).take(4) {
            assert!(
                (found - expected).abs() < 1e-12,
                "{split}: {:?}",
                rest.state
            );
        }
        if split < 13.0 {
            close(times(&rest, EventKind::Release)[0], releases[0], 1e-13);
        }
    }
}
