//! Orbits over one or two parameters, row by row as they are computed.
//!
//! A row is a list of numbers: the sweep, the pass through the values (where there are several orbits for each), the values of
//! the first and the second parameter, the number of the outcome, the period (zero for none), impacts from sample to sample,
//! the largest exponent, then the samples.
//!
//! Where several orbits start at the same parameters, their attractors are told apart once a sweep is done: for each row five
//! numbers (the sweep, the pass, both values, the number of the attractor), and then in a document what the attractors are
//! called, with their shares of the starts.

use super::Answering;
use super::file::{Extension, stem};
use crate::question::DiagramQuestion;
use crate::record::Kind;
use chatter::analysis::diagram::{Outcome, Row, Sweep};
use chatter_work::diagram::picture::{self, Words};
use chatter_work::diagram::tally::{Share, Tally};
use chatter_work::diagram::{Order, Ready, View, produce_in_memory, produce_rows, table};
use chatter_work::{Observer as _, Refusal};
use serde_json::{Value, json};

/// Orbits and numbers in all sweeps of a question.
const MOST_ROWS: u64 = 200_000;
const MOST_SAMPLES: u64 = 50_000_000;
/// Sweeps in a question.
const MOST_RUNS: usize = 256;

/// The rows of all sweeps, one sweep after the other.
pub fn answer(answering: &Answering, question: &DiagramQuestion) -> Result<(), Refusal> {
    if question.runs.len() > MOST_RUNS {
        return Err(Refusal::input(format!(
            "expected {MOST_RUNS} sweeps at most"
        )));
    }
    let names: Vec<&str> = Outcome::ALL.iter().map(|outcome| outcome.name()).collect();
    let mut budget = (MOST_ROWS, MOST_SAMPLES);
    for (run, sweeps) in question.runs.iter().enumerate() {
        let ready = order(answering, question, sweeps)?.ready()?;
        let spec = ready.sweep.spec();
        budget = spent(budget, &ready.sweep)?;
        if run == 0 {
            let observe: Vec<&str> = spec.observe.iter().map(|one| &*one.name).collect();
            answering.document(&json!({ "outcomes": names, "observe": observe }))?;
        }
        let columns: u64 = spec.sweeps.iter().map(|range| range.count).product();
        let passes = ready.sweep.rows() / columns.max(1);
        let mut rows: Vec<Row> = Vec::new();
        let take = &mut |row: Row| {
            answering.numbers(Kind::Row, &numbers(run, passes, &ready.sweep, &row))?;
            if ready.sweep.compares() {
                rows.push(row);
            }
            Ok(())
        };
        let all = produce_rows(&ready, (answering.context.threads, take), answering)?;
        if !all || answering.going_on().is_break() {
            return Err(Refusal::Interrupted);
        }
        let attractors = match ready.sweep.compares() {
            true => {
                rows.sort_unstable_by_key(|row| row.row);
                told_apart(answering, (run, passes), &ready, &rows)?
            }
            false => Vec::new(),
        };
        answering.document(&json!({ "run": run, "attractors": attractors }))?;
    }
    Ok(())
}

/// Says to which attractor each row belongs; gives the attractors, if there are several.
fn told_apart(
    answering: &Answering,
    (run, passes): (usize, u64),
    ready: &Ready,
    rows: &[Row],
) -> Result<Vec<Value>, Refusal> {
    let tally = Tally::of(&mut ready.source(rows, true))?;
    if !tally.several() {
        return Ok(Vec::new());
    }
    let mut told = Vec::with_capacity(5 * rows.len());
    for (row, number) in rows.iter().zip(&tally.numbers) {
        let [pass, x, y] = place(passes, &ready.sweep, row);
        told.extend([run as f64, pass, x, y, f64::from(*number)]);
    }
    answering.numbers(Kind::Numbers, &told)?;
    let shares = tally.shares.iter();
    let attractor = |share: &Share| {
        json!({
            "attractor": share.attractor,
            "label": share.label(),
            "rows": share.rows,
            "share": share.part,
        })
    };
    Ok(shares.map(attractor).collect())
}

/// What is left of how much may be asked.
fn spent((rows, samples): (u64, u64), sweep: &Sweep) -> Result<(u64, u64), Refusal> {
    let spec = sweep.spec();
    let numbers = sweep
        .rows()
        .saturating_mul(spec.keep)
        .saturating_mul(spec.observe.len() as u64);
    match (rows.checked_sub(sweep.rows()), samples.checked_sub(numbers)) {
        (Some(rows), Some(samples)) => Ok((rows, samples)),
        _ => Err(Refusal::input(format!(
            "too much for a page: expected {MOST_ROWS} orbits and {MOST_SAMPLES} samples at most"
        ))
        .help("`chatter diagram` computes more, and keeps it in a file")),
    }
}

/// Pass and values of a row.
fn place(passes: u64, sweep: &Sweep, row: &Row) -> [f64; 3] {
    let values = sweep.values(row.row);
    let value = |place: usize| values.get(place).copied().unwrap_or(f64::NAN);
    [(row.row % passes.max(1)) as f64, value(0), value(1)]
}

fn numbers(run: usize, passes: u64, sweep: &Sweep, row: &Row) -> Vec<f64> {
    let outcome = Outcome::ALL.iter().position(|known| *known == row.outcome);
    let [pass, x, y] = place(passes, sweep, row);
    let mut numbers = vec![
        run as f64,
        pass,
        x,
        y,
        outcome.unwrap_or_default() as f64,
        row.period as f64,
        row.impacts_per_return,
        row.exponent,
    ];
    numbers.extend_from_slice(&row.samples);
    numbers
}

fn order(
    answering: &Answering,
    question: &DiagramQuestion,
    run: &[String],
) -> Result<Order, Refusal> {
    let source = question.model.source(&answering.context.files);
    question.request(run)?.order(source)
}

/// The first sweep as a file.
pub fn file(
    answering: &Answering,
    question: &DiagramQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let stem = stem(&question.model.name, "diagram");
    written(answering, question, (&stem, kind))
}

/// The first sweep as a file of this name.
pub fn written(
    answering: &Answering,
    question: &DiagramQuestion,
    (stem, kind): (&str, Extension),
) -> Result<(), Refusal> {
    let Some(run) = question.runs.first() else {
        return Err(Refusal::input("nothing is swept"));
    };
    let order = order(answering, question, run)?;
    let ready = order.ready()?;
    spent((MOST_ROWS, MOST_SAMPLES), &ready.sweep)?;
    let (ready, rows, complete) = produce_in_memory(&order, answering.context.threads, answering)?;
    if !complete {
        return Err(Refusal::Interrupted);
    }
    let mut source = ready.source(&rows, complete);
    if kind.is_picture() {
        let job = &order.job;
        let words = Words {
            title: job.title(&ready.model),
            origin: &job.model,
            parameters: &picture::parameters(&ready.model, ready.sweep.spec()),
            version: &job.version,
            axis: &|name| picture::axis(&ready.model, name),
        };
        let picture = picture::draw(
            &words,
            (&ready.sweep, &mut source),
            &View::default(),
            answering,
        )?;
        return answering.figure(stem, kind, &picture.figure);
    }
    table::check_names(&ready.sweep)?;
    let texts = table::provenance(&order, &ready.model)?;
    answering.tables(stem, kind, |path| table::write(&mut source, &texts, path))
}
