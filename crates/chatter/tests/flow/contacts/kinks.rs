//! A ball that bounces to the bottom of a valley: with a contact a slope it comes to rest there, with one contact whose gap has a kink
//! that is refused.

use chatter::analysis::simulate::{Outcome, SimulateError, Simulation, Spec, simulate};
use chatter::flow::FlowError;
use chatter::model::Model;
use std::ops::ControlFlow;

const UNITS: [(f64, f64); 4] = [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)];

/// The bottom moves aside by a sine.
fn valley(contacts: &str, swing: f64, place: [f64; 2], (long, short): (f64, f64)) -> String {
    let bottom = format!("(x - {:?}*sin(t/{short:?}))", swing * long);
    format!(
        "[flight]\nx = \"v\"\nv = \"0\"\ny = \"w\"\nw = \"-{:?}\"\n{}\
         [initial]\nx = {:?}\nv = 0\ny = {:?}\nw = 0\n",
        long / (short * short),
        contacts.replace("BOTTOM", &bottom),
        place[0] * long,
        place[1] * long,
    )
}

const SLOPES: &str = "[[contact]]\nname = \"right\"\ngap = \"y - 0.5*BOTTOM\"\nimpulse = { v = \"-0.5\", w = 1 }\nrestitution = 0.5\n\
     [[contact]]\nname = \"left\"\ngap = \"y + 0.5*BOTTOM\"\nimpulse = { v = \"0.5\", w = 1 }\nrestitution = 0.5\n";

const KINK: &str = "[[contact]]\nname = \"valley\"\ngap = \"y - 0.5*abs(BOTTOM)\"\n\
     impulse = { v = \"-0.5*sign(BOTTOM)\", w = 1 }\nrestitution = 0.5\n";

fn run(text: &str, until: f64) -> Result<Simulation<f64>, SimulateError> {
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let spec = Spec {
        impacts: 20_000,
        ..Spec::until(until)
    };
    simulate(&model, &spec, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn on_two_contacts_a_ball_comes_to_rest_at_the_bottom_and_goes_with_it() {
    for units in UNITS {
        for swing in [0.0, 0.02] {
            let text = valley(SLOPES, swing, [0.3, 1.0], units);
            let run = run(&text, 20.0 * units.1).expect("a legal start");
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let bottom = swing * f64::sin(20.0);
            let off = [run.state[0] / units.0 - bottom, run.state[2] / units.0];
            assert!(off.iter().all(|off| off.abs() < 1e-13), "{off:?} {text}");
        }
    }
}

#[test]
fn rest_on_a_kink_of_one_gap_is_refused_whether_come_to_or_begun_on() {
    for units in UNITS {
        for swing in [0.0, 0.2] {
            let text = valley(KINK, swing, [0.3, 1.0], units);
            let run = run(&text, 20.0 * units.1).expect("a legal start");
            let Outcome::Failed(FlowError::RestsOnKink {
                time, contact: 0, ..
            }) = run.outcome
            else {
                panic!("{:?} {text}", run.outcome);
            };
            // It has to fall, and loses energy at each impact.
            assert!((1.0..15.0).contains(&(time / units.1)), "{time} {text}");
        }
        let refused = run(&valley(KINK, 0.0, [0.0, 0.0], units), units.1);
        let on_kink =
            |error: &FlowError| matches!(error, FlowError::RestsOnKink { contact: 0, .. });
        assert!(matches!(refused, Err(SimulateError::Start(ref error)) if on_kink(error)));
    }
}

/// A ball that falls onto a plate without thickness, whose gap is how far it is from it on either side.
#[test]
fn what_chatters_to_rest_on_a_kink_does_not_go_on_beyond_it() {
    for (long, short) in UNITS {
        for (factor, place) in [(1.0, 0.0), (2.0, 0.0), (1.0, 0.3)] {
            let text = format!(
                "[flight]\nx = \"v\"\nv = \"-{:?}\"\n[initial]\nx = {:?}\nv = 0\n[[contact]]\nname = \"plate\"\n\
                 gap = \"{factor:?}*abs(x - {:?})\"\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n",
                long / (short * short),
                (place + 1.0) * long,
                place * long,
            );
            let run = run(&text, 10.0 * short).expect("a legal start");
            let Outcome::Failed(FlowError::RestsOnKink {
                time, contact: 0, ..
            }) = run.outcome
            else {
                panic!("{:?} {text}", run.outcome);
            };
            // Falls and flights last sqrt(2)(1 + 2 (1/2 + 1/4 + ...)).
            assert!(
                (time / short - f64::sqrt(18.0)).abs() < 1e-13,
                "{time} {text}"
            );
        }
    }
}
