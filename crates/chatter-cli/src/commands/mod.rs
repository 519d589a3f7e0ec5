//! The commands, one file each.

pub mod border;
mod check;
mod continuation;
mod diagram;
mod explore;
mod exponents;
mod merge;
mod models;
mod orbit;
mod plot;
mod reproduce;
mod simulate;
mod universal;

use crate::failure::Failure;
use clap::Subcommand;

/// What can be asked for.
#[derive(Subcommand, Debug)]
pub enum Command {
    Simulate(Box<simulate::Arguments>),
    Diagram(Box<diagram::Arguments>),
    Merge(merge::Arguments),
    Plot(plot::Arguments),
    Check(check::Arguments),
    Orbit(Box<orbit::Arguments>),
    Continue(Box<continuation::Arguments>),
    Exponents(Box<exponents::Arguments>),
    Border(Box<border::Arguments>),
    Universal(Box<universal::Arguments>),
    Explore(explore::Arguments),
    Reproduce(reproduce::Arguments),
    Models(models::Arguments),
}

impl Command {
    /// Does it; gives the exit code.
    pub fn run(&self) -> Result<u8, Failure> {
        match self {
            Self::Simulate(arguments) => simulate::run(arguments),
            Self::Diagram(arguments) => diagram::run(arguments),
            Self::Merge(arguments) => merge::run(arguments),
            Self::Plot(arguments) => plot::run(arguments),
            Self::Check(arguments) => check::run(arguments),
            Self::Orbit(arguments) => orbit::run(arguments),
            Self::Continue(arguments) => continuation::run(arguments),
            Self::Exponents(arguments) => exponents::run(arguments),
            Self::Border(arguments) => border::run(arguments),
            Self::Explore(arguments) => explore::run(arguments),
            Self::Reproduce(arguments) => reproduce::run(arguments),
            Self::Universal(arguments) => universal::run(arguments),
            Self::Models(arguments) => models::run(arguments),
        }
    }
}
