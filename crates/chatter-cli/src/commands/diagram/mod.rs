//! `chatter diagram`: what orbits settle to, for many parameter values.

mod arguments;
mod produce;

pub use arguments::Arguments;

use crate::diagram::{Beginning, Begun, Stored, journal_of, table};
use crate::failure::Failure;
use crate::options::{ShareOption, ThreadCount};
use crate::resume::nothing_to_resume;
use crate::terminal::Console;
use chatter::analysis::diagram::Threads;
use chatter_files::Format;
use chatter_work::source::Source;
pub use produce::produce;
use produce::{produce_document, produce_shard};
use std::io::Read;
use std::path::Path;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let (threads, json) = (threads(arguments), arguments.json);
    let Some(target) = &arguments.resume else {
        let source = Source::named(arguments.model.as_deref().unwrap_or_default())?;
        let order = arguments.request().order(source)?;
        if let (Some(ShareOption(share)), Some(out)) = (arguments.shard, &order.out) {
            return produce_shard(&order, out, share, threads);
        }
        return match order.target().map(journal_of) {
            Some(journal) => produce(&order, Beginning::At(journal), threads, json),
            None if json => produce_document(&order, threads),
            None => Err(Failure::input("the diagram goes nowhere")
                .help("write it with --out FILE.npz or --plot FILE.png, or print it with --json")),
        };
    };
    let Some(begun) = Begun::open(&journal_of(target))? else {
        let takes = "the name that was given to --out, or to --plot where there was no --out";
        return nothing_to_resume(target, is_diagram(target)?, takes);
    };
    begun.of_this_version()?;
    let plot = arguments.plot.as_ref().map(|file| file.0.clone());
    let order = begun.header.clone().order(target, plot, &Console::new())?;
    produce(&order, Beginning::Resumed(Box::new(begun)), threads, json)
}

fn threads(arguments: &Arguments) -> Threads {
    threads_of(arguments.threads)
}

/// So many, else all of the machine.
pub fn threads_of(count: Option<ThreadCount>) -> Threads {
    match count {
        Some(ThreadCount(count)) => Threads::new(count),
        None => Threads::available(),
    }
}

/// Whether a finished diagram stands there.
///
/// # Errors
/// Something else does.
fn is_diagram(target: &Path) -> Result<bool, Failure> {
    let foreign = |why: &str| {
        let target = target.display();
        Err(Failure::input(format!(
            "`{target}` is no orbit diagram: {why}"
        )))
    };
    let format = Format::of_table(target).or_else(|_| Format::of_figure(target));
    match format {
        // The tables of a diagram have names of their own, made from this one.
        Ok(Format::Csv) => {
            let about = std::fs::read_to_string(table::metadata_file(target));
            match about {
                Ok(text) if text.contains(table::SPECIFICATION) => Ok(true),
                _ if target.exists() => foreign("the file of metadata is not beside it"),
                _ => Ok(false),
            }
        }
        _ if !target.exists() => Ok(false),
        Ok(Format::Npz) => Stored::open(target).map(|_| true),
        Ok(figure) => {
            let mut start = Vec::new();
            let read = std::fs::File::open(target)
                .and_then(|file| file.take(SIGNATURE_ROOM).read_to_end(&mut start));
            match read {
                Ok(_) if figure.begins(&start) => Ok(true),
                Ok(_) => foreign("it is not what its name says"),
                Err(error) => foreign(&error.to_string()),
            }
        }
        Err(_) => foreign("one is .npz, .csv, .svg, .png or .pdf"),
    }
}

/// Bytes that tell what a file is.
const SIGNATURE_ROOM: u64 = 64;
