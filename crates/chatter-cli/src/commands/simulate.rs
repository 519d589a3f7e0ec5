//! `chatter simulate`: one trajectory.

use crate::accounts::simulation::{self as account, Listing};
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{
    AxesOption, Count, FigureFile, Initial, Loaded, ModelOptions, Precision, Quantity, StopOption,
    TableFile, Window,
};
use crate::simulation::picture::Axes;
use crate::simulation::{
    Record, Request, Rows, SampleOption, Subject, document, follow, picture, sentence, start_time,
    verification,
};
use crate::terminal::{self, Console, Printer, Waiting};
use chatter::analysis::simulate::{Outcome, Simulation, Spec, Verification};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use chatter_work::Silent;
use clap::Args;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
EXAMPLES
  chatter simulate pressure_relief_valve --set q=0.0195 --until 40
  chatter simulate pressure_relief_valve --set q=0.0195 --until 40 --plot valve.svg --out valve.npz
  chatter simulate pressure_relief_valve --until 40 --plot valve.png --axes t,y1 --axes y1,y3
  chatter simulate pressure_relief_valve --until 40 --plot rates.svg --axes impact,rate_before
  chatter simulate pressure_relief_valve --until 40 --plot map.svg --axes y2,next:closing
  chatter simulate bouncing_ball --set r=0.9 --json
  chatter simulate bouncing_ball --digits 30
  chatter simulate pressure_relief_valve --set q=0.0203 --until 40 --verify
  chatter simulate impact_oscillator --set omega=2.8 --until '100*2*pi/omega' --sample '2*pi/omega' --out strobe.csv
  chatter simulate pressure_relief_valve --set q=0.0203 --initial y3=9.9 --stop section:closing=10 --events

SEVERAL CONTACTS AT ONE INSTANT
  Collisions are binary, the contact that closes fastest first, until no contact that touches closes any more; closed
  contacts collide like any other. What has no last collision is carried to its limit: an event `cascade`. Where the
  order of collisions changes the result, an event `ambiguity` says so. simultaneous = \"moreau\" at the top of a model
  applies Moreau's law to all touching contacts at once instead.

JSON
  One document: outcome, time, state (by name), counts, events (kind, time, contact or section, state just after the
  event, rate_before and rate_after; for accumulations impacts and the local error of the time), contact_phases,
  parameters, start; sliding and sticking where a surface or friction holds the state at the end. With more than 17 digits each number has a twin in decimals as text, under its name with `_digits`
  at the end. With --verify verification: events (how many agree), event_time_errors, time_error, state_errors, and
  parting where the runs part ways.";

/// Follow one trajectory through flights, impacts, chatter, contact and release
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelOptions,

    #[command(flatten)]
    initial: Initial,

    /// End at this time, a number or an expression in parameters. Without it the run ends when the system is at rest
    /// for ever, else 100 units of time after its start, or with --stop or --impacts after a million
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    until: Option<Quantity>,

    /// End after this many impacts [default: 1000000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    impacts: Option<Count>,

    /// End at the COUNT-th such event. KIND is impact, accumulation, release, graze, section, cascade,
    /// ambiguity, switch, slide, leave, stick, slip or reset; NAME is a contact, or a section after `section:`. `rest` ends the run when the system is at rest for ever
    #[arg(long, value_name = "KIND[:NAME][=COUNT]")]
    stop: Vec<StopOption>,

    /// Relative error allowed in one step, from 0 to below 1; rounding error without it, or where that is larger
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    tolerance: Option<Quantity>,

    /// Digits of the numbers in the output, up to 30; above 17 the whole computation is done with more digits
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    digits: Option<Precision>,

    /// Follow a twin in double-double, too, and say to how many digits the times of events and the state at the end agree:
    /// the errors told with accumulations are local, and leave out what earlier ones have grown to
    #[arg(long)]
    verify: bool,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,

    /// List every event instead of a summary
    #[arg(long, conflicts_with = "json")]
    events: bool,

    /// Write the trajectory as a table, .csv or .npz
    #[arg(long, value_name = "FILE")]
    out: Option<TableFile>,

    /// Rows of the table: `events`, `dense:N` (N a step of the integration, and each event from both sides), or an
    /// interval of time [default: dense:16]
    #[arg(
        long,
        value_name = "ROWS",
        requires = "out",
        allow_hyphen_values = true
    )]
    sample: Option<SampleOption>,

    /// Draw the time histories and the phase portrait, .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    plot: Option<FigureFile>,

    /// Times that the plot shows, all without it
    #[arg(
        long,
        value_name = "FROM:TO",
        requires = "plot",
        allow_hyphen_values = true
    )]
    window: Option<Window>,

    /// A panel of the plot: Y over X, once for each panel [default: all states over time, and the phase portrait]. Both are
    /// a state, `gap at CONTACT` or `rate at CONTACT`, and X also the time. `impact,rate_before` and `t,rate_before` show the
    /// rates of impacts in logarithmic scale, `X,next:SECTION`, `X,next:impact` and `X,next:release` a return map with its
    /// cobweb, and of one dimension its curve, `drawing` the mechanism at the end of the window
    #[arg(long, value_name = "X,Y", requires = "plot")]
    axes: Vec<AxesOption>,
}

