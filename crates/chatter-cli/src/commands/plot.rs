//! `chatter plot`: a figure of a result that was computed before.

use crate::diagram::picture::{self, Words};
use crate::diagram::{Show, Stored, Subject, View, Zoom};
use crate::failure::{self, Failure};
use crate::options::{FigureFile, ShearOption, SpanOption};
use crate::terminal::{self, Waiting};
use crate::universal;
use chatter_figures::Axis;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const EXAMPLES: &str = "\
EXAMPLES
  chatter plot fig5.npz --zoom q=0.0203:0.0206 --out fig6.pdf
  chatter plot fig5.npz --zoom q=0.0203:0.0206 --zoom y2=-0.006:-0.003 --out detail.png
  chatter plot fig5.npz --shear auto --out sheared.svg
  chatter plot map.npz --show impacts --out impacts.png";

/// Draw an orbit diagram that was written to an NPZ file
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The NPZ file
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// The figure, .png, .svg or .pdf
    #[arg(long, value_name = "FILE")]
    out: FigureFile,

    /// Show a part of an axis only: of a swept parameter or of an observed quantity (sheared, if it is)
    #[arg(long, value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    zoom: Vec<SpanOption>,

    /// Show this observed quantity only
    #[arg(long, value_name = "NAME")]
    observe: Vec<String>,

    /// Subtract a multiple of the parameter from the vertical axis: this slope, or `auto` for the one that makes the
    /// diagram level
    #[arg(long, value_name = "SLOPE", allow_hyphen_values = true)]
    shear: Option<ShearOption>,

    /// What a map over two parameters shows [default: period; of initial values, attractor]
    #[arg(long, value_name = "WHAT")]
    show: Option<ShowOption>,
}

/// What a map over two parameters shows.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShowOption {
    Period,
    Impacts,
    Exponent,
    Attractor,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    terminal::end_on_interrupt();
    let waiting = Waiting::new("drawing");
    let mut stored = Stored::open(&arguments.file)?;
    let mut view = View {
        zooms: Vec::new(),
        shear: arguments.shear.map(|shear| shear.0),
        observe: arguments.observe.clone(),
        show: match arguments.show {
            None => None,
            Some(ShowOption::Period) => Some(Show::Period),
            Some(ShowOption::Impacts) => Some(Show::Impacts),
            Some(ShowOption::Exponent) => Some(Show::Exponent),
            Some(ShowOption::Attractor) => Some(Show::Attractor),
        },
    };
    let zoom = |span: &SpanOption, (from, to)| Zoom {
        name: span.name.clone(),
        from,
        to,
    };
    let drawn = match stored.subject.clone() {
        Subject::Flow(job) => {
            let mut ready = job.prepare(&stored.model_text)?;
            stored.check(&ready.sweep)?;
            for span in &arguments.zoom {
                view.zooms
                    .push(zoom(span, span.ends(&mut ready.model, "--zoom")?));
            }
            let words = Words {
                title: job.title(&ready.model),
                origin: &job.model,
                version: &job.version,
                axis: &|name| picture::axis(&ready.model, name),
            };
            picture::draw(&words, &ready.sweep, &mut stored, &view)?
        }
        Subject::Universal(job) => {
            let (_, sweep) = job.prepare()?;
            stored.check(&sweep)?;
            for span in &arguments.zoom {
                view.zooms.push(zoom(span, span.plain_ends("--zoom")?));
            }
            let words = Words {
                title: &job.title(),
                origin: &stored.model_text.clone(),
                version: &job.version,
                axis: &|name| Axis::new(universal::picture::label(name)),
            };
            picture::draw(&words, &sweep, &mut stored, &view)?
        }
    };
    let path = &arguments.out.0;
    let outcome = drawn.figure.write(path);
    outcome.map_err(|error| Failure::Output(error.to_string()))?;
    drop(waiting);
    let mut text = format!("wrote {}\n", path.display());
    if drawn.slanted {
        text += picture::SLANTED;
    }
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}
