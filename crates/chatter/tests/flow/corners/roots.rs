//! Forces that are roots and powers of how far a state is beyond a surface: Hertzian contacts, flow through an orifice. No series in time
//! begins on the surface, nor does one reach it, and motion goes through.

use super::run;
use chatter::analysis::simulate::{Outcome, SimulateError, Simulation, Spec, simulate};
use chatter::flow::{Column, FlowError, Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use core::f64::consts::PI;
use std::ops::ControlFlow;

fn switches<R: Real>(run: &Simulation<R>) -> Vec<f64> {
    (run.events.iter())
        .filter(|event| matches!(event.detail, Occurrence::Switch { .. }))
        .map(|event| event.time.to_f64())
        .collect()
}

/// Energy is conserved over many bounces, however the force is written, and flights between them are all as long.
#[test]
fn a_ball_on_hertzian_ground_keeps_its_energy() {
    let forms = [
        ("max(-x, 0)^1.5", 1.5),
        ("if(x < 0, (-x)^1.5, 0)", 1.5),
        ("max(-x, 0)*sqrt(max(-x, 0))", 1.5),
        ("max(-x, 0)^1.25", 1.25),
        ("max(-x, 0)^(10/9)", 10.0 / 9.0),
        ("max(-x, 0)^2.5", 2.5),
        ("max(-x, 0)^0.7", 0.7),
        ("0.5*sqrt(4*sqrt(max(-x, 0)))", 0.25),
    ];
    for (force, power) in forms {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-9.81 + 1e4*{force}\"\n[initial]\nx = 0.1\nv = 0\n"
        );
        let run = run::<f64>(&text, 10.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{force}");
        let (x, v) = (run.state[0], run.state[1]);
        let pressed = 1e4 * (-x).max(0.0).powf(power + 1.0) / (power + 1.0);
        let energy = 0.5 * v * v + 9.81 * x + pressed;
        assert!((energy - 0.981).abs() < 1e-12, "{force}: {energy}");
        let times = switches(&run);
        assert!(times.len() > 40, "{force}: {}", times.len());
        let flight = 2.0 * (0.2 / 9.81_f64).sqrt();
        for pair in times[1..].chunks_exact(2) {
            assert!(
                (pair[1] - pair[0] - flight).abs() < 1e-12,
                "{force}: {pair:?}"
            );
        }
    }
}

/// x'' = -sign(x) sqrt|x| from x = A crosses zero after a quarter of 4 sqrt(3/4) A^(1/4) (2/3) B(2/3, 1/2), and each half of it later.
#[test]
fn an_oscillator_that_a_root_drives_crosses_zero_on_time() {
    for amplitude in [1.0, 0.3, 7.0_f64] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-sign(x)*sqrt(abs(x))\"\n[initial]\nx = {amplitude}\nv = 0\n"
        );
        let beta = libm::tgamma(2.0 / 3.0) * PI.sqrt() / libm::tgamma(7.0 / 6.0);
        let period = 4.0 * 0.75_f64.sqrt() * amplitude.powf(0.25) * beta * 2.0 / 3.0;
        let run = run::<f64>(&text, 10.0 * period);
        let times = switches(&run);
        assert_eq!(times.len(), 20);
        for (n, time) in times.iter().enumerate() {
            let expected = period * (0.25 + 0.5 * n as f64);
            assert!(
                (time - expected).abs() < 1e-12 * expected,
                "{time} {expected}"
            );
        }
    }
}

/// Twice the digits say the same of a forced oscillator with a Hertzian stop, and of a pressure that is let out by its root.
#[test]
fn doubles_agree_with_twice_their_digits() {
    let stop = "[flight]\nx = \"v\"\nv = \"0.5*cos(1.3*t) - 0.2*v - x - 5*max(x - 0.3, 0)^1.5\"\n[initial]\nx = 0.1\nv = 0\n";
    let orifice = "[flight]\np = \"0.3*cos(t) - sign(p)*sqrt(abs(p))\"\n[initial]\np = 0.2\n";
    // Jankowski's law of pounding.
    let pounding = "[flight]\nx = \"v\"\nv = \"2*sin(2*t) - x - 50*max(x - 0.5, 0)^1.5 - 0.6*sqrt(2*sqrt(max(x - 0.5, 0)))*v\"\n\
        [initial]\nx = 0\nv = 0\n";
    for text in [stop, orifice, pounding] {
        let (short, long) = (run::<f64>(text, 60.0), run::<DoubleDouble>(text, 60.0));
        assert_eq!(short.outcome, Outcome::Horizon);
        assert_eq!(long.outcome, Outcome::Horizon);
        assert!(switches(&short).len() > 10);
        assert_eq!(switches(&short).len(), switches(&long).len());
        for (a, b) in switches(&short).iter().zip(switches(&long)) {
            assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
        }
        for (a, b) in short.state.iter().zip(&long.state) {
            assert!((a - b.to_f64()).abs() < 1e-12, "{a} {b:?}");
        }
    }
}

