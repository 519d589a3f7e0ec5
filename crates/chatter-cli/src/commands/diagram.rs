//! `chatter diagram`: what orbits settle to, for many parameter values.

use crate::diagram::{Job, Order, Show, Store, View, account, journal_of, picture, table};
use crate::failure::{self, Failure};
use crate::options::{
    Assignment, AtOption, Count, FigureFile, Initial, Loaded, ModelOptions, ObserveOption,
    Quantity, ShearOption, SpanOption, StartOption, SweepOption, TableFile,
};
use crate::terminal::{self, Progress, Style};
use chatter::analysis::diagram::{
    Bounds, Ending, Executor, Exponent, Observed, Record, Spec, Standing, Start, Sweep, Threads,
    run as compute,
};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use clap::{Args, ValueEnum};
use core::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
EXAMPLES
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:4000 --section closing --observe y2 \\
      --transient 300 --keep 200 --start carry --out fig5.npz --plot fig5.png
  chatter diagram --resume fig5.npz
  chatter diagram impact_oscillator --sweep omega=2.5:3.5:2000 --period '2*pi/omega' --observe v --plot strobe.pdf
  chatter diagram bouncing_ball_on_table --sweep Gamma=1.2:4:1000 --at impact --observe v --start random:5 \\
      --box v=0:1 --out ball.csv
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:400 --sweep r=0.7:0.9:300 --observe y2 \\
      --out map.npz --plot map.png

TABLE
  For each parameter value (and random start): the swept parameters, outcome (periodic, chaotic, unsettled,
  complete_chatter, left_domain, no_return, no_start, undetermined), period, impacts_per_return, with --exponent the
  largest Lyapunov exponent per sample, start (fresh, carried, random). For each sample: column (which row of the first
  table, from 0) and each observed quantity. NPZ holds all in one file: numpy.load('fig5.npz')['y2'].

JOURNAL
  What is done is kept in FILE.journal beside the output until all is done; Ctrl-C or a crash loses at most what was in
  flight. The result of a resumed run is the same to the bit.";

