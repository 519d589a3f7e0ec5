//! `chatter explore`: a page to look, zoom, drag and click.

use super::diagram::threads_of;
use crate::failure::{self, Failure};
use crate::options::ThreadCount;
use crate::terminal;
use chatter_explorer::{Context, Explorer, Limits};
use chatter_work::data_files::DataFiles;
use chatter_work::source::Source;
use clap::Args;
use std::process::{Command, Stdio};

const EXAMPLES: &str = "\
EXAMPLES
  chatter explore pressure_relief_valve
  chatter explore my_model.toml
  chatter explore impact_oscillator --no-open --port 8000

A page in the browser shows the model's text, an orbit diagram that sharpens at every zoom, and for any value that is
clicked the motion: history, phase portrait, return map, impacts, and the mechanism where the model has a [drawing]. Each
view gives its picture, its data, and the command that makes the same. The page is served by this program, to this machine
alone, under an address that nobody can guess, until Ctrl-C.";

/// Open a page on which a model can be explored
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL", default_value = "pressure_relief_valve")]
    model: String,

    /// Listen at this port [default: a free one]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,

    /// Print the address only, and open no browser
    #[arg(long)]
    no_open: bool,

    /// How many threads compute [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    threads: Option<ThreadCount>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let source = Source::named(&arguments.model)?;
    let model = (source.name.clone(), source.text.clone());
    // What is wrong with it is shown on the page, where it can be mended.
    let files = source
        .load()
        .map_or_else(|_| DataFiles::new(), |loaded| loaded.data_files);
    let context = Context {
        model,
        files,
        threads: threads_of(arguments.threads),
    };
    let explorer = Explorer::bind(arguments.port, context, Limits::default()).map_err(|error| {
        let failure = Failure::input(format!("cannot listen at port {}: {error}", arguments.port));
        failure.help("leave out --port, and a free one is taken")
    })?;
    let address = explorer.address();
    terminal::end_on_interrupt();
    terminal::print(&format!("{address}\n")).map_err(Failure::Output)?;
    terminal::remark("the explorer runs until Ctrl-C");
    if !arguments.no_open && !opened(&address) {
        terminal::remark("no browser could be opened: open the address above in one");
    }
    explorer.serve();
    Ok(failure::SUCCESS)
}

/// Asks the system to show an address.
fn opened(address: &str) -> bool {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(before).arg(address).stdin(Stdio::null());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}
