//! Powers whose exponents are parameters, or no halves: with a whole one they are smooth where their base vanishes.

use super::run;
use chatter::analysis::simulate::{Outcome, Simulation};
use chatter::expressions::Side;
use chatter::flow::{EventKind, Occurrence};
use chatter::numerics::{DoubleDouble, Real};

/// The motion of a model with the parameter n, and that with the number in its place.
fn both<R: Real>(model: &str, exponent: u32, until: f64) -> [Simulation<R>; 2] {
    let with_parameter = format!("[parameters]\nn = {exponent}\n{model}");
    // With brackets, so that -n is no sign before a power.
    let literal = model.replace("^n", &format!("^({exponent})"));
    let literal = literal.replace("(n - 1)", &format!("({exponent} - 1)"));
    [with_parameter, literal].map(|text| run::<R>(&text, until))
}

#[test]
fn a_whole_exponent_may_be_a_parameter() {
    let one =
        |field: &str, start: f64| format!("[flight]\nz = \"{field}\"\n[initial]\nz = {start}\n");
    let wen = "[flight]\nx = \"v\"\nv = \"-0.1*v - z + 2*cos(1.6*t)\"\n\
        z = \"v - 0.5*abs(v)*z*abs(z)^(n - 1) - 0.5*v*abs(z)^n\"\n[initial]\nx = 0\nv = 0\nz = 0\n";
    let thrown = "[flight]\ny = \"v\"\nv = \"-9.81 - 0.1*sign(v)*abs(v)^n\"\n[[contact]]\ngap = \"y\"\n\
        impulse = { v = 1 }\nrestitution = 0.8\n[initial]\ny = 0\nv = 10\n";
    for model in [
        one("cos(t) - if(z > 0, z^n, z/2)", -0.5),
        one("1 + 2*sin(t) - z - 0.3*max(z - cos(t), 0)^n", 0.2),
        one("cos(t) - max(z, 0)^n", 0.0),
        one("1 - abs(z)^n - 0.5*abs(z)", -0.5),
        wen.to_owned(),
        thrown.to_owned(),
    ] {
        for exponent in 1..=3 {
            let [found, expected] = both::<f64>(&model, exponent, 5.0);
            assert_eq!(found.outcome, Outcome::Horizon, "{model} {exponent}");
            assert_eq!(found.events.len(), expected.events.len(), "{model}");
            assert_eq!(found.state, expected.state, "{model} {exponent}");
        }
        let [found, expected] = both::<DoubleDouble>(&model, 2, 2.0);
        assert_eq!(found.state, expected.state, "{model}");
    }
}

/// v' = -g - c v |v| from v on: up for atan(w)/sqrt(c g) with w = v sqrt(c/g), by h = log(1 + w^2)/(2 c); and down from there.
#[test]
fn a_ball_thrown_up_falls_as_drag_lets_it() {
    let (g, v): (f64, f64) = (9.81, 10.0);
    for c in [0.05, 0.1, 0.2] {
        let text = format!(
            "[parameters]\na = 2\n[flight]\ny = \"v\"\nv = \"-{g} - {c}*sign(v)*abs(v)^a\"\n[[contact]]\ngap = \"y\"\n\
             impulse = {{ v = 1 }}\nrestitution = 0.8\n[initial]\ny = 0\nv = {v}\n"
        );
        let run = run::<f64>(&text, 3.0);
        let root = (c * g).sqrt();
        let height = (c / g * v * v).ln_1p() / (2.0 * c);
        let fall = (c * height).exp().acosh() / root;
        let lands = (v * (c / g).sqrt()).atan() / root + fall;
        let is_impact = |time: f64| (time - lands).abs() < 1e-13;
        assert!(run.events.iter().any(|event| is_impact(event.time)), "{c}");
    }
}

/// With another power in use that is small, whose series reach no further than it is small.
#[test]
fn a_power_begins_where_another_has_just_begun() {
    let climb = |n: f64, d: f64| {
        format!(
            "[parameters]\nn = {n}\n[flight]\nx = \"1 + max(x, 0)^n + max(x - {d}, 0)^n\"\n[initial]\nx = -0.1\n"
        )
    };
    // By quadrature of dx/f.
    let reached = run::<f64>(&climb(1.4, 0.01), 0.5).state[0];
    assert!((reached - 0.511_588_870_037_513).abs() < 1e-14, "{reached}");
    for n in [0.5, 0.7, 1.4, 1.5] {
        for d in [0.01, 0.003] {
            let text = climb(n, d);
            let (short, long) = (run::<f64>(&text, 0.5), run::<DoubleDouble>(&text, 0.5));
            assert_eq!(short.outcome, Outcome::Horizon, "{text}");
            let off = short.state[0] - long.state[0].to_f64();
            assert!(off.abs() < 1e-13, "{text}: {off}");
        }
    }
}

