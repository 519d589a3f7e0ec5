//! Times one trajectory of the valve at q = 0.0203 and prints, as one line of JSON, what the peers' script compares:
//! `cargo run --release -p chatter-dynamics --example valve_trajectory -- [IMPACTS [Q [TOLERANCE]]]`.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use std::time::Instant;

const VALVE: &str = include_str!("../../../models/pressure_relief_valve.toml");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u32 = std::env::args().nth(1).unwrap_or("100000".into()).parse()?;
    let q: f64 = std::env::args().nth(2).unwrap_or("0.0203".into()).parse()?;
    let tolerance = std::env::args().nth(3).unwrap_or("0".into()).parse()?;
    let settings = Settings {
        tolerance,
        ..Settings::default()
    };
    let model = Model::from_toml(VALVE, "pressure_relief_valve.toml")?;
    let system = System::new(&model).map_err(|error| format!("{error:?}"))?;
    let mut work = system.workspace::<f64>(&settings);
    let parameters = model.parameter_values::<f64>(&[(0, q)]);
    let state = model.initial_state(&parameters);
    let mut valve = Trajectory::start(&system, &mut work, &parameters, 0.0, &state)?;
    let started = Instant::now();
    let mut left = count;
    while left > 0 {
        let told = valve.advance(&system, &mut work, f64::MAX)?;
        left -= u32::from(matches!(told, Some(Occurrence::Impact { .. })));
    }
    let spent = started.elapsed().as_secs_f64();
    println!(
        "{{\"microseconds_per_impact\": {}, \"time\": {:?}, \"state\": {:?}}}",
        1e6 * spent / f64::from(count),
        valve.time(),
        valve.state()
    );
    Ok(())
}
