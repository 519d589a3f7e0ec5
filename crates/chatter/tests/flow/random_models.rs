//! Random oscillators between walls against an independent integrator: classical Runge–Kutta in ten thousands of steps
//! a unit of time, impacts by brute sampling and bisection. Same impacts, same times, and never a step into the wall.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::ModelBuilder;
use core::cell::Cell;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

#[derive(Clone, Debug)]
struct Oscillator {
    stiffness: f64,
    damping: f64,
    cubic: f64,
    force: f64,
    frequency: f64,
    right: f64,
    left: f64,
    restitution: f64,
    start: (f64, f64),
}

impl Oscillator {
    fn acceleration(&self, t: f64, x: f64, v: f64) -> f64 {
        -self.stiffness * x - self.damping * v - self.cubic * x * x * x
            + self.force * (self.frequency * t).cos()
    }

    fn runge_kutta(&self, t: f64, (x, v): (f64, f64), h: f64) -> (f64, f64) {
        let f = |t: f64, x: f64, v: f64| (v, self.acceleration(t, x, v));
        let (a1, b1) = f(t, x, v);
        let (a2, b2) = f(t + h / 2.0, x + h / 2.0 * a1, v + h / 2.0 * b1);
        let (a3, b3) = f(t + h / 2.0, x + h / 2.0 * a2, v + h / 2.0 * b2);
        let (a4, b4) = f(t + h, x + h * a3, v + h * b3);
        (
            x + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
            v + h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4),
        )
    }

    fn gaps(&self, x: f64) -> [f64; 2] {
        [self.right - x, x + self.left]
    }

    /// Contact, time and incoming rate of the first impacts, until one is too weak or a flight passes a wall too
    /// closely for a sampled reference to be sure.
    fn reference(&self, until: f64, most: usize) -> Vec<(usize, f64, f64)> {
        const STEP: f64 = 1e-4;
        const CLOSE: f64 = 1e-6;
        const WEAK: f64 = 1e-2;
        let mut impacts = Vec::new();
        let (mut t, mut point) = (0.0, self.start);
        let mut since = 1.0;
        while t < until && impacts.len() < most {
            let next = self.runge_kutta(t, point, STEP);
            let hit = (0..2).find(|&c| self.gaps(next.0)[c] < 0.0);
            let Some(contact) = hit else {
                let turned = point.1 * next.1 < 0.0;
                let nearest = self.gaps(next.0).into_iter().fold(f64::INFINITY, f64::min);
                if turned && nearest < CLOSE && since > 10.0 * STEP {
                    return impacts;
                }
                (t, point) = (t + STEP, next);
                since += STEP;
                continue;
            };
            let (mut low, mut high) = (0.0, STEP);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let (x, _) = self.runge_kutta(t, point, middle);
                if self.gaps(x)[contact] < 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let (x, v) = self.runge_kutta(t, point, low);
            let rate = if contact == 0 { -v } else { v };
            if rate.abs() < WEAK {
                return impacts;
            }
            t += low;
            impacts.push((contact, t, rate));
            point = (x, -self.restitution * v);
            since = 0.0;
        }
        impacts
    }

    /// The same impacts by the library, with the least gap seen in dense samples of every step.
    fn simulate(&self, until: f64, most: usize) -> (Vec<(usize, f64, f64)>, f64) {
        let model = ModelBuilder::new()
            .parameter("r", self.restitution)
            .state("x", "v", self.start.0)
            .state(
                "v",
                format!(
                    "-({:?})*x - ({:?})*v - ({:?})*x^3 + ({:?})*cos({:?}*t)",
                    self.stiffness, self.damping, self.cubic, self.force, self.frequency
                ),
                self.start.1,
            )
            .contact("right", format!("{:?} - x", self.right), [("v", -1.0)], "r")
            .contact("left", format!("x + {:?}", self.left), [("v", 1.0)], "r")
            .build()
            .expect("a valid model");
        let system = System::new(&model).expect("a valid system");
        let mut work = system.workspace::<f64>(&Settings::default());
        let parameters = model.parameter_values::<f64>(&[]);
        let state = model.initial_state(&parameters);
        let mut trajectory =
            Trajectory::start(&system, &mut work, &parameters, 0.0, &state).expect("a legal start");
        let mut impacts = Vec::new();
        let mut least = f64::INFINITY;
        while impacts.len() < most {
            let told = trajectory
                .advance(&system, &mut work, until)
                .expect("a finite field");
            if work.dense().step() > 0.0 {
                for k in 0..=32 {
                    let x = work.dense().state(0, f64::from(k) / 32.0);
                    least = self.gaps(x).into_iter().fold(least, f64::min);
                }
            }
            match told {
                Some(Occurrence::Impact {
                    contact,
                    rate_before,
                    ..
                }) => impacts.push((contact, trajectory.time(), rate_before)),
                Some(Occurrence::Horizon) => break,
                _ => {}
            }
        }
        (impacts, least)
    }
}