/// Sweep a parameter and sample what orbits settle to: periodic windows, chaos, chatter
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL", required_unless_present = "resume")]
    model: Option<String>,

    /// Go on with the diagram that was to be written to this file
    #[arg(long, value_name = "FILE", exclusive = false, conflicts_with_all = ["model", "sweep", "observe", "out", "plot"])]
    resume: Option<PathBuf>,

    /// Give a parameter another value: a number or an expression in other parameters
    #[arg(long = "set", value_name = "NAME=EXPR")]
    set: Vec<Assignment>,

    #[command(flatten)]
    initial: Initial,

    /// Sweep a parameter over equally spaced values, both ends included; `:log` after COUNT spaces them by equal ratios.
    /// Given twice, a map over both parameters
    #[arg(
        long,
        value_name = "NAME=FROM:TO:COUNT",
        required_unless_present = "resume"
    )]
    sweep: Vec<SweepOption>,

    /// Sample at the crossings of this section in its direction. Without it, --at and --period: the model's only section
    #[arg(long, value_name = "NAME", conflicts_with_all = ["at", "period"])]
    section: Option<String>,

    /// Sample at each event: KIND is impact, accumulation, release, graze or section, NAME the contact or section
    #[arg(long, value_name = "KIND[:NAME]", conflicts_with = "period")]
    at: Option<AtOption>,

    /// Sample stroboscopically, with this period: a number or an expression in parameters
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    period: Option<String>,

    /// Sample at every N-th of these [default: 1]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    every: Option<Count>,

    /// What is sampled, an expression in states, parameters and what happened since the sample before: impacts,
    /// accumulations, return_time, flight_time (of the last flight). Can be given several times
    #[arg(
        long,
        value_name = "[NAME=]EXPR",
        required_unless_present = "resume",
        allow_hyphen_values = true
    )]
    observe: Vec<ObserveOption>,

    /// Samples passed over before any is kept [default: 300]
    #[arg(long, value_name = "N")]
    transient: Option<u64>,

    /// Samples kept for each orbit [default: 200]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    keep: Option<Count>,

    /// Where orbits start: `fresh` at the initial state, `carry` where the orbit at the next lower parameter value
    /// ended, `carry-down` at the next higher, `random:COUNT` at so many random points of --box [default: fresh]
    #[arg(long, value_name = "START")]
    start: Option<StartOption>,

    /// Carry the state through so many values, then start afresh; such chunks are computed side by side
    /// [default: a 256th of the values, from 4 to 64]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    chunk: Option<Count>,

    /// Draw this state at random between two bounds; other states start at their initial values
    #[arg(long = "box", value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    bounds: Vec<SpanOption>,

    /// Another seed, other random starts [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Look for periods up to this one [default: 64]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    longest_period: Option<Count>,

    /// Samples a period apart may differ by this much of the largest [default: 1e-8]
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    period_tolerance: Option<Quantity>,

    /// Compute the largest Lyapunov exponent too
    #[arg(long)]
    exponent: bool,

    /// Keep `samples`, or only the `classes` of orbits [default: samples, with two sweeps classes]
    #[arg(long, value_name = "WHAT")]
    record: Option<RecordOption>,

    /// Give up a return that takes longer than this time [default: 10000]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    longest_return: Option<Quantity>,

    /// Give up a return that takes more impacts than this [default: 100000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    most_impacts: Option<Count>,

    /// Relative error allowed in one step; rounding error without it
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    tolerance: Option<Quantity>,

    /// Write the tables, .npz or .csv
    #[arg(long, value_name = "FILE")]
    out: Option<TableFile>,

    /// Draw the diagram, .png, .svg or .pdf
    #[arg(long, value_name = "FILE")]
    plot: Option<FigureFile>,

    /// Subtract a multiple of the parameter from the vertical axis of the figure: this slope, or `auto` for the one that
    /// makes the diagram level
    #[arg(
        long,
        value_name = "SLOPE",
        requires = "plot",
        allow_hyphen_values = true
    )]
    shear: Option<ShearOption>,

    /// How many threads compute [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    threads: Option<Count>,
}

/// What is kept of orbits.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum RecordOption {
    Samples,
    Classes,
}

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
            let journal = target.map(|path| journal_of(path)).ok_or_else(|| {
                Failure::input("the diagram goes nowhere")
                    .help("write it with --out FILE.npz or --plot FILE.png")
            })?;
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
    let threads = match arguments.threads {
        Some(Count(count)) => Threads::new(usize::try_from(count).unwrap_or(usize::MAX)),
        None => Threads::available(),
    };
    produce(&order, &journal, threads)
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

/// What the command line asks for.
fn order(arguments: &Arguments) -> Result<Order, Failure> {
    let name = arguments.model.clone().unwrap_or_default();
    let options = ModelOptions {
        model: name.clone(),
        set: arguments.set.clone(),
    };
    let Loaded { mut model, text } = options.load()?;
    arguments.initial.apply(&mut model)?;
    let pairs = |assignments: &[Assignment]| assignments.iter().map(Assignment::pair).collect();
    let job = Job {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: name,
        set: pairs(&arguments.set),
        initial: pairs(&arguments.initial.initial),
        returns: returns(arguments, &mut model)?,
        diagram: specification(arguments, &mut model)?,
    };
    Ok(Order {
        job,
        model_text: text,
        out: arguments.out.as_ref().map(|file| file.0.clone()),
        plot: arguments.plot.as_ref().map(|file| file.0.clone()),
        shear: arguments.shear.map(|shear| shear.0),
    })
}

