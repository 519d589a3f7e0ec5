//! `chatter orbit`: periodic orbits.

use crate::accounts::periodic::orbits as account;
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{Count, Loaded, PeriodicOptions, Precision, WholeNumber};
use crate::terminal::{self, Console, Style};
use chatter_work::periodic::{Orbits, Subject, find_orbits, orbit_document, search};
use clap::Args;

const EXAMPLES: &str = "\
EXAMPLES
  chatter orbit pressure_relief_valve --set q=0.0203
  chatter orbit pressure_relief_valve --set q=0.0195 --json
  chatter orbit impact_oscillator --set omega=2.8 --all 3 --starts 500

The orbit that the motion settles to is closed by Newton's method on the states after its events and the times between
them, in numbers of thirty digits. Multipliers are those of the return map: all but the trivial one, which an autonomous
system has along the flow and which shows how well derivatives are known. Complete chatter, and whatever holds the state
on a surface, forgets directions: their multipliers are zero. Margins are what vanishes where the sequence of events
changes: the rate of the slowest impact, the least gap of the flights, the least acceleration that a closed contact keeps
from being (least reaction), the least value of the functions of surfaces and events, the jerk at release, and the
coordinate X of a chatter border that is near (negative where chatter is complete).

JSON
  orbit: period, start and section (states by name), section_name, events (as in `simulate`, times from the start),
  impacts (null where infinitely many), multipliers (re and im, by size), trivial_multiplier (null where there is none),
  residual, error, stable, neutral (none outside the unit circle, and some on it as far as they are known), margins
  (kind, where, time, value). With --all: orbits, a list of these.";

/// Find periodic orbits, stable or not, with their multipliers
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    orbits: PeriodicOptions,

    /// Find every orbit of up to so many periods of the forcing, or returns to the section (in a map by events without one, to an event), stable or not
    #[arg(long, value_name = "PERIODS", allow_hyphen_values = true)]
    all: Option<Count>,

    /// Starts of that search [default: 200]
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    starts: Option<Count>,

    /// Draw other starts
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    seed: Option<WholeNumber>,

    /// Digits of the numbers in the output, up to 30
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    digits: Option<Precision>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let (Loaded { model, text, .. }, spec) = arguments.orbits.load(&[])?;
    let search = match &arguments.all {
        Some(periods) => Some(search(
            periods.0,
            arguments.starts.map(|count| count.0),
            arguments.seed.map(|seed| seed.0),
        )?),
        None => None,
    };
    terminal::catch_interrupts();
    let orbits = find_orbits(&model, &Orbits { spec, search }, &Console::new())?;
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