/// Where the argument of a root goes on below zero there is no motion, as before.
#[test]
fn what_becomes_negative_has_no_root() {
    let run = run::<f64>("[flight]\nx = \"-1 - sqrt(x)\"\n[initial]\nx = 1\n", 10.0);
    assert_eq!(run.outcome.name(), "singular", "{:?}", run.outcome);
}

/// A root of time itself begins while a contact is closed, or friction sticks: both hold until the force is as large as what holds.
#[test]
fn a_root_of_time_begins_where_something_is_held() {
    let text = r#"
        [flight]
        y = "v"
        v = "-1 + 2*sqrt(max(t - 1.1, 0))"
        [[contact]]
        name = "seat"
        gap = "y"
        impulse = { v = 1 }
        restitution = 0.5
        [initial]
        y = 0
        v = 0
    "#;
    for start in [0.0, 1.1] {
        let text = format!("{text}\nt = {start}\n");
        let pressed = run::<f64>(&text, 2.0);
        assert_eq!(pressed.outcome, Outcome::Horizon, "{start}");
        let released = (pressed.events.iter())
            .find(|event| matches!(event.detail, Occurrence::Release { .. }))
            .expect("it opens");
        assert!((released.time - 1.35).abs() < 1e-12, "{}", released.time);
        let since = 2.0_f64 - 1.1;
        let rate = 0.25 - since + 4.0 / 3.0 * (since.powf(1.5) - 0.125);
        assert!((pressed.state[1] - rate).abs() < 1e-12, "{rate}");
    }
    for (force, leaves) in [
        ("2*sqrt(max(t - 1, 0))", Some(1.25)),
        ("0.6*sqrt(abs(t - 1))", None),
        ("2*max(t - 1, 0)^0.4", Some(1.0 + 0.5_f64.powf(2.5))),
        ("-0.5*sqrt(abs(t - 1.1))", None),
    ] {
        let text = format!("[flight]\nv = \"{force} - sign(v)\"\n[initial]\nv = 0\n");
        let stuck = run::<f64>(&text, 3.0);
        assert_eq!(stuck.outcome, Outcome::Horizon, "{force}");
        let left: Vec<f64> = (stuck.events.iter())
            .filter(|event| matches!(event.detail, Occurrence::Leave { .. }))
            .map(|event| event.time)
            .collect();
        assert_eq!(
            left.len(),
            usize::from(leaves.is_some()),
            "{force}: {left:?}"
        );
        for (found, expected) in left.iter().zip(leaves) {
            assert!((found - expected).abs() < 1e-12, "{force}: {found}");
        }
        if leaves.is_none() {
            assert_eq!(stuck.state[0], 0.0, "{force}");
        }
    }
}

/// Laws of impact that do not pull: what is cut off begins as a root of the depth itself, so that no derivative says its sign.
#[test]
fn forces_with_roots_may_be_cut_off_at_zero() {
    let motion = |force: &str| {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-x - 0.05*v + cos(1.7*t) - {force}\"\n[initial]\nx = 0\nv = 0\n"
        );
        run::<f64>(&text, 20.0)
    };
    let d = "max(x - 0.3, 0)";
    for (cut, plain) in [
        // Kuwabara and Kono's, Hunt and Crossley's.
        (
            format!("max(5e4*{d}^1.5 + 30*sqrt({d})*v, 0)"),
            "if(x > 0.3 and 5e4*(x - 0.3) + 30*v > 0, 5e4*(x - 0.3)^1.5 + 30*sqrt(x - 0.3)*v, 0)",
        ),
        (
            format!("max(5e3*{d}^1.5*(1 + 4*v), 0)"),
            "if(x > 0.3 and 1 + 4*v > 0, 5e3*(x - 0.3)^1.5*(1 + 4*v), 0)",
        ),
    ] {
        let (cut, plain) = (motion(&cut), motion(plain));
        assert_eq!(cut.outcome, Outcome::Horizon);
        assert!(switches(&cut).len() > 5);
        for (x, expected) in cut.state.iter().zip(&plain.state) {
            assert!((x - expected).abs() < 1e-12, "{x} {expected}");
        }
    }
}

