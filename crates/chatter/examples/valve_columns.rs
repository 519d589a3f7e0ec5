//! Times the columns of an orbit diagram of the valve, on one core unless told otherwise, and prints, as one line of JSON, what the
//! peers' script compares: `cargo run --release -p chatter-dynamics --example valve_columns -- COLUMNS TRANSIENT KEEP [THREADS [TOLERANCE]]`.

use chatter::analysis::diagram::{Range, Spec, Threads, diagram};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec};
use chatter::model::Model;
use std::time::Instant;

const VALVE: &str = include_str!("../../../models/pressure_relief_valve.toml");

/// More samples than this are counted, not printed.
const PRINTED: usize = 10_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u64> = arguments.iter().flat_map(|text| text.parse()).collect();
    let tolerance = arguments.get(4).map_or(Ok(0.0), |text| text.parse())?;
    let (&[columns, transient, keep], more) = numbers
        .split_first_chunk()
        .ok_or("expected three numbers: COLUMNS TRANSIENT KEEP [THREADS]")?;
    let threads = more.first().map_or(1, |&threads| threads as usize);
    let model = Model::from_toml(VALVE, "pressure_relief_valve.toml")?;
    let mut closing = ReturnSpec::section("closing");
    closing.tolerance = tolerance;
    let map = ReturnMap::new(&model, &closing)?;
    let spec = Spec::new(
        Range::linear("q", 0.02015, 0.023, columns),
        "y2",
        transient,
        keep,
    );
    let started = Instant::now();
    let rows = diagram(&map, &spec, &Threads::new(threads))?;
    let spent = started.elapsed().as_secs_f64();
    let returns = (columns * (transient + keep)) as f64;
    let mean: f64 = rows.iter().map(|row| row.impacts_per_return).sum::<f64>() / columns as f64;
    let mut samples: Vec<f64> = rows.into_iter().flat_map(|row| row.samples).collect();
    samples.truncate(PRINTED);
    println!(
        "{{\"returns_per_second\": {}, \"impacts_per_return\": {mean}, \"samples\": {samples:?}}}",
        returns / spent
    );
    Ok(())
}
