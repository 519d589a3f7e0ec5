//! `chatter exponents`: all Lyapunov exponents.

use super::going_on;
use crate::aligned::{Side, aligned};
use crate::failure::{self, Failure};
use crate::json::{Json, Object};
use crate::numbers::{Digits, concise};
use crate::options::{Count, Initial, Loaded, ModelOptions, Quantity};
use crate::terminal::{self, Progress, Style};
use chatter::analysis::exponents::{Exponents, Spec, exponents};
use chatter::analysis::periodic::forcing;
use chatter::model::Model;
use chatter::numerics::Real;
use chatter_work::periodic::refused;
use clap::Args;
use std::time::Instant;

const EXAMPLES: &str = "\
EXAMPLES
  chatter exponents pressure_relief_valve --set q=0.0218
  chatter exponents impact_oscillator --set omega=2.8 --intervals 5000 --json

Displacements of the state are carried along by the derivative of the flow, through impacts, complete chatter, contact and
release, and made orthogonal after each interval. A direction that chatter or contact forgets has the exponent minus
infinity (null in JSON). Errors are standard errors, from averages over sixteen parts of the time. An autonomous system
has one exponent of zero, along its flow.

JSON
  exponents (descending), errors, dimension (Kaplan and Yorke's), time, intervals, interval.";

/// Average the growth of displacements: all Lyapunov exponents, with error bars
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelOptions,

    #[command(flatten)]
    initial: Initial,

    /// Time between orthogonalisations [default: the period of the forcing; without one, 1]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    interval: Option<Quantity>,

    /// Intervals that are passed over first [default: 200]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    transient: Option<Count>,

    /// Intervals that are averaged over [default: 2000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    intervals: Option<Count>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// Usual numbers.
const TRANSIENT: u64 = 200;
const INTERVALS: u64 = 2000;
const DIGITS: u32 = 6;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Loaded { mut model, .. } = arguments.model.load()?;
    arguments.initial.apply(&mut model)?;
    model.check_defined()?;
    let interval = match &arguments.interval {
        Some(interval) => interval.value(&mut model, "--interval")?.to_f64(),
        None => forcing(&model).unwrap_or(1.0),
    };
    if !(interval > 0.0 && interval.is_finite()) {
        return Err(Failure::input(format!(
            "--interval {interval}: expected a positive number"
        )));
    }
    let spec = Spec {
        interval,
        transient: arguments.transient.map_or(TRANSIENT, |count| count.0),
        intervals: arguments.intervals.map_or(INTERVALS, |count| count.0),
    };
    if spec.intervals == 0 {
        return Err(Failure::input(
            "--intervals 0: there is nothing to average over",
        ));
    }
    terminal::catch_interrupts();
    let mut progress = Progress::new();
    let began = Instant::now();
    let total = (spec.transient + spec.intervals) as f64;
    let found = exponents(&model, &spec, &mut |done| {
        progress.show(done, || {
            let rate = done * total / began.elapsed().as_secs_f64();
            format!("{rate:.0} intervals/s")
        });
        going_on()
    });
    progress.finish();
    let found = found.map_err(|error| refused(&error, &model))?;
    let answer = if arguments.json {
        terminal::Answer::Document(document(&model, arguments, &spec, &found))
    } else {
        terminal::Answer::Text(account(&model, arguments, &found))
    };
    answer.print()?;
    Ok(if found.intervals < spec.intervals {
        failure::INTERRUPTED
    } else {
        failure::SUCCESS
    })
}

fn document(model: &Model, arguments: &Arguments, spec: &Spec, found: &Exponents) -> Object {
    let list = |values: &[f64]| -> Vec<Json> { values.iter().map(|&x| Json::Number(x)).collect() };
    let parameters = model.parameter_values::<f64>(&[]);
    Object::new(Digits::DOUBLE)
        .with("exponents", list(&found.values))
        .with("errors", list(&found.errors))
        .with("dimension", found.dimension)
        .with("time", found.time)
        .with("intervals", found.intervals as i64)
        .with("interval", spec.interval)
        .with(
            "model",
            Object::new(Digits::DOUBLE).with("source", arguments.model.model.as_str()),
        )
        .named("parameters", &model.parameter_names(), &parameters)
        .with("version", env!("CARGO_PKG_VERSION"))
}

fn account(model: &Model, arguments: &Arguments, found: &Exponents) -> String {
    let style = Style::of_stdout();
    let source = &arguments.model.model;
    let title = model.title.as_deref().unwrap_or(source);
    let mut text = format!("{}  {}\n\n", style.title(title), style.faint(source));
    let mut rows = vec![vec!["exponent".to_owned(), "error".to_owned()]];
    for (&value, &error) in found.values.iter().zip(&found.errors) {
        rows.push(if value.is_finite() {
            vec![concise(value, DIGITS), format!("{error:.1e}")]
        } else {
            vec!["minus infinity".to_owned(), String::new()]
        });
    }
    text += &aligned(&rows, &[Side::Right, Side::Right]);
    text += &format!(
        "\ndimension {}, averaged over {} intervals, {} units of time\n",
        concise(found.dimension, DIGITS),
        found.intervals,
        concise(found.time, DIGITS)
    );
    text
}
