//! Dry friction in the plane, `mu*v/hypot(u, v)`: what slides comes to rest in a finite time, rests while the force on it is less than
//! friction, and begins to slide in the direction of the force as that exceeds it.

use super::run;
use chatter::analysis::simulate::{Outcome, SimulateError, Simulation, Spec, simulate};
use chatter::flow::{Column, FlowError, Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use core::f64::consts::PI;
use std::ops::ControlFlow;

/// When motion comes to rest, and when it begins again.
fn rests<R: Real>(run: &Simulation<R>) -> Vec<(bool, f64)> {
    let of = |event: &Occurrence<R>| match event {
        Occurrence::Slide { .. } => Some(true),
        Occurrence::Leave { .. } => Some(false),
        _ => None,
    };
    (run.events.iter())
        .filter_map(|event| Some((of(&event.detail)?, event.time.to_f64())))
        .collect()
}

/// A puck that slides with speed v goes straight on for v/mu, and v^2/2mu far; in whatever units.
#[test]
fn a_puck_comes_to_rest_where_it_should() {
    fn checks<R: Real>(error: f64) {
        for (length, time) in [
            (1.0_f64, 1.0),
            (3.7e3, 0.013),
            (1.7e-5, 61.0),
            (-25.4, 1.9e4),
        ] {
            let (mu, u, v) = (
                0.3 * length / (time * time),
                length / time,
                0.5 * length / time,
            );
            let text = format!(
                "[parameters]\nmu = {:?}\n[definitions]\ns = \"hypot(u, v)\"\n\
                 [flight]\nx = \"u\"\ny = \"v\"\nu = \"-mu*u/s\"\nv = \"-mu*v/s\"\n\
                 [initial]\nx = 0\ny = 0\nu = {u:?}\nv = {v:?}\n",
                mu.abs()
            );
            let run = run::<R>(&text, 10.0 * time);
            let name = format!("{length} {time}");
            assert_eq!(run.outcome, Outcome::Horizon, "{name}");
            let speed = u.hypot(v);
            let events = rests(&run);
            assert_eq!(events.len(), 1, "{name}: {events:?}");
            assert!(
                (events[0].1 * mu.abs() / speed - 1.0).abs() < error,
                "{name}: {events:?}"
            );
            let far = speed * speed / (2.0 * mu.abs());
            let state: Vec<f64> = run.state.iter().map(|x| x.to_f64()).collect();
            assert!(
                (state[0] / (far * u / speed) - 1.0).abs() < error,
                "{name}: {state:?}"
            );
            assert!(
                (state[1] / (far * v / speed) - 1.0).abs() < error,
                "{name}: {state:?}"
            );
            assert_eq!(state[2..], [0.0, 0.0], "{name}");
        }
    }
    checks::<f64>(1e-14);
    checks::<DoubleDouble>(1e-14);
}

/// A ball that is set off sliding rolls after 2 s/(7 mu g), with five sevenths of its speed if it did not spin.
#[test]
fn a_billiard_ball_rolls_in_the_end() {
    fn checks<R: Real>() {
        for radius in [0.0286, 1.0, 3.7] {
            let text = format!(
                "[parameters]\nR = {radius:?}\n[definitions]\nsx = \"u - R*wy\"\nsy = \"v + R*wx\"\n\
                 s = \"hypot(sx, sy)\"\n[flight]\nu = \"-1.962*sx/s\"\nv = \"-1.962*sy/s\"\n\
                 wx = \"-2.5*1.962/R*sy/s\"\nwy = \"2.5*1.962/R*sx/s\"\n\
                 [initial]\nu = 2\nv = 0.5\nwx = 0\nwy = 0\n"
            );
            let run = run::<R>(&text, 1.0);
            assert_eq!(run.outcome, Outcome::Horizon, "{radius}");
            let expected = 2.0 * 2.0_f64.hypot(0.5) / (7.0 * 1.962);
            let events = rests(&run);
            assert_eq!(events.len(), 1, "{radius}: {events:?}");
            assert!(
                (events[0].1 - expected).abs() < 1e-14,
                "{radius}: {events:?}"
            );
            let rolling = [
                10.0 / 7.0,
                2.5 / 7.0,
                -2.5 / 7.0 / radius,
                10.0 / 7.0 / radius,
            ];
            for (x, expected) in run.state.iter().zip(rolling) {
                assert!((x.to_f64() / expected - 1.0).abs() < 1e-14, "{radius}: {x}");
            }
        }
    }
    checks::<f64>();
    checks::<DoubleDouble>();
}

/// On a spring each swing ends 2 mu nearer to where the force is nothing, until it is too weak: then the mass rests.
#[test]
fn a_mass_on_a_spring_rests_where_friction_holds_it() {
    let text = "[definitions]\ns = \"hypot(u, v)\"\n[flight]\nx = \"u\"\ny = \"v\"\n\
                u = \"-x - 0.3*u/s\"\nv = \"-y - 0.3*v/s\"\n[initial]\nx = 1\ny = 0.5\nu = 0\nv = 0\n";
    fn checks<R: Real>(text: &str) {
        let run = run::<R>(text, 20.0);
        assert_eq!(run.outcome, Outcome::Horizon);
        let far = 1.25_f64.sqrt();
        let left = (far - 1.2) / far;
        for (x, expected) in run.state.iter().zip([left, 0.5 * left, 0.0, 0.0]) {
            assert!((x.to_f64() - expected).abs() < 1e-14, "{x} {expected}");
        }
        let events = rests(&run);
        let last = events.last().copied().unwrap_or((false, f64::NAN));
        assert!(last.0 && (last.1 - 2.0 * PI).abs() < 1e-13, "{events:?}");
    }
    checks::<f64>(text);
    checks::<DoubleDouble>(text);
}

/// A force that is less than friction moves nothing. Where its direction stays the mass leaves with (t - mu)^2/2.
#[test]
fn a_growing_force_breaks_away() {
    let text = "[definitions]\ns = \"hypot(u, v)\"\n[flight]\nu = \"0.6*t - 0.3*u/s\"\nv = \"0.8*t - 0.3*v/s\"\n\
                [initial]\nu = 0\nv = 0\n";
    let run = run::<f64>(text, 1.3);
    assert_eq!(run.outcome, Outcome::Horizon);
    for (x, expected) in run.state.iter().zip([0.3, 0.4]) {
        assert!((x - expected).abs() < 1e-14, "{x}");
    }
    let events = rests(&run);
    assert_eq!(events.len(), 1, "{events:?}");
    assert!((events[0].1 - 0.3).abs() < 1e-15, "{events:?}");
}

/// A force that turns is followed by the direction of sliding. Expected: by the speed and the angle, s' = F n - mu, s n' = F e, from
/// the motion that follows the force on, by an implicit method (Radau) with starts at 1e-4 to 3e-6 after the force is friction.
#[test]
fn a_force_that_turns_is_followed() {
    let text = "[definitions]\ns = \"hypot(u, v)\"\n[flight]\nx = \"u\"\ny = \"v\"\n\
                u = \"-x - 0.3*u/s + 0.8*sin(t)\"\nv = \"-y - 0.3*v/s + 0.5*sin(1.7*t)\"\n\
                [initial]\nx = 0\ny = 0\nu = 0\nv = 0\n";
    let run = run::<f64>(text, 2.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    let events = rests(&run);
    assert_eq!(events.len(), 1, "{events:?}");
    assert!(
        (events[0].1 - 0.26301682591416287).abs() < 1e-14,
        "{events:?}"
    );
    let expected = [
        0.4019843373535,
        0.2274745118884,
        0.4808439307198,
        0.1088402308462,
    ];
    for (x, expected) in run.state.iter().zip(expected) {
        assert!((x - expected).abs() < 1e-11, "{x} {expected}");
    }
}

/// What friction would push on, as a force along the speed does, is refused where it begins.
#[test]
fn what_is_pushed_along_has_no_one_motion() {
    let text = "[definitions]\ns = \"hypot(u, v)\"\n[flight]\nu = \"0.3*u/s\"\nv = \"0.3*v/s\"\n[initial]\nu = 0\nv = 0\n";
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let refused = simulate::<f64>(
        &model,
        &Spec::until(1.0),
        &mut |_| ControlFlow::Continue(()),
    );
    let is_named = matches!(&refused, Err(SimulateError::Start(FlowError::NoMode { surfaces, .. }))
        if surfaces == &["u^2 + v^2"]);
    assert!(is_named, "{refused:?}");
}

/// Columns of derivatives of where a puck comes to rest, x = u |v| / 2 mu.
#[test]
fn columns_end_where_a_puck_does() {
    let text = "[parameters]\nmu = 0.3\n[definitions]\ns = \"hypot(u, v)\"\n[flight]\nx = \"u\"\ny = \"v\"\n\
                u = \"-mu*u/s\"\nv = \"-mu*v/s\"\n[initial]\nx = 0\ny = 0\nu = 1\nv = 0.5\n";
    let model = Model::from_toml(text, "model.toml").unwrap();
    let columns = [Column::State, Column::State, Column::Parameter(0)];
    let system = System::with_columns(&model, &columns).unwrap();
    let mut work = system.workspace::<f64>(&Settings::default());
    let parameters = model.parameter_values::<f64>(&[]);
    let mut start = vec![0.0, 0.0, 1.0, 0.5];
    start.extend([0.0, 0.0, 1.0, 0.0]);
    start.extend([0.0, 0.0, 0.0, 1.0]);
    start.extend([0.0; 4]);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &start).unwrap();
    while trajectory.time() < 5.0 {
        trajectory.advance(&system, &mut work, 5.0).unwrap();
    }
    let (mu, u, v) = (0.3, 1.0, 0.5);
    let speed = 1.25_f64.sqrt();
    let expected = [
        [
            (speed + u * u / speed) / (2.0 * mu),
            u * v / speed / (2.0 * mu),
        ],
        [
            u * v / speed / (2.0 * mu),
            (speed + v * v / speed) / (2.0 * mu),
        ],
        [-u * speed / (2.0 * mu * mu), -v * speed / (2.0 * mu * mu)],
    ];
    for (index, expected) in expected.into_iter().enumerate() {
        let found = system.column(trajectory.state(), index);
        let error = (found[0] - expected[0]).abs() + (found[1] - expected[1]).abs();
        assert!(error < 1e-12, "{index}: {found:?} {expected:?}");
        assert!(
            found[2].abs() + found[3].abs() < 1e-12,
            "{index}: {found:?}"
        );
    }
}

/// Friction that is not the same in all directions holds, and lets go, by the ellipse of its forces. Expected: as above, by Radau from
/// 1e-5 and 3e-6 after the start at 1/|(2, 4/3)|.
#[test]
fn friction_of_an_ellipse_breaks_away() {
    let text = "[definitions]\ns = \"hypot(u, 2*v)\"\n[flight]\nu = \"0.6*t - 0.3*u/s\"\nv = \"0.8*t - 1.2*v/s\"\n\
                [initial]\nu = 0\nv = 0\n";
    let run = run::<f64>(text, 1.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    let events = rests(&run);
    assert_eq!(events.len(), 1, "{events:?}");
    assert!(
        (events[0].1 * 2.0_f64.hypot(4.0 / 3.0) - 1.0).abs() < 1e-14,
        "{events:?}"
    );
    for (x, expected) in run.state.iter().zip([0.12553523318714, 0.08251893775477]) {
        assert!((x - expected).abs() < 1e-12, "{x} {expected}");
    }
}
