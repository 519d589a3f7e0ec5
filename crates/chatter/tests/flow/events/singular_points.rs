//! Where equations stop being smooth: a step never reaches past such a point, however little of it the terms of its series
//! show, and a run ends there with its time.

use chatter::analysis::simulate::{Outcome, Progress, SimulateError, Simulation, Spec, simulate};
use chatter::expressions::Singularity;
use chatter::flow::FlowError;
use chatter::model::Model;
use chatter::numerics::Real;
use proptest::prelude::*;
use std::ops::ControlFlow;

fn model(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{text}: {errors:?}"))
}

/// A run, which has to be quick: the observer is asked every few steps.
fn run<R: Real>(model: &Model, spec: &Spec) -> Simulation<R> {
    const MOST_REPORTS: u32 = 20_000;
    let mut reports = 0;
    simulate(model, spec, &mut |_| {
        reports += 1;
        if reports > MOST_REPORTS {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .unwrap()
}

/// v' = `rate`, up to a time.
fn rate(rate: &str, initial: f64, until: f64) -> Simulation<f64> {
    let text = format!("[flight]\nv = \"{rate}\"\n[initial]\nv = {initial}\n");
    run(&model(&text), &Spec::until(until))
}

fn assert_singular(
    what: &str,
    simulation: &Simulation<f64>,
    kind: Singularity,
    at: f64,
    error: f64,
) {
    match simulation.outcome {
        Outcome::Failed(FlowError::Singular {
            time, kind: found, ..
        }) => {
            assert_eq!(found, kind, "{what}");
            assert!((time - at).abs() <= error, "{what}: {time} is not {at}");
        }
        ref other => panic!("{what}: {other:?} at {}", simulation.time),
    }
}

#[test]
fn the_expression_that_reaches_zero_is_named() {
    for (text, named) in [
        ("v/(2 - exp(t))", "2 - exp(t)"),
        ("log(1 - t^2)", "1 - t^2"),
        ("sqrt(cos(2*t))", "cos(2*t)"),
        ("tan(3*t)", "cos(3*t)"),
    ] {
        let Outcome::Failed(error) = rate(text, 1.0, 3.0).outcome else {
            panic!("{text}")
        };
        assert!(error.to_string().contains(&format!("({named}")), "{error}");
    }
}

#[test]
fn poles_and_corners_end_a_run_at_their_time() {
    use Singularity::{Division, InverseSine, Logarithm, Power, SquareRoot, Tangent};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    for (text, kind, at) in [
        ("tan(2*t)", Tangent, FRAC_PI_4),
        ("tan(t)^2", Tangent, FRAC_PI_2),
        ("tan(exp(t))", Tangent, FRAC_PI_2.ln()),
        ("1/cos(t)", Division, FRAC_PI_2),
        ("1/sin(t + 1)^2", Division, PI - 1.0),
        ("1/(1 - t)", Division, 1.0),
        ("3/(t - 2)^2", Division, 2.0),
        ("1e-20/(1 - t)", Division, 1.0),
        ("(1 - t)/(1 - t)", Division, 1.0),
        ("sin(1 - t)/(1 - t)", Division, 1.0),
        ("exp(-1/(1 - t)^2)", Division, 1.0),
        ("0*v/(1 - t)", Division, 1.0),
        ("log(1 - t)", Logarithm, 1.0),
        ("log((2 - t)^2)", Logarithm, 2.0),
        ("0*log(1.5 - t)", Logarithm, 1.5),
        ("asin(t)", InverseSine, 1.0),
        ("acos(t/2)", InverseSine, 2.0),
        ("sqrt(1 - t)", SquareRoot, 1.0),
        ("(1 - t)^1.5", SquareRoot, 1.0),
        ("((1 - t)^3)^(1/3)", Power, 1.0),
        ("(1 - t)^(-1/3)", Power, 1.0),
    ] {
        let simulation = rate(text, 1.0, 3.0);
        assert_singular(text, &simulation, kind, at, 1e-14 * at.abs());
    }
    // Where the argument itself is known to rounding only, its double zero is known to the root of that.
    for (text, at) in [
        ("sqrt(1 - 2*t + t^2)", 1.0),
        ("asin(sin(t))", FRAC_PI_2),
        ("acos(cos(t + 1))", PI - 1.0),
    ] {
        let simulation = rate(text, 1.0, 3.0);
        assert!(
            matches!(
                simulation.outcome,
                Outcome::Failed(FlowError::Singular { .. })
            ),
            "{text}"
        );
        assert!((simulation.time.to_f64() - at).abs() < 1e-7, "{text}");
    }
    // The state that reaches the pole takes a time that depends on it.
    assert_singular("-1/v", &rate("-1/v", 1.0, 3.0), Division, 0.5, 1e-14);
    assert_singular(
        "-1/v^2",
        &rate("-1/v^2", 1.0, 3.0),
        Division,
        1.0 / 3.0,
        1e-14,
    );
    assert_singular("start", &rate("1/(v - 1)^2", 1.0, 3.0), Division, 0.0, 0.0);
    // From where a root begins there is a motion.
    for (text, power) in [("sqrt(t)", 0.5), ("t^1.3", 1.3), ("t^(-1/3)", -1.0 / 3.0)] {
        let end = rate(text, 1.0, 3.0);
        assert_eq!(end.outcome, Outcome::Horizon, "{text}");
        let expected = 1.0 + 3.0_f64.powf(power + 1.0) / (power + 1.0);
        let off = (end.state[0] / expected - 1.0).abs();
        assert!(off < 1e-12, "{text}: {off:e}");
    }
}

/// Where the equations have no finite value no motion starts.
#[test]
fn what_is_not_a_number_is_said() {
    for text in ["sqrt(-1 - t)", "log(-1 - t)", "asin(2 + t)", "(-1 - t)^1.3"] {
        let model = model(&format!("[flight]\nv = \"{text}\"\n[initial]\nv = 1\n"));
        let mut on = |_: &Progress| ControlFlow::Continue(());
        let found = simulate::<f64>(&model, &Spec::until(3.0), &mut on);
        let failed = match &found {
            Err(error) => matches!(error, SimulateError::Start(_)),
            Ok(run) => matches!(run.outcome, Outcome::Failed(_)) && run.time == 0.0,
        };
        assert!(failed, "{text}: {found:?}");
    }
}

/// A whole exponent needs no base above zero, be it a parameter or too large to multiply out.
#[test]
fn whole_powers_are_smooth() {
    for n in ["2", "3", "7", "2000"] {
        let text = format!(
            "[parameters]\nn = {n}\n[flight]\nx = \"cos(t)\"\nv = \"x^n\"\n[initial]\nx = -0.3\nv = 0\n"
        );
        let simulation: Simulation<f64> = run(&model(&text), &Spec::until(7.0));
        assert_eq!(simulation.outcome, Outcome::Horizon, "{n}");
    }
}

/// x'' = -x - k (x + sqrt(x^2 + eps)) / 2, and what stays constant.
fn spring(k: f64, eps: f64, x: f64, v: f64) -> (Model, impl Fn(f64, f64) -> f64) {
    let text = format!(
        "[flight]\nx = \"v\"\nv = \"-x - {k:?}*(x + sqrt(x^2 + {eps:?}))/2\"\n[initial]\nx = {x:?}\nv = {v:?}\n"
    );
    let energy = move |x: f64, v: f64| {
        let root = (x * x + eps).sqrt();
        let bend = if eps > 0.0 {
            eps * (x / eps.sqrt()).asinh()
        } else {
            0.0
        };
        v * v / 2.0 + x * x / 2.0 + k / 4.0 * (x * x + x * root + bend)
    };
    (model(&text), energy)
}

#[test]
fn a_bilinear_spring_keeps_its_energy_however_sharp_its_corner() {
    for eps in [
        1e-60, 1e-30, 1e-25, 1e-20, 1e-15, 1e-10, 1e-7, 1e-4, 1e-2, 0.3, 1.0,
    ] {
        let (model, energy) = spring(3.0, eps, -2.0, 0.3);
        let simulation: Simulation<f64> = run(&model, &Spec::until(50.0));
        assert_eq!(simulation.outcome, Outcome::Horizon, "{eps}");
        let [x, v] = simulation.state[..] else {
            panic!()
        };
        let drift = energy(x, v) - energy(-2.0, 0.3);
        assert!(drift.abs() < 2e-13, "{eps}: {drift}");
    }
}

/// The root of a square changes by no more than what is squared: motion goes through its corner, both ways.
#[test]
fn motion_goes_through_the_corner_of_the_root_of_a_square() {
    let (model, energy) = spring(3.0, 0.0, -2.0, 0.3);
    let simulation: Simulation<f64> = run(&model, &Spec::until(50.0));
    assert_eq!(simulation.outcome, Outcome::Horizon);
    let drift = energy(simulation.state[0], simulation.state[1]) - energy(-2.0, 0.3);
    assert!(drift.abs() < 2e-13, "{drift}");
    // v' = |1 - t|, and |2 - t|^3.
    for (text, expected) in [("sqrt((1 - t)^2)", 3.5), ("((2 - t)^2)^1.5", 5.25)] {
        let end = rate(text, 1.0, 3.0);
        assert_eq!(end.outcome, Outcome::Horizon, "{text}");
        assert!((end.state[0] - expected).abs() < 1e-13, "{text}");
    }
}

/// What falls straight through air that resists by the speed has none at its top, and none where it is dropped.
#[test]
fn motion_goes_straight_through_where_a_length_vanishes() {
    let thrown = |drag: &str, side: &str| {
        let text = format!(
            "[flight]\nx = \"u\"\nu = \"-0.3*{drag}*u\"\ny = \"v\"\nv = \"-9.81 - 0.3*{drag}*v\"\n[[contact]]\ngap = \"y\"\n\
             impulse = {{ v = 1 }}\nrestitution = 0.5\n[initial]\nx = 0\nu = {side}\ny = 1\nv = 0\n"
        );
        let end: Simulation<f64> = run(&model(&text), &Spec::until(1.0));
        assert_eq!(end.outcome, Outcome::Horizon, "{drag}");
        (end.counts.impacts, end.state)
    };
    let (impacts, straight) = thrown("hypot(u, v)", "0");
    let (count, along) = thrown("abs(v)", "0");
    assert_eq!((impacts, count), (2, 2));
    for (x, y) in straight.iter().zip(&along) {
        assert!((x - y).abs() < 1e-14, "{x} {y}");
    }
    // Dropped from rest, a body is as low as log(cosh(t sqrt(g k)))/k.
    let fall = (9.81_f64 * 0.3).sqrt() * 0.3;
    let text = "[flight]\nu = \"-0.3*hypot(u, v)*u\"\ny = \"v\"\nv = \"-9.81 - 0.3*hypot(u, v)*v\"\n[initial]\nu = 0\ny = 1\nv = 0\n";
    let end: Simulation<f64> = run(&model(text), &Spec::until(0.3));
    let expected = 1.0 - fall.cosh().ln() / 0.3;
    assert!((end.state[1] - expected).abs() < 1e-14, "{:?}", end.state);
}

/// The end of a flight is known though the flight cannot be continued: an impact comes before what is singular at it.
#[test]
fn what_is_singular_on_a_surface_does_not_hide_the_impact() {
    for force in ["0.1*sqrt(y)", "0.01*log(y)", "0.1*sqrt(y*(2 - y))"] {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"-1 - {force}\"\n[[contact]]\ngap = \"y\"\nimpulse = {{ v = 1 }}\n\
             restitution = 0.5\n[initial]\ny = 1\nv = 0\n"
        );
        let simulation: Simulation<f64> = run(&model(&text), &Spec::until(5.0));
        assert_eq!(simulation.counts.impacts, 1, "{force}");
        let at = simulation.time;
        assert!(
            matches!(simulation.outcome, Outcome::Failed(FlowError::Singular { time, .. }) if time == at),
            "{force}"
        );
    }
}

/// A looser tolerance means less work, not more: rounding, not truncation, says whether a guard can be told from zero.
#[test]
fn a_loose_tolerance_is_quick() {
    for (name, text) in [
        (
            "ball",
            include_str!("../../../../../models/bouncing_ball.toml"),
        ),
        (
            "table",
            include_str!("../../../../../models/bouncing_ball_on_table.toml"),
        ),
        (
            "follower",
            include_str!("../../../../../models/cam_follower.toml"),
        ),
        (
            "oscillator",
            include_str!("../../../../../models/impact_oscillator.toml"),
        ),
        (
            "stops",
            include_str!("../../../../../models/impact_oscillator_two_sided.toml"),
        ),
        (
            "linear",
            include_str!("../../../../../models/linear_impacting_system.toml"),
        ),
        (
            "valve",
            include_str!("../../../../../models/pressure_relief_valve.toml"),
        ),
    ] {
        let model = model(text);
        let reports = |tolerance: f64| {
            let mut count = 0_u32;
            let spec = Spec {
                tolerance,
                ..Spec::until(20.0)
            };
            let simulation: Simulation<f64> = simulate(&model, &spec, &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            })
            .unwrap();
            assert_eq!(
                simulation.outcome,
                Outcome::Horizon,
                "{name} at {tolerance}"
            );
            count
        };
        let tight = reports(0.0);
        for tolerance in [1e-12, 1e-8, 1e-5, 1e-3, 1e-2, 0.5] {
            let loose = reports(tolerance);
            // Another path may have other impacts.
            assert!(
                2 * loose <= 3 * tight + 2,
                "{name} at {tolerance}: {loose} for {tight}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Whatever the spring and its corner, energy is kept; nothing is stepped over.
    #[test]
    fn energy_is_kept_at_any_corner(
        k in 0.1_f64..20.0,
        exponent in -40.0_f64..0.0,
        x in -3.0_f64..-0.1,
        v in -2.0_f64..2.0,
    ) {
        let (model, energy) = spring(k, 10_f64.powf(exponent), x, v);
        let simulation: Simulation<f64> = run(&model, &Spec::until(10.0));
        prop_assert_eq!(&simulation.outcome, &Outcome::Horizon);
        let start = energy(x, v);
        let drift = energy(simulation.state[0], simulation.state[1]) - start;
        prop_assert!(drift.abs() < 2e-13 * (1.0 + start.abs()), "{}", drift);
    }

    /// A pole is met at its time wherever it is, alone or beside other terms, of any strength.
    #[test]
    fn poles_are_met(at in 0.1_f64..2.9, strength in -25.0_f64..3.0, power in 1_i32..4) {
        let strength = 10_f64.powf(strength);
        let text = format!("cos(3*t) + {strength:?}/({at:?} - t)^{power}");
        let simulation = rate(&text, 0.0, 3.0);
        assert_singular(&text, &simulation, Singularity::Division, at, 1e-14);
    }
}

/// A sum of positive terms has no zero, however large one of them grows beside the other, and whatever else is computed to
/// how high an order.
#[test]
fn saturating_quotients_of_exponentials_are_followed() {
    for power in 0..=12 {
        let k = libm::exp10(f64::from(power) / 3.0);
        for section in ["", "[section.fast]\nsurface = \"v + 0.3\"\n"] {
            let run = |drag: &str| {
                let text = format!(
                    "[flight]\nx = \"v\"\nv = \"-0.5 - 0.2*({drag}) + 0.8*cos(1.3*t + 0.1)\"\n\
                     [[contact]]\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n{section}\
                     [initial]\nx = 0\nv = 0\n"
                );
                run::<f64>(&model(&text), &Spec::until(10.0))
            };
            let quotient = run(&format!("(1 - exp(-{k:?}*v))/(1 + exp(-{k:?}*v))"));
            let tanh = run(&format!("tanh({:?}*v)", 0.5 * k));
            // e^-kv has no finite value where the speed is too large.
            if quotient.outcome != Outcome::Horizon {
                assert!(
                    matches!(
                        quotient.outcome,
                        Outcome::Failed(FlowError::LeftDomain { .. })
                    ),
                    "{k} {:?}",
                    quotient.outcome
                );
                let speed = quotient.state[1].abs();
                assert!(k * speed > 600.0, "{k} {speed}");
                continue;
            }
            assert_eq!(tanh.outcome, Outcome::Horizon, "{k}");
            for (a, b) in quotient.state.iter().zip(&tanh.state) {
                assert!((a - b).abs() < 1e-8, "{k} {a} {b}");
            }
        }
    }
}

/// A body pulled into a pole, its velocity watched on the way: x'' = 1/(d - x)^2 arrives at d after d^1.5 pi/sqrt(8).
#[test]
fn a_section_does_not_delay_the_end_at_a_pole() {
    for d in [0.9, 0.7, 1.3] {
        for surface in ["v", "v + 1", "x - v"] {
            let text = format!(
                "[flight]\nx = \"v\"\nv = \"1/({d:?} - x)^2\"\n[section.s]\nsurface = \"{surface}\"\ndirection = \"falling\"\n\
                 [initial]\nx = 0\nv = 0\n"
            );
            let run = run::<f64>(&model(&text), &Spec::until(4.0));
            assert_eq!(run.outcome.name(), "singular", "{text}");
            let end = d * f64::sqrt(d) * std::f64::consts::PI / f64::sqrt(8.0);
            assert!((run.time - end).abs() < 1e-13, "{} {end}", run.time);
        }
    }
}
