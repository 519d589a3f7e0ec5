//! Orbit diagrams: returns per second on one core and on all, and how the cost grows with columns, impacts and states.
//! `cargo bench -p chatter-dynamics --bench diagram`; items are returns, or impacts where it says so.

use chatter::analysis::diagram::{Range, Record, Spec, Threads, diagram};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use divan::counter::ItemsCount;
use std::fmt::Write;

fn main() {
    divan::main();
}

const VALVE: &str = include_str!("../../../models/pressure_relief_valve.toml");

fn valve() -> ReturnMap {
    map(VALVE, ReturnSpec::section("closing"))
}

fn map(text: &str, returns: ReturnSpec) -> ReturnMap {
    let model = Model::from_toml(text, "model").expect("a valid model");
    ReturnMap::new(&model, &returns).expect("a valid map")
}

/// Runs a diagram; gives the number of impacts in what was kept.
fn impacts(map: &ReturnMap, spec: &Spec, threads: usize) -> f64 {
    let rows = diagram(map, spec, &Threads::new(threads)).expect("a valid specification");
    rows.iter()
        .map(|row| row.impacts_per_return * spec.keep as f64)
        .sum()
}

/// Part of Fig. 5: a hundred returns passed over and two hundred kept at each value of q.
fn figure_5(columns: u64) -> Spec {
    Spec::new(Range::linear("q", 0.02015, 0.023, columns), "y2", 100, 200)
}

const COLUMNS: u64 = 512;

#[divan::bench(sample_count = 3, sample_size = 1, args = [1, 2])]
fn returns_on_threads(bencher: divan::Bencher, threads: usize) {
    let columns = 2000;
    let (map, spec) = (valve(), figure_5(columns));
    bencher
        .counter(ItemsCount::new(columns * (spec.transient + spec.keep)))
        .bench(|| impacts(&map, &spec, threads));
}

/// Few columns do not fill the lanes.
#[divan::bench(sample_count = 5, sample_size = 1, args = [1, 8, 16, 64, 256, 1024, 4096])]
fn returns_by_columns(bencher: divan::Bencher, columns: u64) {
    let map = valve();
    let spec = Spec {
        transient: 20,
        keep: 20,
        ..figure_5(columns)
    };
    bencher
        .counter(ItemsCount::new(columns * (spec.transient + spec.keep)))
        .bench(|| impacts(&map, &spec, 1));
}

/// Windows of period one with 41 to 32 impacts a return, and chaos with fewer: items are impacts.
#[divan::bench(sample_count = 5, sample_size = 1, args = [0.02011, 0.0203, 0.020427, 0.0218, 0.0235])]
fn impacts_by_impacts_per_return(bencher: divan::Bencher, q: f64) {
    let map = valve();
    let mut spec = figure_5(COLUMNS);
    spec.sweeps = vec![Range::linear("q", q, q + 1e-7, COLUMNS)];
    (spec.transient, spec.keep) = (0, 60);
    let count = impacts(&map, &spec, 1);
    bencher
        .counter(ItemsCount::new(count as u64))
        .bench(|| impacts(&map, &spec, 1));
}

/// Complete chatter, by restitution: what a return costs where its impacts are without number.
#[divan::bench(sample_count = 5, sample_size = 1, args = [0.0, 0.1, 0.3, 0.6, 0.79])]
fn returns_through_rest(bencher: divan::Bencher, restitution: f64) {
    let text = VALVE.replace("r = 0.8 ", &format!("r = {restitution} "));
    let map = map(&text, ReturnSpec::section("closing"));
    let mut spec = figure_5(COLUMNS);
    spec.sweeps = vec![Range::linear("q", 0.019, 0.0199, COLUMNS)];
    (spec.transient, spec.keep) = (20, 20);
    bencher
        .counter(ItemsCount::new(COLUMNS * (spec.transient + spec.keep)))
        .bench(|| diagram(&map, &spec, &Threads::new(1)));
}

/// Masses in a row between springs; the first is driven, the last hits a stop. Two states a mass.
fn chain(masses: usize) -> String {
    let mut text = String::from("[parameters]\nA = 1.0\nr = 0.7\n[flight]\n");
    for mass in 1..=masses {
        let before = match mass {
            1 => "A*cos(1.1*t)".to_owned(),
            _ => format!("x{}", mass - 1),
        };
        let behind = match mass {
            _ if mass == masses => String::new(),
            _ => format!(" + x{}", mass + 1),
        };
        let _ = write!(
            text,
            "x{mass} = \"v{mass}\"\nv{mass} = \"{before} - 2*x{mass}{behind} - 0.1*v{mass}\"\n"
        );
    }
    let _ = write!(
        text,
        "[[contact]]\nname = \"stop\"\ngap = \"x{masses} + 0.05\"\nimpulse = {{ v{masses} = 1 }}\nrestitution = \"r\"\n[initial]\n"
    );
    for mass in 1..=masses {
        let _ = write!(text, "x{mass} = 0\nv{mass} = 0\n");
    }
    text
}

/// Items are impacts; the argument is the number of states.
#[divan::bench(sample_count = 5, sample_size = 1, args = [2, 4, 8, 16])]
fn impacts_by_states(bencher: divan::Bencher, states: usize) {
    let every_impact = ReturnSpec::new(Sampling::Event {
        kind: EventKind::Impact,
        at: None,
    });
    let map = map(&chain(states / 2), every_impact);
    let spec = Spec {
        record: Record::Classes,
        ..Spec::new(Range::linear("A", 1.0, 2.0, COLUMNS), "v1", 50, 150)
    };
    bencher
        .counter(ItemsCount::new(COLUMNS * (spec.transient + spec.keep)))
        .bench(|| diagram(&map, &spec, &Threads::new(1)));
}
