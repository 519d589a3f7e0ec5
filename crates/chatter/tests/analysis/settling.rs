//! What orbits settle to, told while they do.

use chatter::analysis::diagram::{Outcome, Range, Spec, Threads, diagram};
use chatter::analysis::periodic::{PeriodicError, settled};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::model::Model;
use std::ops::ControlFlow;

/// A pendulum that hangs just at a wall which is shaken elsewhere, beside another one that it may touch: what is left of its knocks is nothing, however many
/// there are from sample to sample.
#[test]
fn knocks_that_die_out_have_the_period_of_the_forcing() {
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (1e3, 60.0)] {
        let text = |gaps: &str| {
            format!(
                "[parameters]\nw = {:?}\n[flight]\nx = \"u\"\nu = \"-{k:?}*x - {c:?}*u\"\ny = \"v\"\nv = \"-1.1*{k:?}*y - {c:?}*v\"\n{gaps}\
                 [[contact]]\nname = \"wall\"\ngap = \"{:?} + {:?}*cos(w*t) - y\"\nimpulse = {{ v = -1 }}\nrestitution = 0.4\n\
                 [section.s]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = {:?}\nu = 0\ny = 0\nv = 0\n",
                1.4 / short,
                3.0 * long,
                0.2 * long,
                -long,
                k = 1.0 / (short * short),
                c = 0.3 / short,
            )
        };
        let balls = "[[contact]]\nname = \"stop\"\ngap = \"y - x\"\nimpulse = { u = -1, v = 1 }\nrestitution = 0.93\n";
        let at_rest =
            "[[contact]]\nname = \"stop\"\ngap = \"-x\"\nimpulse = { u = -1 }\nrestitution = 0.8\n";
        for gaps in [balls, at_rest] {
            let model = Model::from_toml(&text(gaps), "knocks").unwrap();
            let map = ReturnMap::new(&model, &ReturnSpec::section("s")).expect("a map");
            let spec = Spec::new(
                Range::linear("w", 1.3 / short, 1.9 / short, 4),
                "x",
                250,
                100,
            );
            for row in diagram(&map, &spec, &Threads::new(1)).expect("a sweep") {
                assert_eq!((row.outcome, row.period), (Outcome::Periodic, 1), "{gaps}");
                // Of so many returns, and not of whichever is the last.
                let impacts = row.impacts_per_return;
                assert!(
                    impacts.fract() > 0.0 && impacts > 0.5 && impacts < 2.0,
                    "{impacts}"
                );
            }
            // Beside rest the balls knock on, as weakly as they may: one derivative there is none, wherever one starts.
            for (name, value) in [("w", 1.37), ("w", 1.5), ("w", 1.9)] {
                let mut model = model.clone();
                let value = format!("{:?}", value / short);
                model.set_parameter(name, &value).unwrap();
                let found = settled(&model, &Default::default(), &mut |_| {
                    ControlFlow::Continue(())
                });
                let refused =
                    matches!(&found, Err(PeriodicError::DiesOut { contact }) if contact == "stop");
                assert!(
                    refused,
                    "{gaps} {value}: {:?}",
                    found.map(|orbit| orbit.period)
                );
            }
        }
    }
}

/// A damped linear oscillator under a sine: all its orbits settle to one of the load's period, as
/// exp(2 pi (-z +- i sqrt(1 - z^2)) n/w).
const OSCILLATOR: &str = "[parameters]\nz = 0.02\nw = 3\n[flight]\nx = \"v\"\nv = \"-x - 2*z*v + cos(w*t)\"\n\
     [section.s]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\nx = 1\nv = 0\n";

#[test]
fn a_linear_oscillator_has_the_period_of_its_load_or_is_unsettled() {
    let stroboscopic = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi/w".to_owned(),
    });
    let section = ReturnSpec::section("s");
    // Where three samples are nearly a turn, and where a turn is nearly ten loads, whose phase is told at times far from zero.
    for (sampling, (name, from, to), (other, value)) in [
        (&stroboscopic, ("z", 0.024, 0.027), ("w", "3")),
        (&section, ("w", 2.66, 2.98), ("z", "0.02")),
        (&stroboscopic, ("w", 0.3, 0.32), ("z", "0.001")),
    ] {
        let mut model = Model::from_toml(OSCILLATOR, "oscillator.toml")
            .unwrap_or_else(|errors| panic!("{errors}"));
        model
            .set_parameter(other, value)
            .unwrap_or_else(|error| panic!("{error}"));
        let map = ReturnMap::new(&model, sampling).expect("a map");
        let spec = Spec::new(Range::linear(name, from, to, 33), "x", 300, 200);
        let rows = diagram(&map, &spec, &Threads::new(1)).expect("a sweep");
        for row in rows {
            let found = (row.outcome, row.period);
            let right = [(Outcome::Periodic, 1), (Outcome::Unsettled, 0)];
            assert!(right.contains(&found), "{name}, {}: {found:?}", row.row);
        }
    }
}

#[test]
fn an_orbit_with_complete_chatter_has_a_period_however_many_impacts_are_followed() {
    let cam = include_str!("../../../../models/dwell_cam.toml");
    let model = Model::from_toml(cam, "dwell_cam.toml").unwrap_or_else(|error| panic!("{error}"));
    let sampling = Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    };
    let map = ReturnMap::new(&model, &ReturnSpec::new(sampling)).expect("a map");
    // Twelve impacts are followed before an infinite sequence in some periods, and eleven in others.
    for speed in [2.2, 2.2267, 2.253, 2.467, 2.547] {
        let spec = Spec::new(Range::linear("omega", speed, speed, 1), "v", 300, 200);
        let rows = diagram(&map, &spec, &Threads::new(1)).expect("a sweep");
        let found = (rows[0].outcome, rows[0].period);
        assert_eq!(found, (Outcome::CompleteChatter, 1), "{speed}");
        let last = &rows[0].samples[100..];
        let apart = |&(a, b): &(&f64, &f64)| (a - b).abs() > 1e-10;
        let mut pairs = last.iter().zip(&last[1..]);
        assert!(!pairs.any(|pair| apart(&pair)), "{speed}");
    }
}
