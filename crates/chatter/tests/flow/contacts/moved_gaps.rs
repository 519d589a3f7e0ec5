//! Impacts that move the gap of their own contact: floors that are dented, stops that wear, a ball that is let fall again.

use chatter::analysis::simulate::{Outcome, Spec, simulate};
use chatter::flow::{FlowError, Occurrence};
use chatter::model::Model;
use std::ops::ControlFlow;

/// Times of the first impacts of a ball that falls by g from 0.5 length / 1 on a floor at s, whose `change` is what an impact does.
fn impacts(change: &str, [length, time]: [f64; 2], until: f64) -> (Vec<f64>, Outcome) {
    let text = format!(
        "[parameters]\nl = {length:?}\nT = {time:?}\n[flight]\ny = \"v\"\nv = \"-l/T^2\"\ns = \"0\"\n[[contact]]\nname = \"floor\"\n\
         gap = \"y - s\"\n{change}\n[initial]\ny = \"0.5*l\"\nv = 0\ns = 0\n"
    );
    let model = Model::from_toml(&text, "dented").unwrap_or_else(|errors| panic!("{errors}"));
    let spec = Spec::until(until * time);
    let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("a start");
    let times = (run.events.iter())
        .filter(|event| matches!(event.detail, Occurrence::Impact { .. }))
        .map(|event| event.time / time);
    (times.collect(), run.outcome)
}

/// Falls onto a floor that each blow at rate v lowers by `dent(v)` and throws back by half.
fn fall(dent: impl Fn(f64) -> f64, count: usize) -> Vec<f64> {
    let (mut t, mut rise, mut gap) = (0.0, 0.0_f64, 0.5);
    (0..count)
        .map(|_| {
            let flight = rise + (rise * rise + 2.0 * gap).sqrt();
            t += flight;
            let rate = rise - flight;
            gap = dent(rate);
            rise = -rate / 2.0;
            t
        })
        .collect()
}

const UNITS: [[f64; 2]; 3] = [[1.0, 1.0], [1e-6, 1e-3], [1e7, 2.5e4]];

#[test]
fn a_dented_floor_is_hit_later() {
    for units in UNITS {
        for (change, dent) in [
            (
                "reset = { v = \"-v/2\", s = \"s - 0.01*v^2*T^2/l\" }",
                (|v| 0.01 * v * v) as fn(f64) -> f64,
            ),
            ("reset = { v = \"-v/2\", s = \"s - 0.2*v^2*T^2/l\" }", |v| {
                0.2 * v * v
            }),
            ("reset = { v = \"-v/2\", s = \"s + 0.01*v*T\" }", |v| {
                -0.01 * v
            }),
            ("reset = { v = \"-v/2\", y = \"y + 0.1*l\" }", |_| 0.1),
            (
                "impulse = { v = 1, s = \"-0.02*T\" }\nrestitution = 0.5",
                |v| -0.03 * v,
            ),
        ] {
            let exact = fall(dent, 6);
            let (times, _) = impacts(change, units, exact[5] + 1e-3);
            assert_eq!(times.len(), 6, "{change}: {times:?} for {exact:?}");
            for (time, exact) in times.iter().zip(&exact) {
                assert!(
                    (time - exact).abs() < 1e-13 * exact,
                    "{change}: {times:?} for {exact:?}"
                );
            }
        }
    }
}

/// Dents that shrink with the rate follow each other without end, up to the time that they add up to: the flights of heights
/// that are below a rounding of the floor's place, a root of one in length, are known no better.
#[test]
fn a_ball_hops_in_its_dent_as_long_as_it_can_be_told() {
    let change = "reset = { v = \"-v/2\", s = \"s - 0.01*v^2*T^2/l\" }";
    for units in UNITS {
        let (times, outcome) = impacts(change, units, 10.0);
        let Outcome::Failed(FlowError::ResetsWithoutEnd { time, contact: 0 }) = outcome else {
            panic!("{outcome:?}: {times:?}");
        };
        let end = fall(|v| 0.01 * v * v, 200)[199];
        assert!((time / units[1] - end).abs() < 1e-7, "{time} for {end}");
    }
}

/// Caught, and let fall from the same height again.
#[test]
fn a_ball_that_is_lifted_falls_again() {
    let change = "reset = { v = 0, y = \"s + 0.5*l\" }";
    for units in UNITS {
        let (times, _) = impacts(change, units, 5.5);
        assert_eq!(times.len(), 5, "{times:?}");
        for (time, exact) in times.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0]) {
            assert!((time - exact).abs() < 1e-13, "{times:?}");
        }
    }
}

#[test]
fn an_impact_that_puts_the_state_into_the_wall_is_an_error() {
    let change = "reset = { v = \"-v/2\", s = \"s + 0.1*abs(v)\" }";
    let text = format!(
        "[flight]\ny = \"v\"\nv = -1\ns = \"0\"\n[[contact]]\nname = \"floor\"\ngap = \"y - s\"\n{change}\n[initial]\ny = 0.5\nv = 0\ns = 0\n"
    );
    let model = Model::from_toml(&text, "raised").unwrap();
    let spec = Spec::until(3.0);
    let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    match run.outcome {
        Outcome::Failed(FlowError::JumpsInside { time, contact, gap }) => {
            assert_eq!((time, contact), (1.0, 0));
            assert!((gap + 0.1).abs() < 1e-15);
        }
        other => panic!("{other:?}"),
    }
}

/// A state that the impact puts onto the contact has moved nothing.
#[test]
fn a_state_that_is_put_onto_the_floor_is_on_it() {
    for change in [
        "reset = { v = \"-v/2\", y = \"s\" }",
        "reset = { v = \"-v/2\", y = \"y + 0*v\" }",
    ] {
        let (times, _) = impacts(change, [1.0, 1.0], 2.9);
        assert_eq!(times.len(), 5, "{change}: {times:?}");
        let exact = fall(|_| 0.0, times.len());
        for (time, exact) in times.iter().zip(&exact) {
            assert!((time - exact).abs() < 1e-13, "{change}: {times:?}");
        }
    }
}