/// Where both the depth and the force vanish at separation, steps that have shrunk towards it grow again after it.
#[test]
fn a_force_that_is_cut_off_lets_go() {
    fn leaves<R: Real>(law: &str, expected: f64) {
        let text = format!("[flight]\nx = \"v\"\nv = \"-{law}\"\n[initial]\nx = -0.001\nv = 1\n");
        let run = run::<R>(&text, 6.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{law}");
        assert!(
            (run.state[1].to_f64() - expected).abs() < 1e-12,
            "{law}: {:?}",
            run.state[1]
        );
    }
    // v dv/dx = -k x^p (1 + 0.3 v): v/0.3 - ln(1 + 0.3 v)/0.09 is the same before and after.
    let rate = -0.832_869_792_265_6;
    let law = |v: f64| v / 0.3 - (0.3 * v).ln_1p() / 0.09;
    assert!((law(1.0) - law(rate)).abs() < 1e-12);
    for depth in ["max(x, 0)^1.5", "1e6*max(x, 0)^1.5", "max(x, 0)^1.4"] {
        leaves::<f64>(&format!("max({depth}*(1 + 0.3*v), 0)"), rate);
        leaves::<DoubleDouble>(&format!("max({depth}*(1 + 0.3*v), 0)"), rate);
    }
}

/// The depth is a sum that moves: a step may end a rounding error past the surface that it leads to.
#[test]
fn a_hertzian_contact_of_a_moving_base_is_left_in_thirty_digits() {
    let text = "[definitions]\nbase = \"1e-3*(sin(60*pi*t) + 0.3*sin(120*pi*t + 0.7)) + 0.02\"\n\
        speed = \"1e-3*60*pi*(cos(60*pi*t) + 0.6*cos(120*pi*t + 0.7))\"\n\
        [flight]\ny = \"v\"\nv = \"-9.81 + 2e7*max(base - y, 0)^1.5*(1 + 0.45*(speed - v))\"\n[initial]\ny = 0.05\nv = 0\n";
    let (short, long) = (run::<f64>(text, 0.6), run::<DoubleDouble>(text, 0.6));
    assert_eq!(long.outcome, Outcome::Horizon);
    assert!(switches(&long).len() > 8);
    assert_eq!(switches(&long).len(), switches(&short).len());
    // By a program of its own, in 34 digits.
    let left = 0.363_005_055_292_968_2;
    let off = |time: &f64| (time - left).abs() < 1e-15;
    assert!(switches(&long).iter().any(off), "{:?}", switches(&long));
}

/// Along x = v = 0 the force is nothing: nothing else moves from there.
#[test]
fn what_touches_at_rest_stays_where_it_is() {
    for force in [
        "max(x, 0)^1.5",
        "max(x, 0)^1.4",
        "sign(x)*abs(x)^1.5",
        "if(x >= 0, x*sqrt(x), x)",
    ] {
        let text = format!("[flight]\nx = \"v\"\nv = \"-{force}\"\n[initial]\nx = 0\nv = 0\n");
        let rests = run::<f64>(&text, 6.0);
        assert_eq!(rests.outcome, Outcome::Horizon, "{force}");
        assert!(rests.events.len() <= 2, "{force}: {:?}", rests.events);
        assert_eq!(rests.state, [0.0, 0.0], "{force}");
    }
    // Where another motion may begin none is chosen.
    let text = "[flight]\nx = \"sign(x)*sqrt(abs(x))\"\n[initial]\nx = 0\n";
    let model = Model::from_toml(text, "model.toml").unwrap();
    let mut on = |_: &_| ControlFlow::Continue(());
    let refused = simulate::<f64>(&model, &Spec::until(6.0), &mut on);
    assert!(
        matches!(
            refused,
            Err(SimulateError::Start(FlowError::Singular { .. }))
        ),
        "{refused:?}"
    );
}

/// Newton's cradle: a ball hits two that touch, wherever they are and however fast the frame.
#[test]
fn a_ball_hits_balls_that_touch() {
    let force = |exponent: &str, a: u8, b: u8| format!("max(x{a} - x{b}, 0)^{exponent}");
    for (exponent, reaches) in [("1.5", Some(2.574_647_869_4)), ("1.3", None)] {
        let mut found: Option<f64> = None;
        for (place, speed) in [(0.0, 0.0), (0.3, 0.0), (0.3, 0.7), (-2.1, 0.01)] {
            let (one, two) = (force(exponent, 1, 2), force(exponent, 2, 3));
            let text = format!(
                "[flight]\nx1 = \"v1\"\nv1 = \"-{one}\"\nx2 = \"v2\"\nv2 = \"{one} - {two}\"\nx3 = \"v3\"\nv3 = \"{two}\"\n\
                 [initial]\nx1 = {}\nv1 = {}\nx2 = {place}\nv2 = {speed}\nx3 = {place}\nv3 = {speed}\n",
                place - 1.0,
                1.0 + speed
            );
            let run = run::<f64>(&text, 6.0);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            assert_eq!(switches(&run).len(), 4, "{text}: {:?}", run.events);
            let moved = run.state[4] - place - 6.0 * speed;
            let rates = [1, 3, 5].map(|k| run.state[k] - speed);
            let momentum: f64 = rates.iter().sum();
            let energy: f64 = rates.iter().map(|v| 0.5 * v * v).sum();
            assert!((momentum - 1.0).abs() < 1e-12, "{momentum}");
            assert!((energy - 0.5).abs() < 1e-12, "{energy}");
            if let Some(reaches) = reaches {
                assert!((moved - reaches).abs() < 1e-10, "{moved}");
            }
            let before = *found.get_or_insert(moved);
            assert!((moved - before).abs() < 1e-12, "{moved} {before}");
        }
    }
}

/// Two contacts that begin at one instant are each as if alone.
#[test]
fn two_contacts_begin_at_one_instant() {
    fn alike<R: Real>(until: f64) {
        let foot = |n: &str, y: &str| format!("1000*max({y}, 0)^{n}");
        for n in ["1.5", "1.4"] {
            let (left, right) = (foot(n, "-y - 0.3*th"), foot(n, "-y + 0.3*th"));
            let table = format!(
                "[flight]\ny = \"v\"\nv = \"-9.81 + {left} + {right}\"\nth = \"om\"\nom = \"0.9*({left} - {right})\"\n\
                 [initial]\ny = 0.1\nv = 0\nth = 0\nom = 0\n"
            );
            let ball = format!(
                "[flight]\ny = \"v\"\nv = \"-9.81 + 2*{}\"\n[initial]\ny = 0.1\nv = 0\n",
                foot(n, "-y")
            );
            let (table, ball) = (run::<R>(&table, until), run::<R>(&ball, until));
            assert_eq!(table.outcome, Outcome::Horizon, "{n}");
            for k in 0..2 {
                let off = (table.state[k] - ball.state[k]).to_f64();
                assert!(off.abs() < 1e-10, "{n}: {off}");
            }
        }
        let walls = "[flight]\nx = \"u\"\nu = \"max(-x, 0)^1.5\"\ny = \"v\"\nv = \"max(-y, 0)^1.5\"\n\
            [initial]\nx = 0.3\nu = -0.9\ny = 0.1\nv = -0.3\n";
        let thrown = run::<R>(walls, 6.0);
        assert_eq!(thrown.outcome, Outcome::Horizon);
        for (k, rate) in [(1, 0.9), (3, 0.3)] {
            let off = thrown.state[k].to_f64() - rate;
            assert!(off.abs() < 1e-14, "{off}");
        }
    }
    alike::<f64>(1.0);
    alike::<DoubleDouble>(1.0);
}

/// Springs with a power on both sides: where they are at rest another has yet to move them, in thirty digits, too.
#[test]
fn springs_at_rest_wait_for_others() {
    fn chain<R: Real>(exponent: &str) -> Vec<R> {
        let spring = |a: u8, b: u8| format!("sign(x{a} - x{b})*abs(x{a} - x{b})^{exponent}");
        let (one, two) = (spring(1, 2), spring(2, 3));
        let text = format!(
            "[flight]\nx1 = \"v1\"\nv1 = \"-{one}\"\nx2 = \"v2\"\nv2 = \"{one} - {two}\"\nx3 = \"v3\"\nv3 = \"{two}\"\n\
             [initial]\nx1 = 0\nv1 = 1\nx2 = 0\nv2 = 0\nx3 = 0\nv3 = 0\n"
        );
        let run = run::<R>(&text, 4.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{exponent}");
        run.state
    }
    for exponent in ["1.5", "1.4"] {
        let (short, long) = (chain::<f64>(exponent), chain::<DoubleDouble>(exponent));
        for (a, b) in short.iter().zip(&long) {
            assert!((a - b.to_f64()).abs() < 1e-12, "{exponent}: {a} {b:?}");
        }
    }
}

/// p' = -a t - K sign(p) sqrt|p|, from wherever it begins, is zero at t = 0 for K^2 >= 8 a, and -(c t)^2 after it, 2 c^2 + K c = a: flow
/// through an orifice that turns round in a stiff chamber.
fn turned(a: f64, stiffness: f64) -> f64 {
    let c = 2.0 * a / (stiffness + (stiffness * stiffness + 8.0 * a).sqrt());
    -(c * c)
}

#[test]
fn flow_through_an_orifice_turns_round_in_a_stiff_chamber() {
    fn through<R: Real>(tolerance: f64) {
        for (a, stiffness) in [(10.0, 9.0), (10.0, 10.0), (100.0, 100.0), (1.0, 60.0)] {
            for (from, begins) in [(-1.0, 1.0), (-0.3, 0.004), (0.0, 0.0)] {
                let text = format!(
                    "[flight]\np = \"-{a}*(t - 2) - {stiffness}*sign(p)*sqrt(abs(p))\"\n[initial]\nt = {}\np = {begins}\n",
                    2.0 + from
                );
                let run = run::<R>(&text, 3.0);
                assert_eq!(run.outcome, Outcome::Horizon, "{text}");
                let times = switches(&run);
                assert_eq!(times.len(), usize::from(from < 0.0), "{times:?}");
                assert!(times.iter().all(|time| (time - 2.0).abs() < 1e-15));
                let off = run.state[0].to_f64() / turned(a, stiffness) - 1.0;
                assert!(off.abs() < tolerance, "{a} {stiffness} {from}: {off}");
            }
        }
    }
    through::<f64>(1e-13);
    through::<DoubleDouble>(1e-15);
}

/// The same of the difference of two pressures, in pascal and seconds, one of which follows a volume that the other does not see.
#[test]
fn flow_between_two_chambers_turns_round() {
    let text = "[flight]\np = \"1e7*(-3e5*t - 10*sign(p - q)*sqrt(abs(p - q)))\"\nq = \"4e5\"\n\
        [initial]\np = 5.2e6\nq = 5e6\nt = -0.1\n";
    let run = run::<f64>(text, 0.1);
    assert_eq!(run.outcome, Outcome::Horizon);
    // 1e7*(-3e5 t - 10 r) = 4e5 where r begins: the flow turns at t = -4e-2/3e5.
    let (turns, c) = (-0.04 / 3e5, turned(3e12, 1e8));
    let times = switches(&run);
    assert!((times[0] - turns).abs() < 1e-16, "{times:?}");
    let off = (run.state[0] - run.state[1]) / (c * (0.1 - turns).powi(2)) - 1.0;
    assert!(off.abs() < 1e-10, "{off}");
}

/// A chamber that is let out through an orifice is empty in a finite time, and stays so until something flows in.
#[test]
fn a_chamber_stays_empty_until_something_flows_in() {
    for size in [1.0_f64, 1e-6, 1e6] {
        let text = format!(
            "[flight]\np = \"{0}*max(t - 3, 0) - {1}*sign(p)*sqrt(abs(p))\"\n[initial]\np = {0}\n",
            size,
            size.sqrt()
        );
        let run = run::<f64>(&text, 2.5);
        assert_eq!((run.outcome, run.state[0]), (Outcome::Horizon, 0.0));
        let filled = super::run::<f64>(&text, 5.0);
        assert_eq!(filled.outcome, Outcome::Horizon);
        assert!(
            (filled.state[0] / size - 1.0).abs() < 1e-13,
            "{:?}",
            filled.state
        );
    }
}

/// Columns of derivatives where flow turns round: what was before is forgotten, what moves the turn is not.
#[test]
fn columns_follow_a_flow_that_turns_round() {
    let text = "[parameters]\na = 10\nK = 12\nt0 = 0.5\n[flight]\np = \"-a*(t - t0) - K*sign(p)*sqrt(abs(p))\"\n\
        [initial]\np = 1\n";
    let model = Model::from_toml(text, "model.toml").unwrap();
    let columns = [
        Column::State,
        Column::Parameter(0),
        Column::Parameter(1),
        Column::Parameter(2),
    ];
    let system = System::with_columns(&model, &columns).unwrap();
    let mut work = system.workspace::<f64>(&Settings::default());
    let parameters = model.parameter_values::<f64>(&[]);
    let mut start = vec![1.0, 0.0, 1.0, 0.0];
    start.extend([0.0; 6]);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &start).unwrap();
    while trajectory.time() < 1.5 {
        trajectory.advance(&system, &mut work, 1.5).unwrap();
    }
    let (a, k) = (10.0_f64, 12.0_f64);
    let root = (k * k + 8.0 * a).sqrt();
    let c = (root - k) / 4.0;
    // p = -(c (t - t0))^2 a second after the turn.
    let expected = [
        0.0,
        -2.0 * c / root,
        -2.0 * c * (k / root - 1.0) / 4.0,
        2.0 * c * c,
    ];
    assert_eq!(system.column(trajectory.state(), 0)[0], 0.0);
    for (index, expected) in expected.into_iter().enumerate() {
        let found = system.column(trajectory.state(), index)[0];
        assert!(
            (found - expected).abs() < 1e-9,
            "{index}: {found} {expected}"
        );
    }
}

/// Torricelli's law as it is written: a factor within the root changes nothing of where that ends. The vessel is empty after
/// 2 sqrt(h)/k, and stays so.
#[test]
fn a_factor_within_a_root_does_not_hide_where_it_ends() {
    fn drains<R: Real>() {
        for (law, factor) in [
            ("sqrt(2*g*max(h, 0))", 19.62),
            ("sqrt(max(2*9.81*h, 0))", 19.62),
            ("sign(h)*sqrt(abs(3*h))", 3.0),
            ("sqrt(2/850*abs(h))*sign(h)", 2.0 / 850.0),
            ("sqrt(abs(h/850))*sign(h)", 1.0 / 850.0),
        ] {
            let k = 0.1 * f64::sqrt(factor);
            let text =
                format!("[parameters]\ng = 9.81\n[flight]\nh = \"-0.1*{law}\"\n[initial]\nh = 1\n");
            let half: Simulation<R> = run(&text, 1.0 / k);
            let off = half.state[0].to_f64() - 0.25;
            assert!(off.abs() < 1e-14, "{law}: {off}");
            let empty: Simulation<R> = run(&text, 10.0 / k);
            assert_eq!(empty.outcome, Outcome::Horizon, "{law}");
            assert_eq!(empty.state[0].to_f64(), 0.0, "{law}");
        }
        let filled: Simulation<R> = run(
            "[flight]\nh = \"sqrt(2*9.81*max(0.7 - h, 0))\"\n[initial]\nh = 0\n",
            9.0,
        );
        assert_eq!(filled.outcome, Outcome::Horizon);
        assert!((filled.state[0].to_f64() - 0.7).abs() < 1e-15);
    }
    drains::<f64>();
    drains::<DoubleDouble>();
}

/// Flow through a valve ends, or turns round, at a supply pressure that is a number like any other: as it does at zero.
#[test]
fn flow_turns_round_at_a_supply_pressure() {
    for (law, stays) in [
        ("max(P - p, 0)^0.5", None),
        ("sign(P - p)*sqrt(abs(P - p))", Some(0.0)),
    ] {
        for k in [10.0, 100.0, 1000.0] {
            let mut of_zero: Option<f64> = stays.map(|_: f64| f64::NAN);
            for supply in [0.0, 1.0, 0.7, 7.3] {
                let text = format!(
                    "[parameters]\nP = {supply:?}\n[flight]\np = \"{k:?}*({law} - cos(t))\"\n[initial]\np = \"P\"\n"
                );
                let end = run::<f64>(&text, 2.0);
                assert_eq!(end.outcome, Outcome::Horizon, "{law} {k} {supply}");
                let above = end.state[0] - supply;
                // Shut from the turn at pi/2 on.
                let expected = match &mut of_zero {
                    None => k * (1.0 - 2.0_f64.sin()),
                    Some(known) if known.is_nan() => {
                        *known = above;
                        above
                    }
                    Some(known) => *known,
                };
                assert!(
                    (above / expected - 1.0).abs() < 1e-11,
                    "{law} {k} {supply}: {above}"
                );
            }
        }
    }
}

/// Two vessels of any areas come to one level, at the time that the root of their difference takes, and keep it.
#[test]
fn two_vessels_come_to_one_level() {
    for (a, b) in [(0.5, 0.8), (0.3, 1.7), (1.0, 0.25), (0.6, 0.6)] {
        let flow = "sign(h1 - h2)*sqrt(abs(h1 - h2))";
        let text = format!(
            "[flight]\nh1 = \"-{a:?}*{flow}\"\nh2 = \"{b:?}*{flow}\"\n[initial]\nh1 = 5\nh2 = 1\n"
        );
        let level = (b * 5.0 + a) / (a + b);
        let end = run::<f64>(&text, 20.0);
        assert_eq!(end.outcome, Outcome::Horizon, "{a} {b}");
        for h in end.state {
            assert!((h - level).abs() < 1e-14, "{a} {b}: {h}");
        }
    }
}

/// A chamber that has come to supply pressure stays there, whether the valve between opens or closes, and however it does; in whatever
/// units. Until then sqrt(b) falls by K/2 times the integral of the opening.
#[test]
fn a_chamber_at_supply_pressure_stays_there_as_its_valve_closes() {
    fn stays<R: Real>() {
        for (opening, pressure, time) in [
            ("max(sin(w*t), 0)", 1.0_f64, 1.0),
            ("max(sin(w*t), 0)", 0.0, 0.37),
            ("max(sin(w*t), 0)", 7.3e5, 41.0),
            ("abs(sin(w*t))", 1.0, 1.0),
            ("abs(sin(w*t))", -3.7, 1e-3),
            ("(1 - cos(w*t))", 0.7, 60.0),
            ("max(sin(w*t), 0)^2", 2.3, 3.1),
        ] {
            let scale = if pressure == 0.0 {
                1.0_f64
            } else {
                pressure.abs()
            };
            let k = 3.0 * scale.sqrt() / time;
            let text = format!(
                "[parameters]\nK = {k:?}\nP = {pressure:?}\nw = {:?}\n[flight]\n\
                 p = \"K*{opening}*sign(P - p)*sqrt(abs(P - p))\"\n[initial]\np = {:?}\n",
                1.0 / time,
                pressure - 0.7 * scale
            );
            let end = run::<R>(&text, 40.0 * time);
            assert_eq!(end.outcome, Outcome::Horizon, "{opening} {pressure} {time}");
            assert_eq!(end.state[0].to_f64(), pressure, "{opening} {time}");
        }
    }
    stays::<f64>();
    stays::<DoubleDouble>();
}

/// A root of a sum of squares of which one is zero on one side of a corner is a root there, and what it adds has no corner of its own.
#[test]
fn a_root_of_squares_may_be_one_of_a_square_on_one_side() {
    let text = "[flight]\nx = \"v\"\nv = \"-hypot(max(t - 5, 0), x)\"\n[initial]\nx = -1\nv = 1\n";
    let run = run::<f64>(text, 4.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    // v' = x up to zero, where v is zero, too, but for rounding: from (-1, 1) along -e^-t.
    let falls = (-1.0_f64).exp();
    let early = super::run::<f64>(text, 1.0);
    assert!((early.state[0] + falls).abs() < 1e-14 && (early.state[1] - falls).abs() < 1e-14);
}
