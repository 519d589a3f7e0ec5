//! Three free balls of which the middle one bounces between the others: below a restitution of 7 - 4 sqrt(3) they come to rest on each
//! other (inelastic collapse), above it they part after a finite number of impacts.

use chatter::analysis::simulate::{Outcome, Simulation, Spec, simulate};
use chatter::flow::{Closed, Occurrence};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};
use std::ops::ControlFlow;

fn run<R: Real>(restitution: f64) -> Simulation<R> {
    let text = format!(
        r#"
        [flight]
        x0 = "v0"
        v0 = "0"
        x1 = "v1"
        v1 = "0"
        x2 = "v2"
        v2 = "0"
        [[contact]]
        name = "a"
        gap = "x1 - x0"
        impulse = {{ v0 = -1, v1 = 1 }}
        restitution = {restitution}
        [[contact]]
        name = "b"
        gap = "x2 - x1"
        impulse = {{ v1 = -1, v2 = 1 }}
        restitution = {restitution}
        [initial]
        x0 = 0
        x1 = 0.3
        x2 = 1
        v0 = 1
        v1 = 0
        v2 = -0.5
        "#
    );
    let model = Model::from_toml(&text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate(
        &model,
        &Spec::until(5.0),
        &mut |_| ControlFlow::Continue(()),
    )
    .expect("a legal start")
}

/// When they have collapsed, by gaps and their rates alone; none if they part.
fn collapse(restitution: f64) -> Option<f64> {
    type Dd = DoubleDouble;
    let r = Dd::from(restitution);
    let half = (r + Dd::ONE) * Dd::from(0.5);
    let mut time = Dd::ZERO;
    let mut gaps = [0.3, 0.7].map(Dd::from);
    let mut rates = [-1.0, -0.5].map(Dd::from);
    loop {
        let flight = |k: usize| {
            let falls = rates[k] < Dd::ZERO && gaps[k] > Dd::ZERO;
            falls.then(|| (-(gaps[k] / rates[k]), k))
        };
        let (first, second) = (flight(0), flight(1));
        let next = match (first, second) {
            (Some(a), Some(b)) => Some(if a.0 < b.0 { a } else { b }),
            (one, other) => one.or(other),
        };
        let (duration, hit) = next?;
        time += duration;
        if duration < time * Dd::from(1e-25) {
            return Some(time.to_f64());
        }
        for (gap, &rate) in gaps.iter_mut().zip(&rates) {
            *gap = rate.mul_add(duration, *gap);
        }
        gaps[hit] = Dd::ZERO;
        rates[1 - hit] = half.mul_add(rates[hit], rates[1 - hit]);
        rates[hit] = -(r * rates[hit]);
    }
}

/// Rates are rounding long before the gaps are closed: the time of the end is known as far as the flights before say.
fn check<R: Real>(restitution: f64, expected: f64) {
    let run = run::<R>(restitution);
    let end = (run.events.iter()).find_map(|event| match event.detail {
        Occurrence::Accumulation { error, .. } => Some((event.time.to_f64(), error)),
        _ => None,
    });
    // Flights may be below rounding before rates are: then they are collisions of one instant.
    let at_once = run.closed == Closed::NONE.with(0).with(1) && end.is_none();
    let latest = run.events.last().map(|event| event.time.to_f64());
    let end = end.or(latest.filter(|_| at_once).map(|time| (time, 1e-14)));
    let (time, error) = end.expect("an end");
    assert_eq!(run.outcome, Outcome::Horizon, "{restitution}");
    let off = (time - expected).abs();
    // Both are told as doubles.
    assert!(
        off <= error + f64::EPSILON,
        "{restitution}: {time} is {off} off, told {error}"
    );
    assert!(error < 0.1, "{restitution}: {error}");
}

#[test]
fn the_time_of_a_collapse_is_as_good_as_is_told() {
    for restitution in [0.003, 0.01, 0.03, 0.05, 0.06, 0.065, 0.07] {
        check::<f64>(
            restitution,
            collapse(restitution).expect("they come to rest"),
        );
    }
    // By arithmetic of 60 digits: rates are below the smallest double before it is over.
    check::<f64>(0.0717, 1.007_767_867_093_1);
    check::<DoubleDouble>(0.0717, 1.007_767_867_093_1);
}

#[test]
fn balls_that_part_in_the_end_are_not_said_to_collapse() {
    for restitution in [0.0719, 0.072, 0.0725, 0.073, 0.08, 0.2] {
        assert_eq!(collapse(restitution), None, "{restitution}");
        let (short, long) = (run::<f64>(restitution), run::<DoubleDouble>(restitution));
        for (outcome, counts) in [(short.outcome, short.counts), (long.outcome, long.counts)] {
            assert_eq!(outcome, Outcome::Horizon, "{restitution}");
            assert_eq!(counts.accumulations, 0, "{restitution}");
        }
        // They part at rates that may be rounding: then they are told to graze, and are as near to each other as can be told.
        for (x, fine) in short.state.iter().zip(&long.state) {
            assert!((x - fine.to_f64()).abs() < 1e-14, "{restitution}: {x}");
        }
    }
}
