//! What rests on a contact while something else slides or comes to rest on it by dry friction stays there.

use chatter::analysis::simulate::{EventKind, Outcome, Simulation, Spec, simulate};
use chatter::flow::Occurrence;
use chatter::model::Model;
use std::ops::ControlFlow;

fn run(text: &str, until: f64) -> Simulation<f64> {
    let model = Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate::<f64>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("a legal start")
}

/// A block that chattered to a stop while a sled slid over it. The sled comes to rest on the block, which its friction presses against the
/// stop until the sled's own force a - b t pulls both away, at t = a/b.
#[test]
fn a_block_stays_at_its_stop_when_the_sled_comes_to_rest_on_it() {
    for k in 0..24 {
        let speed = 1.2 + 0.0323 * f64::from(k);
        let text = format!(
            r#"
            [flight]
            V = "0.3 - 0.1*t - 0.9*sign(V - v)"
            x = "v"
            v = "0.9*sign(V - v)/0.6"
            [[contact]]
            name = "stop"
            gap = "0.3 - x"
            impulse = {{ v = -1 }}
            restitution = 0.3
            [initial]
            V = {speed}
            x = 0
            v = 0.2
            "#
        );
        let run = run(&text, 6.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{speed}");
        let counts = (run.counts.accumulations, run.counts.releases);
        assert_eq!(counts, (1, 1), "{speed}");
        // Three units of time with both at (a - b t)/(1 + m).
        let (moved, rate) = (-0.1 * 27.0 / 6.0 / 1.6, -0.1 * 9.0 / 2.0 / 1.6);
        for (found, expected) in run.state.iter().zip([rate, 0.3 + moved, rate]) {
            assert!((found - expected).abs() < 1e-12, "{speed}: {:?}", run.state);
        }
    }
}

/// A ball rests on a platform that swings to and fro until friction stops it: it stays there.
#[test]
fn a_ball_stays_on_a_platform_that_friction_stops() {
    for k in 0..12 {
        let speed = 0.3 + 0.017 * f64::from(k);
        let text = format!(
            r#"
            [flight]
            Y = "V"
            V = "(-40*Y - 9*sign(V))/3"
            y = "v"
            v = "-9.81"
            [[contact]]
            name = "plate"
            gap = "y - Y"
            impulse = {{ v = "1/0.2", V = "-1/3" }}
            restitution = 0.5
            [initial]
            Y = 0
            V = {speed}
            y = 0
            v = {speed}
            "#
        );
        let run = run(&text, 3.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{speed}");
        assert_eq!(run.counts.impacts, 0, "{speed}");
        assert_eq!(run.counts.releases, 0, "{speed}");
        assert_eq!(run.state[0], run.state[2], "{speed}");
        assert_eq!(run.state[1], run.state[3], "{speed}");
        assert!(run.state[1].abs() < 1e-15, "{speed}: {:?}", run.state);
    }
}

/// A hammer drives a pile that dry friction holds in between: it comes to rest on the pile by chatter, the pile sticks, and the hammer
/// lifts off. T is the unit of time alone; the place after two units is by an integrator of our own, in long doubles.
#[test]
fn a_hammer_lifts_off_a_pile_that_friction_holds() {
    for unit in ["1e-3", "0.1", "1", "10", "50"] {
        let text = format!(
            r#"
            [parameters]
            T = {unit}
            [flight]
            x = "v/T"
            v = "(9.81 + 35*sin(21*t/T) - 750*(x - 0.02))/T"
            s = "u/T"
            u = "(9.81 - 39*sign(u) - 2000*max(s - 0.001, 0) - 50*max(u, 0))/T"
            [[contact]]
            name = "anvil"
            gap = "s - x"
            impulse = {{ v = "-1/400", u = "1/900" }}
            restitution = 0.25
            [initial]
            x = -0.05
            v = 0
            s = 0
            u = 0
            "#
        );
        let until: f64 = unit.parse().expect("a number");
        let run = run(&text, 2.0 * until);
        assert_eq!(run.outcome, Outcome::Horizon, "{unit}");
        let counts = (run.counts.accumulations, run.counts.releases);
        assert_eq!(counts, (7, 7), "{unit}");
        assert!(
            (run.state[0] - 0.014_752_527_292_4).abs() < 1e-12,
            "{unit}: {:?}",
            run.state
        );
    }
}

/// What a magnet holds by its friction flies off as the magnet is turned round: nothing rubs any more.
#[test]
fn what_sticks_lets_go_where_its_force_jumps() {
    for (force, t) in [
        ("if(t < 1, 0, 1.3)", 1.0),
        ("1.3*step(t - 1)", 1.0),
        ("1.3*floor(t)", 1.0),
    ] {
        for belt in [0.178, 0.0, -2.0] {
            let text = format!(
                "[flight]\nx = \"v\"\nv = \"-0.5 + {force}\"\ny = \"u\"\nu = \"0.1 - y\"\n\
                 [[contact]]\nname = \"c\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0.4\n\
                 friction = {{ coefficient = 0.5, along = {{ u = 1 }}, rate = \"u - {belt}\" }}\n\
                 [initial]\nx = 0\nv = 0\ny = 0\nu = {belt}\n"
            );
            let run = run(&text, 1.9);
            assert_eq!(run.outcome, Outcome::Horizon, "{force} {belt}");
            assert_eq!(run.counts.releases, 1, "{force} {belt}");
            let since = 1.9 - t;
            assert!((run.state[0] - 0.4 * since * since).abs() < 1e-15);
            assert!((run.state[1] - 0.8 * since).abs() < 1e-15);
        }
    }
}

/// A crate is driven to and fro on another one that friction holds on a shaking floor, in states of some unit. It slips when its force
/// first exceeds the friction that its weight allows, and the one below never does: its own friction would hold fifteen times that.
#[test]
fn a_crate_slips_on_another_one_that_the_floor_holds() {
    let friction = |t: f64| 0.3 * 0.8 * (1.6 - 1.25 * libm::sin(2.5 * t));
    let (slip, stick) = ((EventKind::Slip, 1), (EventKind::Stick, 1));
    for k in 0..12 {
        let force = 0.2 + 0.02 * f64::from(k);
        let excess = |t: f64| (force * libm::cos(1.909 * t) - 0.09).abs() - friction(t);
        let (mut low, mut high) = (0.0, 0.0);
        while excess(high) < 0.0 {
            (low, high) = (high, high + 1e-3);
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            *(if excess(middle) < 0.0 {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        let mut runs = Vec::new();
        for [lower, upper] in [[1.0, 1.0], [0.37, 811.0], [1.0 / 7.0, 3.7]] {
            let text = format!(
                r#"
                [flight]
                x = "{lower}*u"
                y = "v"
                X = "{upper}*U"
                Y = "V"
                u = "0.304/1.93/{lower}"
                v = -1.6
                U = "({force}*cos(1.909*t) - 0.9*X)/0.8/{upper}"
                V = -1.6
                [[contact]]
                name = "floor"
                gap = "y - 0.2*sin(2.5*t)"
                impulse = {{ v = "1/1.93" }}
                restitution = 0.3
                friction = {{ coefficient = 0.5, along = {{ u = "1/1.93/{lower}" }}, rate = "{lower}*u" }}
                [[contact]]
                name = "crates"
                gap = "Y - y - 0.1"
                impulse = {{ v = "-1/1.93", V = "1/0.8" }}
                restitution = 0.6
                friction = {{ coefficient = 0.3, along = {{ u = "-1/1.93/{lower}", U = "1/0.8/{upper}" }}, rate = "{upper}*U - {lower}*u" }}
                [initial]
                x = 0
                y = 0
                X = 0.1
                Y = 0.1
                u = 0
                v = 0.5
                U = 0
                V = 0.5
                "#
            );
            let run = run(&text, 4.0);
            assert_eq!(run.outcome, Outcome::Horizon, "{force} {lower}");
            let told = run.events.iter().filter_map(|event| match event.detail {
                Occurrence::Slip { contact, .. } => Some((EventKind::Slip, contact, event.time)),
                Occurrence::Stick { contact } => Some((EventKind::Stick, contact, event.time)),
                _ => None,
            });
            let told: Vec<_> = told.collect();
            for (place, &(kind, contact, _)) in told.iter().enumerate() {
                let expected = if place % 2 == 0 { slip } else { stick };
                assert_eq!((kind, contact), expected, "{force} {lower} {told:?}");
            }
            assert!((told[0].2 - low).abs() < 1e-10, "{force} {lower}: {low}");
            let held = run.state[0].abs().max(run.state[4].abs());
            assert!(held < 1e-15, "{force} {lower}: {held}");
            runs.push((told, [run.state[2], run.state[6] * upper]));
        }
        let (times, end) = &runs[0];
        for (other, its_end) in &runs {
            let gaps = times.iter().zip(other).map(|(a, b)| (a.2 - b.2).abs());
            assert!(times.len() == other.len() && gaps.fold(0.0, f64::max) < 1e-9);
            assert!((end[0] - its_end[0]).abs() + (end[1] - its_end[1]).abs() < 1e-9);
        }
    }
}
