//! `chatter orbit`: periodic orbits.

use super::going_on;
use crate::accounts::periodic::orbits as account;
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{Count, Loaded, PeriodicOptions, Precision};
use crate::terminal::{self, Progress, Style, Waiting};
use chatter::analysis::periodic::{Orbit, Search, Spec, all, settled};
use chatter::model::Model;
use chatter_work::periodic::{Subject, orbit_document, refused};
use clap::Args;
use std::time::Instant;

const EXAMPLES: &str = "\
EXAMPLES
  chatter orbit pressure_relief_valve --set q=0.0203
  chatter orbit pressure_relief_valve --set q=0.0195 --json
  chatter orbit impact_oscillator --set omega=2.8 --all 3 --starts 500

The orbit that the motion settles to is closed by Newton's method on the states after its events and the times between
them, in numbers of thirty digits. Multipliers are those of the return map: all but the trivial one, which an autonomous
system has along the flow and which shows how well derivatives are known. Complete chatter, and whatever holds the state
on a surface, forgets directions: their multipliers are zero. Margins are what vanishes where the sequence of events
changes: the rate of the slowest impact, the least gap of the flights, the jerk at release.

JSON
  orbit: period, start and section (states by name), section_name, events (as in `simulate`, times from the start),
  impacts (null where infinitely many), multipliers (re and im, by size), trivial_multiplier (null where there is none),
  residual, error, stable, margins (kind, where, time, value). With --all: orbits, a list of these.";

/// Find periodic orbits, stable or not, with their multipliers
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    orbits: PeriodicOptions,

    /// Find every orbit of up to so many periods of the forcing, or returns to the section, stable or not
    #[arg(long, value_name = "PERIODS", allow_hyphen_values = true)]
    all: Option<Count>,

    /// Starts of that search [default: 200]
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    starts: Option<Count>,

    /// Draw other starts
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    seed: Option<u64>,

    /// Digits of the numbers in the output, up to 30
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    digits: Option<Precision>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// Starts of a search.
const STARTS: u64 = 200;

/// Longer cycles take too long to be found by chance.
const MOST_PERIODS: u64 = 64;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let (Loaded { model, text, .. }, spec) = arguments.orbits.load(&[])?;
    terminal::catch_interrupts();
    let orbits = match &arguments.all {
        Some(periods) => search(arguments, &model, &spec, *periods)?,
        None => {
            let waiting = Waiting::new("following the motion until it settles");
            let found = settled(&model, &spec, &mut |_| going_on());
            drop(waiting);
            vec![found.map_err(|error| refused(&error, &model))?]
        }
    };
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    let subject = Subject {
        model: &model,
        source: &arguments.orbits.model.model,
        text: &text,
        monitors: &[],
        free: Vec::new(),
        digits,
    };
    let answer = if arguments.json {
        terminal::Answer::Document(orbit_document(&subject, &orbits, arguments.all.is_some())?)
    } else {
        terminal::Answer::Text(account(&subject, &orbits, Style::of_stdout())?)
    };
    answer.print()?;
    Ok(failure::SUCCESS)
}

fn search(
    arguments: &Arguments,
    model: &Model,
    spec: &Spec,
    periods: Count,
) -> Result<Vec<Orbit>, Failure> {
    if periods.0 == 0 || periods.0 > MOST_PERIODS {
        return Err(Failure::input(format!(
            "--all {}: expected a number of periods from 1 to {MOST_PERIODS}",
            periods.0
        )));
    }
    let starts = arguments.starts.map_or(STARTS, |count| count.0);
    let what = Search {
        periods: periods.0 as usize,
        starts,
        seed: arguments.seed.unwrap_or(0),
    };
    let mut progress = Progress::new();
    let began = Instant::now();
    let found = all(model, spec, &what, &mut |reached| {
        progress.show(reached.starts as f64 / starts as f64, || {
            let rate = reached.starts as f64 / began.elapsed().as_secs_f64();
            format!("{} orbits, {rate:.0} starts/s", reached.orbits)
        });
        going_on()
    });
    progress.finish();
    found.map_err(|error| refused(&error, model))
}
