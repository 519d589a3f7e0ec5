//! The `chatter` command.

mod aligned;
mod border;
mod commands;
mod diagram;
mod failure;
mod json;
mod named;
mod numbers;
mod options;
mod parallel;
mod reproduction;
mod shipped;
mod simulation;
mod terminal;
mod universal;

use clap::Parser;
use std::process::ExitCode;

const EXAMPLES: &str = "\
EXAMPLES
  chatter reproduce
  chatter models
  chatter simulate pressure_relief_valve --set q=0.0195 --until 40 --plot valve.svg
  chatter simulate my_model.toml --json
  chatter check my_model.toml
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:4000 --section closing --observe y2 --plot fig5.png
  chatter border pressure_relief_valve --parameter q --near 0.02
  chatter universal --restitution 0.8

Each command has a --help of its own. Exit codes: 0 done, 1 the computation could not be finished, 2 wrong input,
130 broken off by Ctrl-C.";

/// Mechanical systems with impacts: trajectories through chatter, contact and release, from equations in a text file
#[derive(Parser, Debug)]
#[command(name = "chatter", version, after_help = EXAMPLES, disable_help_subcommand = true, term_width = 120)]
struct Arguments {
    #[command(subcommand)]
    command: commands::Command,
}

fn main() -> ExitCode {
    match Arguments::parse().command.run() {
        Ok(code) => code.into(),
        Err(failure) => failure.report(),
    }
}
