//! `chatter exponents`: all Lyapunov exponents.

use crate::aligned::{Side, aligned};
use crate::failure::{self, Failure};
use crate::numbers::concise;
use crate::options::{Count, Initial, Loaded, ModelOptions, Quantity};
use crate::terminal::{self, Console, Style};
use chatter::analysis::exponents::Exponents;
use chatter::model::Model;
use chatter_work::exponents::{Request, document, find};
use clap::Args;

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

    /// Time between orthogonalisations [default: the period of the forcing; without one, 1, or less for models that answer in less than a tenth of it]
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

/// Digits of text.
const DIGITS: u32 = 6;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Loaded { mut model, .. } = arguments.model.load()?;
    arguments.initial.apply(&mut model)?;
    model.check_defined()?;
    let request = Request {
        interval: arguments.interval.clone(),
        transient: arguments.transient,
        intervals: arguments.intervals,
    };
    let spec = request.spec(&mut model)?;
    terminal::catch_interrupts();
    let found = find(&model, &spec, &Console::new())?;
    let answer = if arguments.json {
        let source = &arguments.model.model;
        terminal::Answer::Document(document(&model, source, &spec, &found))
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

fn account(model: &Model, arguments: &Arguments, found: &Exponents) -> String {
    let style = Style::of_stdout();
    let source = &arguments.model.model;
    let title = model.title.as_deref().unwrap_or(source);
    let mut text = format!("{}  {}\n\n", style.title(title), style.faint(source));
    let mut rows = vec![vec!["exponent".to_owned(), "error".to_owned()]];
    for (&value, &error) in found.values.iter().zip(&found.errors) {
        rows.push(if value.is_finite() {
            let error = if error.is_nan() {
                "unknown".to_owned()
            } else {
                format!("{error:.1e}")
            };
            vec![concise(value, DIGITS), error]
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
