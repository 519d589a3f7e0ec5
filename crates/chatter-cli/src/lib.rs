//! The `chatter` command, as a library: other faces, such as the Python package, carry it without a second program.

mod accounts;
mod aligned;
mod commands;
mod failure;
mod options;
mod parallel;
mod reproduction;
mod resume;
mod terminal;

use chatter_work::{
    border, diagram, json, model_tables, named, numbers, shipped, simulation, universal,
};
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

const EXAMPLES: &str = "\
EXAMPLES
  chatter reproduce
  chatter models
  chatter explore pressure_relief_valve
  chatter simulate pressure_relief_valve --set q=0.0195 --until 40 --plot valve.svg
  chatter simulate my_model.toml --json
  chatter check my_model.toml
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:4000 --section closing --observe y2 --plot fig5.png
  chatter orbit pressure_relief_valve --set q=0.0203
  chatter continue pressure_relief_valve --sweep q=0.0195:0.0235 --plot branch.pdf
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

/// Does what the command line of this process asks for; gives the exit code.
pub fn main() -> ExitCode {
    run(std::env::args_os()).into()
}

/// Does what these arguments ask for, of which the first is the program's name; gives the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => return answer(&error),
    };
    if let Err(failure) = chatter_work::backend::choose() {
        return failure::report(&failure);
    }
    match arguments.command.run() {
        Ok(code) => code,
        Err(failure) => failure::report(&failure),
    }
}

/// Help, the version, or what is wrong with the command line.
fn answer(error: &clap::Error) -> u8 {
    let text = error.render().to_string();
    if error.use_stderr() {
        terminal::remark(text.trim_end());
        return failure::BAD_INPUT;
    }
    match terminal::print(&text) {
        Ok(()) => failure::SUCCESS,
        Err(message) => failure::report(&failure::Failure::Output(message)),
    }
}
