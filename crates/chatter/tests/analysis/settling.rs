//! What orbits settle to, told while they do.

use chatter::analysis::diagram::{Outcome, Range, Spec, Threads, diagram};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::model::Model;

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
