//! A simulation as a table.

use super::Subject;
use crate::named::Named;
use crate::numbers::significant;
use chatter::analysis::simulate::{EventDetail, Samples, Simulation};
use chatter::numerics::Real;
use chatter_io::tables::{Dataset, Table};
use chatter_io::{Error, Format};
use std::path::{Path, PathBuf};

/// Writes the samples of a simulation, or its events if it has none; gives the files written.
///
/// CSV holds the table alone, NPZ also how it came about. Beyond double precision, numbers in CSV have all their digits;
/// in NPZ what the doubles leave is in columns with `_low` at the end of their names.
pub fn write<R: Real>(
    subject: &Subject,
    simulation: &Simulation<R>,
    path: &Path,
) -> Result<Vec<PathBuf>, Error> {
    let writer = Writer {
        subject,
        format: Format::of_table(path)?,
    };
    let table = match simulation.samples.first() {
        Some(samples) => writer.samples(samples),
        None => writer.events(simulation),
    };
    let mut data = Dataset::new().table(table);
    if writer.format == Format::Npz {
        let names = subject.model.parameter_names();
        let parameters = Named::new(names, subject.model.parameter_values::<f64>(&[]));
        data = data
            .text("model", subject.text)
            .text("parameters", stored(&parameters))
            .text("specification", stored(subject.spec))
            .text("outcome", simulation.outcome.name())
            .text("version", env!("CARGO_PKG_VERSION"));
    }
    data.write(path)
}

fn stored(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).expect("names and numbers are JSON")
}

struct Writer<'a> {
    subject: &'a Subject<'a>,
    format: Format,
}

impl Writer<'_> {
    /// Adds a column of numbers.
    fn numbers<R: Real>(&self, table: Table, name: &str, values: &[R]) -> Table {
        let doubles = || {
            values
                .iter()
                .map(|value| value.to_f64())
                .collect::<Vec<f64>>()
        };
        if self.subject.digits.fit_double() {
            return table.column(name, doubles());
        }
        if self.format == Format::Csv {
            let digits = self.subject.digits.0;
            let text = |&value: &R| match value.is_finite() {
                true => significant(value, digits),
                // As the columns of doubles have it.
                false => "nan".to_owned(),
            };
            let texts: Vec<String> = values.iter().map(text).collect();
            return table.column(name, texts);
        }
        let low: Vec<f64> = values
            .iter()
            .map(|value| value.to_double_double().low())
            .collect();
        table
            .column(name, doubles())
            .column(format!("{name}_low"), low)
    }

    /// `time`, unless a state is called so.
    fn time_name(&self) -> &'static str {
        match self.subject.model.state_index("time") {
            Some(_) => "t",
            None => "time",
        }
    }

    fn samples<R: Real>(&self, samples: &Samples<R>) -> Table {
        let mut table = self.numbers(Table::new("trajectory"), self.time_name(), &samples.times);
        for index in self.subject.states() {
            table = self.numbers(
                table,
                self.subject.state_name(index),
                &samples.states[index],
            );
        }
        for (index, contact) in self.subject.model.contacts.iter().enumerate() {
            let closed = samples
                .closed
                .iter()
                .map(|closed| i64::from(closed.contains(index)));
            table = table.column(
                format!("closed_{}", contact.name),
                closed.collect::<Vec<i64>>(),
            );
        }
        table
    }

    fn events<R: Real>(&self, simulation: &Simulation<R>) -> Table {
        let events = &simulation.events;
        let nothing = R::splat(f64::NAN);
        let kinds: Vec<&str> = events.iter().map(|event| event.kind().name()).collect();
        let places: Vec<&str> = events
            .iter()
            .map(|event| self.subject.place(&event.detail))
            .collect();
        let column = |value: fn(&EventDetail<R>) -> Option<R>| -> Vec<R> {
            events
                .iter()
                .map(|event| value(&event.detail).unwrap_or(nothing))
                .collect()
        };
        let before = column(|detail| match *detail {
            EventDetail::Impact { rate_before, .. } => Some(rate_before),
            EventDetail::Graze { rate, .. } => Some(rate),
            _ => None,
        });
        let after = column(|detail| match *detail {
            EventDetail::Impact { rate_after, .. } => Some(rate_after),
            EventDetail::Graze { rate, .. } => Some(rate),
            _ => None,
        });
        let error = |detail: &EventDetail<R>| match *detail {
            EventDetail::Accumulation { error, .. } | EventDetail::Cascade { error, .. } => error,
            _ => f64::NAN,
        };
        let impacts = |detail: &EventDetail<R>| match *detail {
            EventDetail::Impact { .. } => 1,
            EventDetail::Accumulation { impacts, .. } | EventDetail::Cascade { impacts, .. } => {
                impacts as i64
            }
            _ => 0,
        };
        let times: Vec<R> = events.iter().map(|event| event.time).collect();
        let mut table = self
            .numbers(Table::new("events"), self.time_name(), &times)
            .column("kind", kinds)
            .column("place", places);
        for index in self.subject.states() {
            let values: Vec<R> = events.iter().map(|event| event.state[index]).collect();
            table = self.numbers(table, self.subject.state_name(index), &values);
        }
        table = self.numbers(table, "rate_before", &before);
        table = self.numbers(table, "rate_after", &after);
        table
            .column(
                "impacts",
                events
                    .iter()
                    .map(|event| impacts(&event.detail))
                    .collect::<Vec<i64>>(),
            )
            .column(
                "error",
                events
                    .iter()
                    .map(|event| error(&event.detail))
                    .collect::<Vec<f64>>(),
            )
    }
}