fn returns(arguments: &Arguments, model: &mut Model) -> Result<ReturnSpec, Failure> {
    let section = |name: &str| Sampling::Event {
        kind: EventKind::Section,
        at: Some(name.to_owned()),
    };
    let sampling = match (&arguments.section, &arguments.at, &arguments.period) {
        (Some(name), ..) => section(name),
        (_, Some(at), _) => Sampling::Event {
            kind: at.kind,
            at: at.name.clone(),
        },
        (.., Some(period)) => Sampling::Stroboscopic {
            period: period.clone(),
        },
        (None, None, None) => match &model.sections[..] {
            [only] => section(&only.name),
            sections => {
                let names: Vec<&str> = sections.iter().map(|section| &*section.name).collect();
                let known = match &names[..] {
                    [] => "it has none".to_owned(),
                    names => format!("it has `{}`", names.join("`, `")),
                };
                return Err(Failure::input(format!(
                    "where are orbits to be sampled? The model has no single section to choose: {known}"
                ))
                .help("name a section with --section NAME, an event with --at impact, or a --period"));
            }
        },
    };
    let mut spec = ReturnSpec::new(sampling);
    if let Some(longest) = &arguments.longest_return {
        spec.longest_return = longest.value(model, "--longest-return")?.high();
    }
    if let Some(Count(most)) = arguments.most_impacts {
        spec.most_impacts = most;
    }
    if let Some(tolerance) = &arguments.tolerance {
        spec.tolerance = tolerance.value(model, "--tolerance")?.high();
    }
    Ok(spec)
}

/// Passed over and kept unless told otherwise.
const TRANSIENT: u64 = 300;
const KEEP: u64 = 200;

fn specification(arguments: &Arguments, model: &mut Model) -> Result<Spec, Failure> {
    let mut sweeps = Vec::new();
    for sweep in &arguments.sweep {
        sweeps.push(sweep.range(model)?);
    }
    let mut bounds = Vec::new();
    for span in &arguments.bounds {
        let (from, to) = span.ends(model, "--box")?;
        let coordinate = span.name.clone();
        bounds.push(Bounds {
            coordinate,
            from,
            to,
        });
    }
    let random = matches!(arguments.start, Some(StartOption::Random(_)));
    if !random && (!bounds.is_empty() || arguments.seed.is_some()) {
        return Err(
            Failure::input("--box and --seed are about random starts, and there are none")
                .help("add --start random:COUNT"),
        );
    }
    if random && bounds.is_empty() {
        return Err(
            Failure::input("random starts need bounds to be drawn between")
                .help("add --box NAME=FROM:TO, once for each state that is to be drawn"),
        );
    }
    let start = match arguments.start {
        None | Some(StartOption::Fresh) => Start::Fresh,
        Some(StartOption::CarryUp) => Start::CarryUp,
        Some(StartOption::CarryDown) => Start::CarryDown,
        Some(StartOption::Random(count)) => Start::Random {
            count,
            seed: arguments.seed.unwrap_or(0),
            bounds,
        },
    };
    let tolerance = match &arguments.period_tolerance {
        Some(tolerance) => tolerance.value(model, "--period-tolerance")?.high(),
        None => Spec::PERIOD_TOLERANCE,
    };
    let record = match arguments.record {
        Some(RecordOption::Samples) => Record::Samples,
        Some(RecordOption::Classes) => Record::Classes,
        None if sweeps.len() > 1 => Record::Classes,
        None => Record::Samples,
    };
    let number = |count: Option<Count>, usual: u64| count.map_or(usual, |count| count.0);
    let observe: Vec<Observed> = arguments.observe.iter().map(|one| one.0.clone()).collect();
    Ok(Spec {
        sweeps,
        observe,
        transient: arguments.transient.unwrap_or(TRANSIENT),
        keep: number(arguments.keep, KEEP),
        every: number(arguments.every, 1),
        start,
        chunk: arguments.chunk.map(|count| count.0),
        longest_period: number(arguments.longest_period, Spec::LONGEST_PERIOD),
        period_tolerance: tolerance,
        record,
        exponent: if arguments.exponent {
            Exponent::Largest
        } else {
            Exponent::Skip
        },
    })
}

