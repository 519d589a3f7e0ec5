//! A forced oscillator on its periodic orbit, looked at once a period for ever so many periods: it stands still.

use chatter::analysis::diagram::{Range, Spec, Threads, diagram};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::analysis::simulate::{self, simulate};
use chatter::model::{Model, ModelBuilder};
use chatter::numerics::DoubleDouble;
use std::ops::ControlFlow;

const DAMPING: f64 = 0.5;

/// With a wall that it never meets.
fn oscillator(omega: f64) -> Model {
    ModelBuilder::new()
        .parameter("omega", omega)
        .parameter("c", DAMPING)
        .state("x", "v", 0.0)
        .state("v", "-x - c*v + cos(omega*t)", 0.0)
        .contact("wall", "5 - x", [("v", -1.0)], 0.5)
        .build()
        .expect("a valid model")
}

/// Its position at multiples of the period.
fn position(omega: f64) -> f64 {
    let stiff = 1.0 - omega * omega;
    stiff / (stiff * stiff + (DAMPING * omega) * (DAMPING * omega))
}

#[test]
fn a_stroboscopic_map_does_not_drift() {
    let sampling = Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    };
    let map = ReturnMap::new(&oscillator(2.8), &ReturnSpec::new(sampling)).expect("a valid map");
    let spec = Spec::new(Range::linear("omega", 1.3, 2.8, 2), "x", 300_000, 20);
    let rows = diagram(&map, &spec, &Threads::new(1)).expect("a valid sweep");
    for (row, omega) in rows.iter().zip([1.3, 2.8]) {
        assert_eq!(row.samples.len(), 20);
        for sample in &row.samples {
            let off = (sample - position(omega)).abs();
            assert!(
                off < 2e-12,
                "omega = {omega}: off by {off:e} after 300000 periods"
            );
        }
    }
}

#[test]
fn samples_at_equal_intervals_do_not_drift() {
    let omega = 2.75;
    let period = DoubleDouble::PI * DoubleDouble::from(2.0) / DoubleDouble::from(omega);
    let spec = simulate::Spec {
        sampling: vec![simulate::Sampling::Every(period)],
        ..simulate::Spec::until(period * DoubleDouble::from(100_000.5))
    };
    let run = simulate::<f64>(
        &oscillator(omega),
        &spec,
        &mut |_| ControlFlow::Continue(()),
    )
    .expect("a valid run");
    let samples = &run.samples[0];
    assert_eq!(samples.len(), 100_001);
    for sample in &samples.states[0][99_980..] {
        let off = (sample - position(omega)).abs();
        assert!(off < 1e-13, "off by {off:e}");
    }
}
