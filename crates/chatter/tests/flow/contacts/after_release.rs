//! Release against forces that saturate: the contact is left by its jerk, and nothing that rounding makes of gap, rate or
//! acceleration in the moment after it is an impact.

use chatter::analysis::simulate::{Outcome, Spec, simulate};
use chatter::flow::{FlowError, Occurrence, Settings, System, Trajectory};
use chatter::model::{Model, ModelBuilder};
use chatter::numerics::{DoubleDouble, Real};
use proptest::prelude::*;
use std::ops::ControlFlow;

const UNTIL: f64 = 15.0;

/// Rates below this are rounding in forces of order one over times of order one.
const LEAST_RATE: f64 = 1e-12;

/// A mass on a floor, pressed onto it, shaken, and held back by a force of the velocity.
#[derive(Clone, Debug)]
struct Shaken {
    drag: String,
    press: f64,
    force: f64,
    frequency: f64,
    phase: f64,
    restitution: f64,
    /// Amplitude of the floor's own motion.
    floor: f64,
}

impl Shaken {
    fn model(&self) -> Model {
        let gap = if self.floor == 0.0 {
            "x".to_owned()
        } else {
            format!("x - {:?}*sin(0.9*t)", self.floor)
        };
        ModelBuilder::new()
            .parameter("r", self.restitution)
            .state("x", "v", 0.3)
            .state(
                "v",
                format!(
                    "-{:?} - ({}) + {:?}*cos({:?}*t + {:?})",
                    self.press, self.drag, self.force, self.frequency, self.phase
                ),
                0.0,
            )
            .contact("floor", gap, [("v", 1.0)], "r")
            .build()
            .expect("a valid model")
    }
}