/// Computes what is missing, then writes everything.
fn produce(order: &Order, journal: &Path, threads: Threads) -> Result<u8, Failure> {
    let job = &order.job;
    let ready = job.prepare(&order.model_text)?;
    if order.out.is_some() {
        table::check_names(&ready.sweep)?;
    }
    if order.plot.is_some()
        && ready.sweep.spec().sweeps.len() == 1
        && job.diagram.record == Record::Classes
    {
        return Err(Failure::input("a diagram without samples cannot be drawn")
            .help("leave out --record classes, or --plot"));
    }
    let (mut store, standing) = open(order, journal, &ready.sweep)?;
    let ending = fill(&ready.map, &ready.sweep, &mut store, &standing, threads)?;
    if ending == Ending::Stopped {
        let done: u64 = store.counts().values().sum();
        let target = order.out.as_ref().or(order.plot.as_ref());
        terminal::remark(&format!(
            "stopped with {done} of {} orbits done; go on with: chatter diagram --resume {}",
            ready.sweep.rows(),
            target.map_or_else(String::new, |path| path.display().to_string())
        ));
        return Ok(failure::INTERRUPTED);
    }
    let mut written = Vec::new();
    let mut slanted = false;
    if let Some(path) = &order.out {
        written.extend(table::write(
            order,
            &ready.model,
            &ready.sweep,
            &mut store,
            path,
        )?);
    }
    if let Some(path) = &order.plot {
        let view = View {
            shear: order.shear,
            show: Show::Period,
            ..View::default()
        };
        let picture = picture::draw(job, &ready.model, &ready.sweep, &mut store, &view)?;
        let outcome = picture.figure.write(path);
        outcome.map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
        slanted = picture.slanted;
    }
    let style = Style::of_stdout();
    let mut text = account::account(job, &ready.model, &ready.sweep, store.counts(), style);
    store.remove()?;
    for path in &written {
        text += &format!("wrote {}\n", path.display());
    }
    if slanted {
        text += picture::SLANTED;
    }
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// The journal: the one that is there if it is about the same diagram, else a new one.
fn open(order: &Order, journal: &Path, sweep: &Sweep) -> Result<(Store, Standing), Failure> {
    if !journal.exists() {
        return Ok((Store::create(journal, order, sweep)?, Standing::default()));
    }
    let found = Store::order_of(journal)?;
    let same_model = found.model_text == order.model_text && found.job.model == order.job.model;
    if found.job != order.job || !same_model {
        let difference = if same_model {
            found.job.difference(&order.job)
        } else {
            "another model"
        };
        return Err(Failure::input(format!(
            "`{}` holds an unfinished diagram with {difference}",
            journal.display()
        ))
        .help("finish it with --resume, delete it, or write this diagram to another file"));
    }
    let (store, standing) = Store::open(journal, sweep)?;
    terminal::remark(&format!(
        "going on from `{}`: {} of {} orbits are done",
        journal.display(),
        standing.rows(),
        sweep.rows()
    ));
    Ok((store, standing))
}

fn fill(
    map: &ReturnMap,
    sweep: &Sweep,
    store: &mut Store,
    standing: &Standing,
    threads: Threads,
) -> Result<Ending, Failure> {
    terminal::catch_interrupts();
    let mut progress = Progress::new();
    let began = Instant::now();
    let spec = sweep.spec();
    let returns = (spec.transient + spec.keep) * spec.every;
    let mut broken = None;
    let executor: &dyn Executor = &threads;
    let mut done = standing.rows();
    let ending = compute(
        map,
        sweep,
        standing,
        executor,
        terminal::interrupt_flag(),
        &mut |row| {
            if let Err(error) = store.append(&row) {
                broken = Some(Failure::Output(error.to_string()));
                return ControlFlow::Break(());
            }
            done += 1;
            progress.show(done as f64 / sweep.rows() as f64, || {
                let rate =
                    ((done - standing.rows()) * returns) as f64 / began.elapsed().as_secs_f64();
                format!("{done} of {} orbits, {rate:.0} returns/s", sweep.rows())
            });
            ControlFlow::Continue(())
        },
    );
    progress.finish();
    match broken {
        Some(failure) => Err(failure),
        None => Ok(ending),
    }
}
