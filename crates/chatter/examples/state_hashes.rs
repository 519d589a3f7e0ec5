//! Follows each shipped model, alone and side by side at many values of its first parameter, and prints a hash of all states
//! and times by model: what must not depend on the processor, nor on what runs the expansions.
//! `cargo run --release -p chatter-dynamics --example state_hashes -- [interpreter|compiled]`; `.ci/other-processors` compares.

use chatter::expressions::Backend;
use chatter::flow::{FlowError, Next, Occurrence, Settings, System, Trajectory, run_fleet};
use chatter::model::Model;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const COLUMNS: usize = 40;
const OCCURRENCES: u32 = 60;

/// FNV-1a, of the bits of numbers.
struct Hash(u64);

impl Hash {
    fn add(&mut self, value: f64) {
        for byte in value.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn add_end(&mut self, trajectory: &Trajectory<f64>) {
        self.add(trajectory.time());
        trajectory.state().iter().for_each(|&x| self.add(x));
    }
}

/// Trajectories at values about that of the first parameter.
fn columns(system: &System, model: &Model, settings: &Settings) -> Vec<Trajectory<f64>> {
    let mut work = system.workspace::<f64>(settings);
    let middle = model.parameter_values::<f64>(&[]).first().copied();
    let start = |column: usize| {
        let factor = 1.0 + 0.1 * (column as f64 / COLUMNS as f64 - 0.5);
        let swept: Vec<(usize, f64)> = middle.iter().map(|value| (0, value * factor)).collect();
        let parameters = model.parameter_values::<f64>(&swept);
        let state = model.initial_state(&parameters);
        let time = model.time.map_or(0.0, |index| state[index]);
        let mut trajectory =
            Trajectory::start(system, &mut work, &parameters, time, &state).ok()?;
        trajectory.set_horizon(time + 100.0);
        Some(trajectory)
    };
    // Where a value is no legal one there is no column.
    (0..COLUMNS).filter_map(start).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let backend = match std::env::args().nth(1).as_deref() {
        None | Some("compiled") => Backend::CompiledAtOnce,
        Some("interpreter") => Backend::Interpreter,
        Some(other) => return Err(format!("no backend is called {other:?}").into()),
    };
    let settings = Settings {
        backend,
        ..Settings::default()
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let mut files: Vec<_> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.sort();
    for file in files {
        let model = Model::from_toml(&std::fs::read_to_string(&file)?, "model")?;
        let system = System::new(&model)?;
        let mut work = system.workspace::<f64>(&settings);
        let mut alone = Hash(0);
        for mut trajectory in columns(&system, &model, &settings) {
            let mut told = 0;
            // A step without an occurrence is none of those counted.
            for _ in 0..100 * OCCURRENCES {
                match trajectory.advance_to_horizon(&system, &mut work) {
                    Ok(None) => continue,
                    Ok(Some(Occurrence::Horizon)) | Err(_) => break,
                    Ok(Some(_)) => told += 1,
                }
                if told == OCCURRENCES {
                    break;
                }
            }
            alone.add_end(&trajectory);
        }
        let mut trajectories = columns(&system, &model, &settings);
        let mut told = vec![0; trajectories.len()];
        let visit =
            |index: usize, _: &mut Trajectory<f64>, what: Result<&Occurrence<f64>, FlowError>| {
                if !matches!(what, Ok(what) if *what != Occurrence::Horizon) {
                    return Next::Retire;
                }
                told[index] += 1;
                if told[index] == OCCURRENCES {
                    Next::Retire
                } else {
                    Next::Continue
                }
            };
        let never = AtomicBool::new(false);
        run_fleet(&system, &settings, &[0], &mut trajectories, &never, visit);
        let mut together = Hash(0);
        trajectories.iter().for_each(|end| together.add_end(end));
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        println!("{:016x} {:016x} {name}", alone.0, together.0);
        if alone.0 != together.0 {
            return Err(format!("{name}: lanes differ from trajectories alone").into());
        }
    }
    Ok(())
}