impl Arguments {
    fn axes(&self) -> Vec<Axes> {
        self.axes
            .iter()
            .map(|AxesOption(axes)| axes.clone())
            .collect()
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Loaded {
        mut model,
        text,
        data_files,
    } = arguments.model.load()?;
    arguments.initial.apply(&mut model)?;
    let window = match &arguments.window {
        Some(window) => Some(window.values(&mut model, "--window")?),
        None => None,
    };
    let spec = specification(arguments, &mut model, window)?;
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    let subject = Subject {
        model: &model,
        spec: &spec,
        source: &arguments.model.model,
        text: &text,
        data_files: &data_files,
        digits,
        time_was_given: arguments.until.is_some(),
    };
    picture::check(&subject, &arguments.axes())?;
    if digits.fit_double() {
        run_in::<f64>(arguments, &subject, window, |run| {
            verification(arguments, &subject, run)
        })
    } else if arguments.verify {
        Err(Failure::input(format!(
            "--verify compares a run in doubles with one in double-double: to {} digits there is nothing to compare with",
            digits.0
        )))
    } else {
        run_in::<DoubleDouble>(arguments, &subject, window, |_| Ok(None))
    }
}

/// The comparison with the twin, where it was asked for and the twin was not interrupted; and what is said of it.
fn verification(
    arguments: &Arguments,
    subject: &Subject,
    (simulation, record): (&Simulation<f64>, &Record<f64>),
) -> Result<Option<Verified>, Failure> {
    if !arguments.verify {
        return Ok(None);
    }
    let verification = verification::verify(subject, (simulation, record), &Console::new())?;
    let told = verification.map(|verification| {
        let text = verification::text(subject, (simulation, record), &verification)?;
        Ok(Verified { verification, text })
    });
    told.transpose()
}

struct Verified {
    verification: Verification,
    text: String,
}

fn specification(
    arguments: &Arguments,
    model: &mut Model,
    window: Option<(f64, f64)>,
) -> Result<Spec, Failure> {
    let request = Request {
        until: arguments.until.clone(),
        impacts: arguments.impacts,
        stops: arguments.stop.iter().map(|stop| stop.0.clone()).collect(),
        tolerance: arguments.tolerance.clone(),
    };
    let spec = request.spec(model)?;
    let mut sampling = Vec::new();
    if arguments.out.is_some() {
        let rows = arguments.sample.clone().unwrap_or_default();
        sampling.extend(rows.sampling(model)?);
    }
    if arguments.plot.is_some() {
        // A run without an end of its own may turn out shorter.
        let duration = match &arguments.until {
            Some(_) => spec.until - start_time(model),
            None => Request::USUAL_TIME.into(),
        };
        sampling.push(picture::sampling(duration, window));
    }
    Ok(Spec { sampling, ..spec })
}

fn run_in<R: Real>(
    arguments: &Arguments,
    subject: &Subject,
    window: Option<(f64, f64)>,
    verify: impl FnOnce((&Simulation<R>, &Record<R>)) -> Result<Option<Verified>, Failure>,
) -> Result<u8, Failure> {
    terminal::catch_interrupts();
    let path = arguments.out.as_ref().map(|TableFile(path)| path.as_path());
    let rows = match path {
        Some(path) if arguments.sample == Some(SampleOption::Events) => Rows::Events(path),
        Some(path) => Rows::Table(path),
        None => Rows::None,
    };
    let console = Console::new();
    let followed = follow::<R>(subject, &rows, &console);
    drop(console);
    let mut followed = followed?;
    let verified = verify((&followed.simulation, &followed.record))?;
    // What is written now is all that is done.
    terminal::end_on_interrupt();
    let waiting = Waiting::new("writing");

    let drawn = arguments
        .plot
        .as_ref()
        .and_then(|_| followed.simulation.samples.pop());
    followed.write(subject, &rows)?;
    let (simulation, record) = (&followed.simulation, &followed.record);
    let run = (simulation, record);
    let mut written: Vec<PathBuf> = path.map(Path::to_path_buf).into_iter().collect();
    let mut remarks = Vec::new();
    if let (Some(FigureFile(path)), Some(samples)) = (&arguments.plot, &drawn) {
        let picture = picture::draw(
            subject,
            run,
            samples,
            window,
            &arguments.axes(),
            &Silent::default(),
        )?;
        let outcome = picture.figure.write(path);
        outcome.map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
        if let Some(from) = picture.shortened_to {
            remarks.push(format!(
                "{} shows the end, from time {from:.6} on; --window FROM:TO shows another part",
                path.display()
            ));
        }
    }
    drop(waiting);
    if arguments.json {
        let verification = verified.as_ref().map(|verified| &verified.verification);
        let document = document::document(subject, run, verification);
        terminal::print_json(&document).map_err(Failure::Output)?;
    } else {
        let listing = if arguments.events {
            Listing::EveryEvent
        } else {
            Listing::Summary
        };
        let mut printer = Printer::new();
        account::print(subject, run, listing, &mut printer)?;
        if let Some(verified) = &verified {
            printer.print(&verified.text)?;
        }
        for path in &written {
            printer.print(&format!("wrote {}\n", path.display()))?;
        }
        for remark in &remarks {
            printer.print(&format!("{remark}\n"))?;
        }
        printer.finish()?;
    }
    if simulation.counts.ambiguities > 0 {
        terminal::warn(
            "contacts close at one instant whose order of collisions changes the result, and the equations do not say it: \
             the fastest went first (events of kind `ambiguity`)",
        );
    }
    if let Outcome::Failed(error) = &simulation.outcome {
        terminal::complain(&sentence(error, subject.model));
    }
    Ok(match simulation.outcome {
        Outcome::Failed(_) => failure::UNFINISHED,
        Outcome::Interrupted => failure::INTERRUPTED,
        Outcome::Horizon | Outcome::ImpactBudget | Outcome::Event(_) | Outcome::Rest => {
            failure::SUCCESS
        }
    })
}
