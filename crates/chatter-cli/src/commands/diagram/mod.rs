//! `chatter diagram`: what orbits settle to, for many parameter values.

mod arguments;
mod order;
mod produce;

pub use arguments::Arguments;

use crate::diagram::{Store, journal_of};
use crate::failure::{self, Failure};
use crate::options::ThreadCount;
use crate::terminal;
use chatter::analysis::diagram::Threads;
use order::order;
use produce::{produce, produce_document};
use std::path::Path;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let (order, journal) = match &arguments.resume {
        Some(path) => {
            let journal = journal_of(path);
            if !journal.exists() {
                return nothing_to_resume(path, &journal);
            }
            (Store::order_of(&journal)?, journal)
        }
        None => {
            let order = order(arguments)?;
            let target = order.out.as_ref().or(order.plot.as_ref());
            let Some(journal) = target.map(|path| journal_of(path)) else {
                if arguments.json {
                    return produce_document(&order, threads(arguments));
                }
                return Err(Failure::input("the diagram goes nowhere").help(
                    "write it with --out FILE.npz or --plot FILE.png, or print it with --json",
                ));
            };
            (order, journal)
        }
    };
    let version = env!("CARGO_PKG_VERSION");
    if order.job.version != version {
        return Err(Failure::input(format!(
            "`{}` was begun by chatter {}; this is chatter {version}, whose results may differ in their last digits",
            journal.display(),
            order.job.version
        ))
        .help(format!(
            "go on with the version that began it, or delete `{}` and compute the diagram anew",
            journal.display()
        )));
    }
    produce(&order, &journal, threads(arguments), arguments.json)
}

fn threads(arguments: &Arguments) -> Threads {
    match arguments.threads {
        Some(ThreadCount(count)) => Threads::new(count),
        None => Threads::available(),
    }
}

fn nothing_to_resume(path: &Path, journal: &Path) -> Result<u8, Failure> {
    if path.exists() {
        let text = format!(
            "{} is complete: there is nothing to resume\n",
            path.display()
        );
        terminal::print(&text).map_err(Failure::Output)?;
        return Ok(failure::SUCCESS);
    }
    Err(Failure::input(format!(
        "there is nothing to resume: no `{}`",
        journal.display()
    ))
    .help("--resume takes the name that was given to --out, or to --plot where there was no --out"))
}
