//! Short runs of models that chance has made. `fuzz/` runs the same law on whatever it comes up with.

#[path = "../laws/motion.rs"]
mod motion;
#[path = "../laws/simulation.rs"]
mod simulation;

use chatter::analysis::simulate::{Spec, simulate};
use chatter::model::Model;
use std::ops::ControlFlow;

/// Runs; `CHATTER_ANY_SIMULATIONS` sets another number, for long runs.
fn executions() -> u64 {
    let wanted = std::env::var("CHATTER_ANY_SIMULATIONS").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(200)
}

#[test]
fn gaps_are_never_negative_time_rises_and_runs_end() {
    let first: u64 = std::env::var("CHATTER_FIRST_SEED")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(0);
    for seed in first..first + executions() {
        let byte = |k: u64| simulation::chance(seed << 8 | k) as u8;
        let bytes: Vec<u8> = (0..20).map(byte).collect();
        simulation::law(&bytes);
    }
}

#[test]
fn shipped_models_keep_to_the_law_whatever_their_parameters_are() {
    let mut prepared = motion::prepared();
    for seed in 0..10 * executions() {
        let byte = |k: u64| simulation::chance(seed << 8 | k) as u8;
        let bytes: Vec<u8> = (0..40).map(byte).collect();
        motion::law(&mut prepared, &bytes);
    }
}

/// y = 1 / (1 - t)^2 grows without bound at time 1, which steps come ever nearer to.
#[test]
fn a_pole_is_where_a_run_ends() {
    let text = "[flight]\ny = \"v\"\nv = \"6*y^2\"\n[[contact]]\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
                [initial]\ny = 1\nv = 2\n";
    let model = Model::from_toml(text, "pole.toml").unwrap();
    let run = simulate::<f64>(&model, &Spec::until(5.0), &mut |reached| {
        if reached.steps > 200_000 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let run = run.unwrap();
    assert_eq!(run.outcome.name(), "left_domain");
    assert!((run.time - 1.0).abs() < 1e-9, "{}", run.time);
}
