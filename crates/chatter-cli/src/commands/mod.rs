//! The commands, one file each.

mod check;
mod models;
mod simulate;

use crate::failure::Failure;
use clap::Subcommand;

/// What can be asked for.
#[derive(Subcommand, Debug)]
pub enum Command {
    Simulate(Box<simulate::Arguments>),
    Check(check::Arguments),
    Models(models::Arguments),
}

impl Command {
    /// Does it; gives the exit code.
    pub fn run(&self) -> Result<u8, Failure> {
        match self {
            Self::Simulate(arguments) => simulate::run(arguments),
            Self::Check(arguments) => check::run(arguments),
            Self::Models(arguments) => models::run(arguments),
        }
    }
}
