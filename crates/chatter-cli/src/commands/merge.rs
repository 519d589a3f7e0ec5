//! `chatter merge`: one diagram, or the branches of one search, from the journals of shares.

use super::continuation::{Shown, answer};
use super::diagram::{produce, threads_of};
use crate::diagram::{self, Beginning, journal_of};
use crate::failure::Failure;
use crate::options::{FigureFile, TableFile, ThreadCount};
use crate::terminal::Console;
use chatter_work::journals::is_of_branches;
use chatter_work::periodic;
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
EXAMPLES
  chatter merge fig5.*.journal --out fig5.npz
  chatter merge fig5.*.journal --out fig5.npz --plot fig5.png

Journals come from `chatter diagram … --shard NUMBER/COUNT`, or from `chatter continue … --all P --shard NUMBER/COUNT`. Those of
another diagram, or of other branches, are refused; what none of them has is
computed. The file is the one that a single machine would have written, to the bit. Journals stay.";

/// Put shares of an orbit diagram or of branches together that several machines have computed
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The journals of the shares
    #[arg(value_name = "JOURNAL", required = true)]
    journals: Vec<PathBuf>,

    /// Write the tables, .npz or .csv
    #[arg(long, value_name = "FILE")]
    out: TableFile,

    /// Draw the diagram, .png, .svg or .pdf
    #[arg(long, value_name = "FILE")]
    plot: Option<FigureFile>,

    /// How many threads compute what is missing [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    threads: Option<ThreadCount>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let out = &arguments.out.0;
    let plot = arguments.plot.as_ref().map(|file| file.0.clone());
    if is_of_branches(&arguments.journals) {
        let (job, log) = periodic::merge(&arguments.journals, out, &Console::new())?;
        let shown = Shown::plain(plot.as_deref());
        return answer(&job, Some(out), periodic::Beginning::Open(log), &shown);
    }
    let order = diagram::merge(&arguments.journals, (out, plot), &Console::new())?;
    let beginning = Beginning::At(journal_of(out));
    produce(&order, beginning, threads_of(arguments.threads), false)
}
