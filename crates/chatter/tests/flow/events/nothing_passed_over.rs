//! Nothing is passed over while the end of a chatter sequence is extrapolated, nor between the ends of a step that the states
//! alone would allow.

use chatter::flow::{FlowError, Occurrence, Settings, System, Trajectory};
use chatter::model::Model;

const BALL: &str = include_str!("../../../../../models/bouncing_ball.toml");

/// What happens until a time, with the time of each event.
fn events(text: &str, until: f64) -> (Vec<(f64, Occurrence<f64>)>, Vec<f64>) {
    let model = Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    let system = System::new(&model).unwrap();
    let parameters = model.parameter_values::<f64>(&[]);
    let mut work = system.workspace::<f64>(&Settings::default());
    let initial = model.initial_state(&parameters);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, 0.0, &initial).unwrap();
    let mut events = Vec::new();
    loop {
        match trajectory.advance(&system, &mut work, until).unwrap() {
            Some(Occurrence::Horizon) => {
                let mut end = vec![trajectory.time()];
                end.extend(trajectory.state());
                return (events, end);
            }
            Some(occurrence) => events.push((trajectory.time(), occurrence)),
            None => {}
        }
    }
}

/// The states are polynomials, which one step covers from impact to impact; the section is not. Some of its crossings
/// fall into the end of the chatter, some into rest.
#[test]
fn fast_sections_are_crossed_as_often_as_they_are() {
    for rate in [4.0, 40.0, 400.0] {
        let text = format!(
            "[parameters]\nr = 0.5\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\n\
             impulse = {{ v = 1 }}\nrestitution = \"r\"\n[section.clock]\nsurface = \"sin({rate}*t)\"\n\
             direction = \"rising\"\n[initial]\ny = 5.0\nv = 1.0\n"
        );
        let (events, _) = events(&text, 15.0);
        let crossings = events
            .iter()
            .filter(|(_, e)| matches!(e, Occurrence::Section { .. }));
        let turn = std::f64::consts::TAU / rate;
        let mut count = 0;
        for (time, _) in crossings {
            count += 1;
            let off = time - f64::from(count) * turn;
            assert!(off.abs() < 1e-13, "{count}: {off}");
        }
        assert_eq!(count, (15.0 / turn) as i32);
    }
}

/// A ball stops where it is asked to, however near the end of its bounces: on the parabola of the bounce that it is in.
#[test]
fn a_trajectory_stops_within_its_chatter_where_it_should() {
    const G: f64 = 9.81;
    let fall = (2.0 / G).sqrt();
    let end = 3.0 * fall;
    for left in [1e-1, 1e-2, 1e-3, 1e-5, 1e-8] {
        let until = end - left;
        let (_, at) = events(BALL, until);
        assert_eq!(at[0], until);
        // The bounce that begins with time 2 fall 2^-k left until the end lasts half of that.
        let mut begins = 2.0 * fall;
        while begins * 0.5 > left {
            begins *= 0.5;
        }
        let since = begins - left;
        let rate = 0.5 * G * begins * 0.5;
        let (height, speed) = (rate * since - 0.5 * G * since * since, rate - G * since);
        assert!((at[1] - height).abs() < 1e-14, "{left}: {at:?} {height}");
        assert!((at[2] - speed).abs() < 1e-13, "{left}: {at:?} {speed}");
    }
}

/// Two balls that do not know of each other: the second one's first bounce falls into the last of the first one's.
#[test]
fn another_contact_is_hit_while_one_chatters() {
    const G: f64 = 9.81;
    let end = 3.0 * (2.0 / G).sqrt();
    for before in [1e-1, 1e-3, 1e-6] {
        let at = end - before;
        let height = 0.5 * G * at * at;
        let text = format!(
            "[parameters]\ng = 9.81\nr = 0.5\n[flight]\ny = \"v\"\nv = \"-g\"\nz = \"w\"\nw = \"-g\"\n\
             [[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = {{ v = 1 }}\nrestitution = \"r\"\n\
             [[contact]]\nname = \"other\"\ngap = \"z\"\nimpulse = {{ w = 1 }}\nrestitution = \"r\"\n\
             [initial]\ny = 1.0\nv = 0.0\nz = {height:e}\nw = 0.0\n"
        );
        let (events, _) = events(&text, 2.0);
        let other = |(_, event): &&(f64, Occurrence<f64>)| {
            matches!(event, Occurrence::Impact { contact: 1, .. })
        };
        let (time, _) = events.iter().find(other).unwrap();
        assert!((time - at).abs() < 1e-14, "{time} {at}");
        let rests = |(time, event): &&(f64, Occurrence<f64>)| {
            matches!(event, Occurrence::Accumulation { contact: 0, .. })
                && (time - end).abs() < 1e-13
        };
        assert_eq!(events.iter().filter(rests).count(), 1, "{before}");
    }
}

/// A mass that flies away faster and faster, until its gap is no number any more.
#[test]
fn a_state_that_overflows_ends_the_trajectory() {
    let text = "[parameters]\nr = 0.5\n[flight]\nx = \"v\"\nv = \"x\"\n[[contact]]\nname = \"stop\"\ngap = \"x\"\n\
                impulse = { v = 1 }\nrestitution = \"r\"\n[initial]\nx = 1.0\nv = 1.0\n";
    let model = Model::from_toml(text, "test").unwrap();
    let system = System::new(&model).unwrap();
    let mut work = system.workspace::<f64>(&Settings::default());
    let mut trajectory = Trajectory::start(&system, &mut work, &[0.5], 0.0, &[1.0, 1.0]).unwrap();
    let end = loop {
        match trajectory.advance(&system, &mut work, 1e4) {
            Ok(None) => {}
            other => break other,
        }
    };
    assert!(
        matches!(end, Err(FlowError::LeftDomain { time, .. }) if (700.0..710.0).contains(&time)),
        "{end:?}"
    );
}
