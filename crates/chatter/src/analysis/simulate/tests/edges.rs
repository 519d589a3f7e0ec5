//! Where the mechanics end: equations that have no value, impacts that no restitution explains, contacts without force.

use super::*;

#[test]
fn what_was_computed_before_a_domain_error_is_kept() {
    let text = "
[flight]
x = 'v'
v = '-1 - sqrt(1.5 - t)'
[[contact]]
gap = 'x'
impulse = { v = 1 }
restitution = 0.9
[initial]
x = 1
v = 0
";
    let simulation = run::<f64>(&model(text, &[]), &Spec::until(10.0));
    let Outcome::Failed(FlowError::Singular { time, .. }) = simulation.outcome else {
        panic!("{:?}", simulation.outcome)
    };
    assert!((time - 1.5).abs() < 1e-9, "{time}");
    assert!(simulation.counts.impacts > 0);
    assert_eq!(simulation.outcome.name(), "singular");
}

/// A restitution that passes 1 at the fourth impact: the run ends there, at the state before that impact.
#[test]
fn an_illegal_impact_is_not_applied() {
    let text = BALL.replace("restitution = 'r'", "restitution = '0.4 + 0.5*t'");
    let simulation = run::<f64>(&model(&text, &[]), &Spec::until(10.0));
    let Outcome::Failed(FlowError::Restitution { time, value, .. }) = simulation.outcome else {
        panic!("{:?}", simulation.outcome)
    };
    assert!(
        (value - (0.4 + 0.5 * time)).abs() < 1e-12 && value > 1.0,
        "{value} at {time}"
    );
    assert_eq!(simulation.time, time);
    let [gap, rate] = simulation.state[..2] else {
        panic!("{:?}", simulation.state)
    };
    assert!(gap.abs() < 1e-12, "{gap}");
    let incoming = impact_times(&simulation);
    let flight = time - incoming[incoming.len() - 1];
    assert!(
        (rate + 9.81 * flight / 2.0).abs() < 1e-12,
        "{rate} after a flight of {flight}"
    );
}

/// Without flow through it, a valve at its set pressure is in equilibrium on its seat, which carries no force.
#[test]
fn an_equilibrium_without_contact_force_lasts() {
    let spec = Spec::until(10.0);
    let valve = model(VALVE, &[("q", "0"), ("y1", "0"), ("y2", "0"), ("y3", "10")]);
    let at_rest = run::<f64>(&valve, &spec);
    assert_eq!(at_rest.outcome, Outcome::Horizon);
    assert_eq!(at_rest.state, [0.0, 0.0, 10.0]);
    assert_eq!(at_rest.closed, Closed::NONE.with(0));
    assert_eq!(at_rest.counts.impacts + at_rest.counts.releases, 0);
    let precise = run::<DoubleDouble>(&valve, &spec);
    assert_eq!(precise.outcome, Outcome::Horizon);
}

/// An accumulation is as uncertain as the tolerance lets its flights be.
#[test]
fn the_error_of_an_accumulation_covers_the_tolerance() {
    let valve = model(VALVE, &[("q", "0.0195")]);
    let exact = accumulations(&run::<DoubleDouble>(&valve, &Spec::until(6.0)))[0].time;
    for tolerance in [0.0, 1e-12, 1e-9, 1e-6] {
        let mut spec = Spec::until(6.0);
        spec.tolerance = tolerance;
        let simulation = run::<f64>(&valve, &spec);
        let event = accumulations(&simulation)[0];
        let Occurrence::Accumulation { error, .. } = event.detail else {
            panic!("{event:?}")
        };
        let miss = (DoubleDouble::from(event.time) - exact).abs().to_f64();
        assert!(miss <= error, "{tolerance}: off by {miss}, said {error}");
        assert!(error <= 2e-14 + 10.0 * tolerance, "{tolerance}: {error}");
    }
}
