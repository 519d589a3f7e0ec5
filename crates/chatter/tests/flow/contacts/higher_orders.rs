//! A contact at rest where neither acceleration nor jerk moves it: the first derivative that does decides.

use chatter::analysis::simulate::{Outcome, Simulation, Spec, simulate};
use chatter::flow::Occurrence;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use std::ops::ControlFlow;

fn run<R: Real>(force: &str, until: f64) -> Simulation<R> {
    let text = format!(
        r#"
        [flight]
        y = "v"
        v = "{force}"
        [[contact]]
        name = "floor"
        gap = "y"
        impulse = {{ v = 1 }}
        restitution = 0.5
        [initial]
        y = 0
        v = 0
        "#
    );
    let model = Model::from_toml(&text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_or_else(|error| panic!("{force}: {error}"))
}

/// Place after a time under a force from rest.
type Place = fn(f64) -> f64;

#[test]
fn the_first_derivative_that_is_not_zero_opens_a_contact() {
    let forces: [(&str, Place); 6] = [
        ("t^2", |t| t.powi(4) / 12.0),
        ("t^3", |t| t.powi(5) / 20.0),
        ("t^6", |t| t.powi(8) / 56.0),
        ("t^9", |t| t.powi(11) / 110.0),
        ("1 - cos(t)", |t| t * t / 2.0 + t.cos() - 1.0),
        ("1e-9*t^4", |t| 1e-9 * t.powi(6) / 30.0),
    ];
    for (force, place) in forces {
        let opened = run::<f64>(force, 2.0);
        assert_eq!(opened.outcome, Outcome::Horizon, "{force}");
        assert_eq!(opened.counts.impacts, 0, "{force}");
        assert!(!opened.closed.contains(0), "{force}");
        let expected = place(2.0);
        let error = (opened.state[0] / expected - 1.0).abs();
        assert!(error < 1e-13, "{force}: {:?}", opened.state);
        let fine = run::<DoubleDouble>(force, 2.0).state[0];
        assert!((fine.to_f64() / expected - 1.0).abs() < 1e-13, "{force}");
    }
}

#[test]
fn and_keeps_it_closed_until_the_force_lifts_it() {
    for force in ["t^3 - t^2", "t^10 - t^9", "t^5 - t^4", "cos(t) - 1 + t^3/2"] {
        let held = run::<f64>(force, 2.0);
        assert_eq!(held.outcome, Outcome::Horizon, "{force}");
        assert_eq!(held.events.len(), 1, "{force}: {:?}", held.events);
        let released = &held.events[0];
        assert!(matches!(released.detail, Occurrence::Release { .. }));
        let expected = match force {
            "cos(t) - 1 + t^3/2" => 0.929_974_818_992_58,
            _ => 1.0,
        };
        let error = (released.time - expected).abs();
        assert!(error < 1e-10, "{force}: {}", released.time);
    }
    // Nothing moves it to any order.
    for force in ["0", "0*t", "-y"] {
        let still = run::<f64>(force, 2.0);
        assert!(still.closed.contains(0), "{force}");
        assert_eq!(still.state[0], 0.0, "{force}");
    }
}
