//! `chatter plot`: a figure of a result that was computed before.

use crate::diagram::picture::{self, Picture, Words};
use crate::diagram::{Job, Order, Show, Stored, Subject, View, Zoom, produce_in_memory};
use crate::failure::{self, Failure};
use crate::options::{FigureFile, ShearOption, SpanOption};
use crate::terminal::{self, Console};
use crate::universal::{self, UniversalJob};
use chatter::analysis::diagram::{Sweep, Threads};
use chatter_figures::Axis;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
EXAMPLES
  chatter plot fig5.npz --zoom q=0.0203:0.0206 --out fig6.pdf
  chatter plot fig5.npz --zoom q=0.0203:0.0206 --zoom y2=-0.006:-0.003 --out detail.png
  chatter plot fig5.npz --zoom q=0.02033:0.02035 --recompute --out fine.png
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

    /// Compute the diagram again over the parts of the parameters' axes that are shown, in as many values: where only few
    /// of those in the file lie there
    #[arg(long, requires = "zoom")]
    recompute: bool,

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
    let mut stored = Stored::open(&arguments.file)?;
    let view = View {
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
    let mut drawn = match stored.subject.clone() {
        Subject::Flow(job) => flow(arguments, &job, &mut stored, view)?,
        Subject::Universal(job) => universal(arguments, &job, &mut stored, view)?,
    };
    let path = &arguments.out.0;
    let outcome = drawn.figure.write(path);
    outcome.map_err(|error| Failure::Output(error.to_string()))?;
    let mut text = format!("wrote {}\n", path.display());
    if drawn.slanted {
        text += picture::SLANTED;
    }
    if let Some(few) = drawn.few.take() {
        text += &format!("{few}\n");
    }
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn check(arguments: &Arguments, sweep: &Sweep, view: &View) -> Result<(), Failure> {
    picture::check(sweep, view)?;
    if arguments.recompute && picture::zoomed(sweep.spec(), view) == *sweep.spec() {
        return Err(Failure::input(
            "--recompute computes the same again: no part of a swept parameter is shown alone",
        )
        .help("add --zoom NAME=FROM:TO with the name of a swept parameter"));
    }
    Ok(())
}

fn zoom(span: &SpanOption, (from, to): (f64, f64)) -> Zoom {
    Zoom {
        name: span.name.clone(),
        from,
        to,
    }
}

fn flow(
    arguments: &Arguments,
    job: &Job,
    stored: &mut Stored,
    mut view: View,
) -> Result<Picture, Failure> {
    let mut ready = job.prepare(&stored.model_text)?;
    stored.check(&ready.sweep)?;
    for span in &arguments.zoom {
        let ends = span.ends(&mut ready.model, "--zoom")?;
        view.zooms.push(zoom(span, ends));
    }
    let words = Words {
        title: job.title(&ready.model),
        origin: &job.model,
        parameters: &picture::parameters(&ready.model, ready.sweep.spec()),
        version: &job.version,
        axis: &|name| picture::axis(&ready.model, name),
    };
    // Before anything is computed.
    check(arguments, &ready.sweep, &view)?;
    if !arguments.recompute {
        return picture::draw(&words, (&ready.sweep, stored), &view, &Console::new());
    }
    let order = Order {
        job: Job {
            diagram: picture::zoomed(ready.sweep.spec(), &view),
            ..job.clone()
        },
        model_text: stored.model_text.clone(),
        out: None,
        plot: None,
        shear: None,
    };
    let (again, rows, complete) = produce_in_memory(&order, Threads::available(), &Console::new())?;
    let mut source = again.source(&rows, complete);
    picture::draw(&words, (&again.sweep, &mut source), &view, &Console::new())
}

fn universal(
    arguments: &Arguments,
    job: &UniversalJob,
    stored: &mut Stored,
    mut view: View,
) -> Result<Picture, Failure> {
    let (_, sweep) = job.prepare()?;
    stored.check(&sweep)?;
    for span in &arguments.zoom {
        view.zooms.push(zoom(span, span.plain_ends("--zoom")?));
    }
    let words = Words {
        title: &job.title(),
        origin: &stored.model_text.clone(),
        parameters: "",
        version: &job.version,
        axis: &|name| Axis::new(universal::picture::label(name)),
    };
    check(arguments, &sweep, &view)?;
    if !arguments.recompute {
        return picture::draw(&words, (&sweep, stored), &view, &Console::new());
    }
    let (map, sweep) = UniversalJob {
        diagram: picture::zoomed(sweep.spec(), &view),
        ..job.clone()
    }
    .prepare()?;
    let folder = arguments
        .out
        .0
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let (_, mut store) = universal::compute(&map, &sweep, folder, &Console::new())?;
    picture::draw(&words, (&sweep, &mut store), &view, &Console::new())
}