/// What happened, and when; for an impact its incoming rate.
type Told = Vec<(&'static str, f64, f64)>;

/// Everything that happens until `until`. Just after each release the trajectory stops for a moment, `pauses` times in all,
/// each time so long after it.
fn events<R: Real>(model: &Model, pauses: &[f64]) -> Result<Told, FlowError> {
    let system = System::new(model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values::<R>(&[]);
    let state = model.initial_state(&parameters);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state)?;
    let until = R::splat(UNTIL);
    let mut told = Vec::new();
    let mut horizon = until;
    let mut released = R::ZERO;
    let mut waiting: Vec<f64> = Vec::new();
    loop {
        let Some(what) = trajectory.advance(&system, &mut work, horizon)? else {
            continue;
        };
        let time = trajectory.time().to_f64();
        match what {
            Occurrence::Impact { rate_before, .. } => {
                told.push(("impact", time, rate_before.to_f64()));
            }
            Occurrence::Accumulation { .. } => told.push(("accumulation", time, 0.0)),
            Occurrence::Capture { .. } => told.push(("capture", time, 0.0)),
            Occurrence::Graze { .. } => told.push(("graze", time, 0.0)),
            Occurrence::Release { .. } => {
                told.push(("release", time, 0.0));
                released = trajectory.time();
                waiting = pauses.to_vec();
                horizon = until;
            }
            Occurrence::Horizon if horizon >= until => return Ok(told),
            Occurrence::Horizon => horizon = until,
            _ => {}
        }
        if let (Occurrence::Release { .. } | Occurrence::Horizon, false) =
            (what, waiting.is_empty())
        {
            horizon = (released + R::splat(waiting.remove(0))).min(until);
        }
    }
}

/// Events but for the impacts of sequences that are completed, of which more or fewer are integrated, and for the slowest of others.
fn outline(told: &Told) -> Told {
    let (mut all, mut last) = (Told::new(), 0.0);
    for &(what, time, rate) in told {
        if what == "accumulation" {
            while all.last().is_some_and(|&(before, ..)| before == "impact") {
                all.pop();
            }
        }
        if what != "impact" || rate.abs() > 1e-3 && time > last {
            all.push((what, time, rate));
        }
        last = time;
    }
    all
}

fn drags() -> impl Strategy<Value = String> {
    (0_usize..6, 0.0_f64..1.0, 0.05_f64..0.5).prop_map(|(form, share, c)| {
        // At rates up to seven exp(k v) is a number.
        let k = 100.0_f64.powf(share);
        match form {
            0 => format!("{c:?}*tanh({k:?}*v)"),
            1 => format!("{c:?}*atan({k:?}*v)"),
            2 => format!("{c:?}*{k:?}*v/sqrt(1 + ({k:?}*v)^2)"),
            3 => format!("{c:?}*(1 - exp(-{k:?}*v))/(1 + exp(-{k:?}*v))"),
            4 => format!("{c:?}*v*exp(-({k:?}*v)^2)"),
            _ => format!("{c:?}*{k:?}*v/(1 + ({k:?}*v)^2)"),
        }
    })
}

fn shaken() -> impl Strategy<Value = Shaken> {
    (
        drags(),
        (0.3_f64..1.2, 0.1_f64..1.0, 0.4_f64..2.5, 0.0_f64..6.0),
        0.05_f64..0.85,
        prop_oneof![Just(0.0), 0.01_f64..0.3],
    )
        .prop_map(
            |(drag, (press, more, frequency, phase), restitution, floor)| Shaken {
                drag,
                press,
                force: press + more,
                frequency,
                phase,
                restitution,
                floor,
            },
        )
}

fn check(shaken: &Shaken) -> Result<usize, TestCaseError> {
    let model = shaken.model();
    let told = events::<f64>(&model, &[]);
    prop_assert!(told.is_ok(), "{:?}", told);
    let told = told.unwrap_or_default();
    for &(what, time, rate) in &told {
        prop_assert!(
            what != "impact" || rate < -LEAST_RATE,
            "a rate of {:e} at {}",
            rate,
            time
        );
        prop_assert!(what != "graze", "a graze at {}", time);
    }
    let releases = told.iter().filter(|event| event.0 == "release").count();
    let longer = outline(&events::<DoubleDouble>(&model, &[]).expect("a finite field"));
    let paused = events::<f64>(&model, &[0.0, 1e-17, 1e-14, 1e-11, 3e-9, 2e-7, 1e-5, 1e-3]);
    let paused = outline(&paused.expect("a finite field"));
    let own = outline(&told);
    let mut error = 1e-12;
    for (place, (a, b)) in own.iter().zip(&longer).enumerate() {
        // Errors grow along chaotic orbits, and a weak impact is one only just.
        if error > 1e-6 {
            break;
        }
        prop_assert_eq!(a.0, b.0, "event {} at {} {}", place, a.1, b.1);
        error = f64::max(error, 30.0 * (a.1 - b.1).abs());
        prop_assert!(
            (a.1 - b.1).abs() < 1e-6,
            "event {} at {} {}",
            place,
            a.1,
            b.1
        );
        let c = paused.get(place).copied().unwrap_or(("nothing", 0.0, 0.0));
        prop_assert_eq!(a.0, c.0, "event {} at {} {} with pauses", place, a.1, c.1);
    }
    Ok(releases)
}

#[test]
fn a_saturating_force_leaves_no_phantom_impacts() {
    let shaken = Shaken {
        drag: "0.2*tanh(20*v)".to_owned(),
        press: 0.5,
        force: 0.8,
        frequency: 1.3,
        phase: 0.1,
        restitution: 0.7,
        floor: 0.0,
    };
    assert!(check(&shaken).unwrap() > 1);
}

#[test]
fn what_follows_a_release_is_the_same_in_longer_numbers_and_after_a_pause() {
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(32));
    let releases = core::cell::Cell::new(0);
    let outcome = runner.run(&shaken(), |shaken| {
        releases.set(releases.get() + check(&shaken)?);
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    assert!(releases.get() > 30, "{}", releases.get());
}

/// A contact leaves at a kink of its gap, and what pressed another begins to pull at the same instant: both open.
#[test]
fn what_begins_to_pull_as_another_leaves_is_let_go() {
    let kinked = "[[contact]]\nname = \"kinked\"\ngap = \"y + 0.2*abs(t - 1)\"\nimpulse = { u = 1 }\nrestitution = 0.2\n";
    let pressed =
        "[[contact]]\nname = \"pressed\"\ngap = \"x\"\nimpulse = { v = 1 }\nrestitution = 0.5\n";
    for contacts in [[kinked, pressed], [pressed, kinked]] {
        for force in ["if(t < 1, 0, 1.3)", "1.3*step(t - 1)"] {
            let text = format!(
                "[flight]\nx = \"v\"\nv = \"-0.5 + {force}\"\ny = \"u\"\nu = \"-1\"\n{}{}\
                 [initial]\nx = 0\nv = 0\ny = -0.2\nu = 0.2\n",
                contacts[0], contacts[1]
            );
            let model = Model::from_toml(&text, "test").unwrap();
            let run = simulate::<f64>(
                &model,
                &Spec::until(1.9),
                &mut |_| ControlFlow::Continue(()),
            )
            .unwrap();
            assert_eq!(run.outcome, Outcome::Horizon);
            assert_eq!(run.counts.releases, 2, "{:?}", run.events);
            assert!(
                (run.state[0] - 0.4 * 0.81).abs() < 1e-14,
                "{}",
                run.state[0]
            );
            assert!((run.state[1] - 0.72).abs() < 1e-14, "{}", run.state[1]);
        }
    }
}