fn oscillators() -> impl Strategy<Value = Oscillator> {
    (
        (0.2_f64..9.0, 0.0_f64..0.6, 0.0_f64..3.0),
        (0.0_f64..6.0, 0.5_f64..5.0),
        (0.05_f64..1.0, 0.05_f64..1.0, 0.2_f64..0.95),
        (-0.9_f64..0.9, -3.0_f64..3.0),
    )
        .prop_map(
            |(
                (stiffness, damping, cubic),
                (force, frequency),
                (right, left, restitution),
                (x, v),
            )| Oscillator {
                stiffness,
                damping,
                cubic,
                force,
                frequency,
                right,
                left,
                restitution,
                start: (if x > 0.0 { x * right } else { x * left }, v),
            },
        )
}

/// Of so many models; the reference must have told of so many impacts in all, and of some in so many models.
const MODELS: u32 = 64;
const LEAST_IMPACTS: usize = 128;
const LEAST_MODELS: usize = 40;

#[test]
fn same_impacts_as_brute_sampling() {
    let compared = Cell::new((0, 0));
    let mut runner = TestRunner::new(ProptestConfig::with_cases(MODELS));
    let outcome = runner.run(&oscillators(), |oscillator| {
        let expected = oscillator.reference(6.0, 8);
        let (found, least) = oscillator.simulate(6.0, expected.len().max(1));
        prop_assert!(least > -1e-12, "a gap of {:e}", least);
        for (place, (want, have)) in expected.iter().zip(&found).enumerate() {
            prop_assert_eq!(want.0, have.0, "contact of impact {}", place);
            prop_assert!(
                (want.1 - have.1).abs() < 1e-8,
                "time of impact {}: {} {}",
                place,
                want.1,
                have.1
            );
            prop_assert!(
                (want.2 - have.2).abs() < 1e-6,
                "rate at impact {}: {} {}",
                place,
                want.2,
                have.2
            );
        }
        prop_assert!(found.len() >= expected.len());
        let (impacts, models) = compared.get();
        compared.set((
            impacts + expected.len(),
            models + usize::from(!expected.is_empty()),
        ));
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    let (impacts, models) = compared.get();
    assert!(
        impacts >= LEAST_IMPACTS && models >= LEAST_MODELS,
        "{impacts} in {models}"
    );
}

/// A long run on the vibrating table: complete chatter, sticking and release over and over.
#[test]
fn a_million_bounces_on_a_vibrating_table_without_penetration() {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../models/bouncing_ball_on_table.toml"
    ))
    .expect("a shipped model");
    let mut model = chatter::model::Model::from_toml(&text, "bouncing_ball_on_table.toml")
        .expect("a valid model");
    model.set_parameter("r", "0.5").expect("a known parameter");
    let system = System::new(&model).expect("a valid system");
    let mut work = system.workspace::<f64>(&Settings::default());
    let parameters = model.parameter_values::<f64>(&[]);
    let state = model.initial_state(&parameters);
    let gap = model.contacts[0].gap;
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, 0.0, &state).expect("a legal start");
    let (mut impacts, mut steps, mut accumulations) = (0_u32, 0_u64, 0_u32);
    while impacts < 1_000_000 {
        steps += 1;
        assert!(steps < 40_000_000, "stalled at {}", trajectory.time());
        match trajectory
            .advance(&system, &mut work, 1e12)
            .expect("a finite field")
        {
            Some(Occurrence::Impact {
                rate_before,
                rate_after,
                ..
            }) => {
                assert!(
                    rate_before < 0.0 && rate_after >= 0.0,
                    "rates {rate_before:e}, {rate_after:e} after {impacts} impacts at {} {:?}",
                    trajectory.time(),
                    trajectory.state()
                );
                impacts += 1;
            }
            Some(Occurrence::Accumulation { .. }) => accumulations += 1,
            _ => {}
        }
        // A sample of the states: the gap expression is slow to evaluate.
        if steps % 97 == 0 {
            let here = model.graph.evaluate(gap, trajectory.state(), &parameters);
            // The table moves at up to 0.32 m/s, and evaluation at a rounded time sees it that much elsewhere.
            let seen = 1e-12 + 0.32 * f64::EPSILON * trajectory.time();
            assert!(here > -seen, "a gap of {here:e} at {}", trajectory.time());
        }
    }
    assert!(accumulations > 1000, "{accumulations}");
}
