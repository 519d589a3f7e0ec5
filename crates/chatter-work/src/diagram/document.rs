//! A diagram as one JSON document, written as its rows are read.

use super::hysteresis::hysteresis;
use super::job::Job;
use super::source::Rows;
use super::tally::Tally;
use crate::named::Named;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Exponent, Outcome, Range, Record, Row, Sweep};
use chatter::model::Model;
use serde::ser::{Error, Serialize, SerializeSeq, Serializer};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io::Write;

/// What the document is about.
pub struct Subject<'a> {
    /// What was computed.
    pub job: &'a Job,
    /// The model, with everything set into it.
    pub model: &'a Model,
    /// How many rows settled to what.
    pub counts: &'a BTreeMap<Outcome, u64>,
    /// Whether every row is there.
    pub complete: bool,
}

#[derive(serde::Serialize)]
struct Document<'a> {
    outcome: &'static str,
    counts: Named<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    attractors: Option<Vec<Attractor>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hysteresis: Option<Vec<[f64; 2]>>,
    columns: Columns<'a>,
    model: ModelObject<'a>,
    parameters: Named<f64>,
    specification: &'a Job,
    version: &'static str,
}

#[derive(serde::Serialize)]
struct Attractor {
    attractor: u32,
    rows: u64,
    share: f64,
    outcome: Option<&'static str>,
    period: Option<u64>,
    impacts_per_return: Option<f64>,
}

#[derive(serde::Serialize)]
struct ModelObject<'a> {
    source: &'a str,
    title: Option<&'a str>,
}

/// The rows, each read when it is written.
struct Columns<'a> {
    rows: RefCell<&'a mut dyn Rows>,
    failure: Cell<Option<Refusal>>,
}

#[derive(serde::Serialize)]
struct Column<'a> {
    #[serde(flatten)]
    swept: Named<f64>,
    outcome: &'static str,
    period: u64,
    impacts_per_return: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    exponent: Option<Number>,
    start: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    attractor: Option<u32>,
    initial: Named<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<Named<Every<'a>>>,
}

/// A number, null where it is not finite.
#[derive(serde::Serialize)]
struct Number(f64);

/// Every so many numbers of a list.
struct Every<'a> {
    numbers: &'a [f64],
    first: usize,
    stride: usize,
}

impl Serialize for Every<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let from_first = self.numbers.iter().skip(self.first);
        serializer.collect_seq(from_first.step_by(self.stride))
    }
}

impl Serialize for Columns<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut rows = self.rows.borrow_mut();
        let sweep = rows.sweep().clone();
        let count = rows.done();
        let mut sequence = serializer.serialize_seq(Some(count as usize))?;
        for row in 0..count {
            let attractor = rows.attractor(row);
            match rows.row(row) {
                Ok(row) => sequence.serialize_element(&column(&sweep, &row, attractor))?,
                Err(failure) => {
                    self.failure.set(Some(failure));
                    return Err(S::Error::custom("a row cannot be read"));
                }
            }
        }
        sequence.end()
    }
}

fn column<'a>(sweep: &'a Sweep, row: &'a Row, attractor: u32) -> Column<'a> {
    let spec = sweep.spec();
    let names: Vec<String> = spec.sweeps.iter().map(Range::name).collect();
    let observed = spec.observe.iter().map(|observed| observed.name.as_str());
    let samples = (0..spec.observe.len()).map(|first| Every {
        numbers: &row.samples,
        first,
        stride: spec.observe.len(),
    });
    Column {
        swept: Named::new(names.iter().map(String::as_str), sweep.values(row.row)),
        outcome: row.outcome.name(),
        period: row.period,
        impacts_per_return: row.impacts_per_return,
        exponent: (spec.exponent == Exponent::Largest).then_some(Number(row.exponent)),
        start: row.start.name(),
        attractor: sweep.compares().then_some(attractor),
        initial: Named::new(
            sweep.coordinates().iter().map(String::as_str),
            row.origin.iter().copied(),
        ),
        samples: (spec.record == Record::Samples).then(|| Named::new(observed, samples)),
    }
}

/// Writes the document, with a line break at its end.
pub fn write(
    subject: &Subject<'_>,
    rows: &mut dyn Rows,
    out: &mut dyn Write,
) -> Result<(), Refusal> {
    let Subject { job, model, .. } = subject;
    let compared = rows.sweep().compares() && subject.complete;
    let tally = match compared {
        true => Some(Tally::of(rows)?),
        false => None,
    };
    let hysteresis = tally
        .as_ref()
        .and_then(|tally| hysteresis(rows.sweep(), tally));
    let document = Document {
        outcome: if subject.complete {
            "complete"
        } else {
            "interrupted"
        },
        counts: Named::new(
            subject.counts.keys().map(|outcome| outcome.name()),
            subject.counts.values().copied(),
        ),
        attractors: tally.as_ref().map(attractors),
        hysteresis: hysteresis.map(|found| found.ranges),
        columns: Columns {
            rows: RefCell::new(rows),
            failure: Cell::new(None),
        },
        model: ModelObject {
            source: &job.model,
            title: model.title.as_deref(),
        },
        parameters: Named::new(model.parameter_names(), model.parameter_values::<f64>(&[])),
        specification: job,
        version: env!("CARGO_PKG_VERSION"),
    };
    let written = serde_json::to_writer_pretty(&mut *out, &document).map_err(std::io::Error::from);
    if let Some(failure) = document.columns.failure.take() {
        return Err(failure);
    }
    let ended = written
        .and_then(|()| out.write_all(b"\n"))
        .and_then(|()| out.flush());
    match ended {
        // A reader that has gone away, such as `head`, is no error.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Refusal::Output(
            format!("cannot write to standard output: {error}"),
        )),
        _ => Ok(()),
    }
}

fn attractors(tally: &Tally) -> Vec<Attractor> {
    let shares = tally.shares.iter().filter(|share| share.attractor > 0);
    shares
        .map(|share| Attractor {
            attractor: share.attractor,
            rows: share.rows,
            share: share.part,
            outcome: share.outcome.map(Outcome::name),
            period: share.period,
            impacts_per_return: share.impacts_per_return,
        })
        .collect()
}