/// A table on two Hertzian feet, dropped with a turn, keeps its energy.
#[test]
fn a_table_on_two_feet_keeps_its_energy() {
    for n in [1.25, 1.5, 1.75, 2.5] {
        for turn in [0.2, 0.5, 0.7] {
            let text = format!(
                "[parameters]\nk = 1000\na = 0.3\nn = {n}\n[definitions]\nleft = \"k*max(-y - a*th, 0)^n\"\n\
                 right = \"k*max(-y + a*th, 0)^n\"\n[flight]\ny = \"v\"\nv = \"-9.81 + left + right\"\nth = \"om\"\n\
                 om = \"3*a*(left - right)\"\n[initial]\ny = 0.1\nv = 0\nth = 0.01\nom = {turn}\n"
            );
            let run = run::<f64>(&text, 2.0);
            assert_eq!(run.outcome, Outcome::Horizon, "{n} {turn}");
            let [y, v, th, om] = run.state[..] else {
                panic!("four states")
            };
            let pressed = |foot: f64| 1000.0 * (-y - foot * th).max(0.0).powf(n + 1.0) / (n + 1.0);
            let energy = 0.5 * v * v + om * om / 6.0 + 9.81 * y + pressed(0.3) + pressed(-0.3);
            let given = 0.981 + turn * turn / 6.0;
            assert!((energy - given).abs() < 1e-12, "{n} {turn}: {energy}");
        }
    }
}

/// Stribeck's law with a root of the speed, however that is made a number: on the belt it is zero. Times and end from DOP853.
#[test]
fn a_body_sticks_where_friction_has_a_root_of_its_speed() {
    let forms = [
        ("abs(u/vs)^de", "sign(u)"),
        ("sqrt(abs(u)/vs)", "sign(u)"),
        ("sqrt(abs(5*u))", "sign(u)"),
        ("sqrt(abs(u/vs))", "sign(u/vs)"),
        ("sqrt(abs(0.3 - v)/0.2)", "sign(v - 0.3)"),
    ];
    for (power, sign) in forms {
        let text = format!(
            "[parameters]\nde = 0.5\nvs = 0.2\nV = 0.3\n[definitions]\nu = \"v - V\"\n[flight]\nx = \"v\"\n\
             v = \"-x - 0.05*v - (0.5 + 0.5*exp(-{power}))*{sign}\"\n[initial]\nx = 0\nv = 0\n"
        );
        let run = run::<f64>(&text, 12.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{power} {sign}");
        let leaves = (run.events.iter()).find(|e| e.detail.kind() == Some(EventKind::Leave));
        let leaves = leaves.map_or(f64::NAN, |event| event.time);
        assert!(
            (leaves - 3.505_644_713).abs() < 1e-12,
            "{power} {sign}: {leaves}"
        );
        let [x, v] = [run.state[0], run.state[1]];
        assert!(
            (x - 1.151_736_598_699).abs() < 1e-11 && (v + 0.067_953_180_402).abs() < 1e-11,
            "{power} {sign}: {x} {v}"
        );
    }
}

/// After each impact w^2 a ball against drag b sqrt(v) rises for 2 (w - log(1 + b w/g) g/b)/b, where the root of its rate vanishes, and
/// falls; beside a wall as before its first impact.
#[test]
fn a_ball_turns_between_impacts_where_the_root_of_its_rate_vanishes() {
    fn check<R: Real>(drag: &str, length: f64, time: f64) {
        let (rate, force) = (length / time, length / (time * time));
        let b = 0.15 * force / rate.sqrt();
        let drag = drag.replace('B', &format!("{b}"));
        let text = format!(
            "[flight]\nx = 'v'\nv = '-{force} - {drag}'\n[[contact]]\ngap = 'x'\nimpulse = {{ v = 1 }}\n\
             restitution = 0.6\n[initial]\nx = {length}\nv = 0\n"
        );
        let run = run::<R>(&text, 4.2 * time);
        let (mut tops, mut impact) = (0, None);
        for event in &run.events {
            match event.detail {
                Occurrence::Impact { rate_after, .. } => {
                    impact = Some((event.time.to_f64(), (rate_after.to_f64() / rate).sqrt()));
                }
                // That to the fall: the other is at the impact.
                Occurrence::Switch {
                    side: Side::Below, ..
                } => {
                    if let Some((begins, w)) = impact {
                        let rises = 2.0 * (w - (0.15 * w).ln_1p() / 0.15) / 0.15;
                        let off = (event.time.to_f64() - begins) / time - rises;
                        assert!(off.abs() < 1e-13, "{off:e}: {text}");
                        tops += 1;
                    }
                }
                _ => {}
            }
        }
        assert_eq!(tops, 3, "{text}");
        let lands = impact.map_or(f64::NAN, |(lands, _)| lands / time);
        assert!((lands - 3.806_741_009_5).abs() < 1e-9, "{lands}: {text}");
    }
    for drag in ["B*sign(v)*sqrt(abs(v))", "B*sign(v)*abs(v)^0.5"] {
        for (length, time) in [(1.0, 1.0), (1e3, 1e-2), (1e-3, 30.0)] {
            check::<f64>(drag, length, time);
        }
        check::<DoubleDouble>(drag, 1.0, 1.0);
    }
}
