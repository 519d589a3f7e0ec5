//! `chatter models`: what comes with the program.

use crate::failure::{self, Failure};
use crate::{shipped, terminal};
use chatter::model::Model;
use clap::Args;

const EXAMPLES: &str = "\
EXAMPLES
  chatter models
  chatter models bouncing_ball
  chatter models bouncing_ball > my_model.toml     a start for a model of your own";

/// List the shipped models, or print the file of one
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Print the file of this model
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let text = match &arguments.name {
        Some(name) => file_of(name)?.to_owned(),
        None => list(),
    };
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn file_of(name: &str) -> Result<&'static str, Failure> {
    match shipped::find(name) {
        Some(shipped) => Ok(shipped.text),
        None => {
            let failure = Failure::input(format!("there is no shipped model called `{name}`"));
            Err(match shipped::suggest(name) {
                Some(name) => failure.did_you_mean(Some(name)),
                None => failure.help("`chatter models` lists them"),
            })
        }
    }
}

fn list() -> String {
    let width = shipped::all()
        .map(|shipped| shipped.name.len())
        .max()
        .unwrap_or(0);
    let mut text = String::new();
    for shipped in shipped::all() {
        let title = Model::from_toml(shipped.text, shipped.name)
            .ok()
            .and_then(|model| model.title)
            .unwrap_or_default();
        text += &format!("{:width$}  {title}\n", shipped.name);
    }
    text
}
