//! The events of a simulation as a table, one a row, in flat memory.

use super::table::{low, provenance, text, text_names, time_name};
use super::{Noted, Record, Subject};
use chatter::analysis::simulate::Simulation;
use chatter::flow::Occurrence;
use chatter::numerics::Real;
use chatter_files::tables::{Cell, CsvWriter, NpzWriter, Table};
use chatter_files::{Error, Format};
use std::path::Path;

/// How an entry of a column is read.
type Read<'a, N, T> = Box<dyn Fn(&N) -> T + 'a>;

/// What a column holds.
enum Column<'a, R> {
    /// Numbers.
    Number(&'a str, Read<'a, Noted<R>, R>),
    /// Numbers of which no more than a double is known.
    Double(&'a str, fn(&Noted<R>) -> f64),
    /// Counts.
    Count(&'a str, fn(&Noted<R>) -> i64),
    /// Texts.
    Text(&'a str, Read<'a, Noted<R>, &'a str>),
}

fn columns<'a, R: Real>(subject: &'a Subject) -> Vec<Column<'a, R>> {
    let rate = |of: fn(R, R) -> R| {
        move |noted: &Noted<R>| match noted.event.detail {
            Occurrence::Impact {
                rate_before,
                rate_after,
                ..
            } => of(rate_before, rate_after),
            Occurrence::Graze { rate, .. } => rate,
            _ => R::splat(f64::NAN),
        }
    };
    let mut columns: Vec<Column<'a, R>> = vec![
        Column::Number(time_name(subject), Box::new(|noted| noted.event.time)),
        Column::Text("kind", Box::new(|noted| noted.event.kind.name())),
        Column::Text(
            "place",
            Box::new(|noted| subject.place(&noted.event.detail)),
        ),
    ];
    columns.extend(subject.states().map(|index| {
        let name = subject.state_name(index);
        Column::Number(
            name,
            Box::new(move |noted: &Noted<R>| noted.event.state[index]),
        )
    }));
    columns.extend([
        Column::Number("rate_before", Box::new(rate(|before, _| before))),
        Column::Number("rate_after", Box::new(rate(|_, after| after))),
        Column::Count("impacts", |noted| match noted.event.detail {
            Occurrence::Impact { .. } => 1,
            Occurrence::Accumulation { impacts, .. } | Occurrence::Cascade { impacts, .. } => {
                impacts as i64
            }
            _ => 0,
        }),
        Column::Double("error", |noted| match noted.event.detail {
            Occurrence::Accumulation { error, .. } | Occurrence::Cascade { error, .. } => error,
            _ => f64::NAN,
        }),
    ]);
    columns
}

/// Checks before a run that its events can be written to `path`.
pub fn check(subject: &Subject, path: &Path) -> Result<(), Error> {
    let is_npz = Format::of_table(path)? == Format::Npz;
    let wide = is_npz && !subject.digits.fit_double();
    let mut all = Table::new("events");
    for column in columns::<f64>(subject) {
        let none = Vec::<f64>::new;
        match column {
            Column::Number(name, _) => {
                all = all.column(name, none());
                if wide {
                    all = all.column(low(name), none());
                }
            }
            Column::Double(name, _) | Column::Count(name, _) | Column::Text(name, _) => {
                all = all.column(name, none());
            }
        }
    }
    if is_npz {
        all = text_names(subject).fold(all, |all, text| all.column(text, Vec::<f64>::new()));
    }
    Ok(all.check()?)
}

/// Writes the events of a run.
pub fn write<R: Real>(
    subject: &Subject,
    (simulation, record): (&Simulation<R>, &Record<R>),
    path: &Path,
) -> Result<(), Error> {
    match Format::of_table(path)? {
        Format::Npz => write_npz(subject, (simulation, record), path),
        _ => write_csv(subject, record, path),
    }
}

fn write_csv<R: Real>(subject: &Subject, record: &Record<R>, path: &Path) -> Result<(), Error> {
    let columns = columns::<R>(subject);
    let names: Vec<&str> = (columns.iter())
        .map(|column| match *column {
            Column::Number(name, _)
            | Column::Double(name, _)
            | Column::Count(name, _)
            | Column::Text(name, _) => name,
        })
        .collect();
    let mut writer = CsvWriter::create(path, &names)?;
    let is_double = subject.digits.fit_double();
    let mut texts = vec![String::new(); columns.len()];
    for noted in record.events() {
        let noted = noted?;
        if !is_double {
            for (text_of, column) in texts.iter_mut().zip(&columns) {
                if let Column::Number(_, value) = column {
                    *text_of = text(value(&noted), subject.digits);
                }
            }
        }
        let cells = columns
            .iter()
            .zip(&texts)
            .map(|(column, text)| match column {
                Column::Number(_, value) if is_double => Cell::Float(value(&noted).to_f64()),
                Column::Number(..) => Cell::Text(text),
                Column::Double(_, value) => Cell::Float(value(&noted)),
                Column::Count(_, value) => Cell::Integer(value(&noted)),
                Column::Text(_, value) => Cell::Text(value(&noted)),
            });
        writer.row(&cells.collect::<Vec<Cell>>())?;
    }
    writer.finish()
}

fn write_npz<R: Real>(
    subject: &Subject,
    (simulation, record): (&Simulation<R>, &Record<R>),
    path: &Path,
) -> Result<(), Error> {
    let mut writer = NpzWriter::create(path)?;
    let wide = !subject.digits.fit_double();
    for column in columns::<R>(subject) {
        match column {
            Column::Number(name, value) => {
                numbers(&mut writer, record, name, |noted| value(noted).to_f64())?;
                if wide {
                    let low_part = |noted: &Noted<R>| value(noted).to_double_double().low();
                    numbers(&mut writer, record, &low(name), low_part)?;
                }
            }
            Column::Double(name, value) => numbers(&mut writer, record, name, value)?,
            Column::Count(name, value) => {
                let mut array = writer.begin(name, record.len())?;
                for noted in record.events() {
                    array.push(value(&noted?))?;
                }
                array.finish()?;
            }
            Column::Text(name, value) => {
                let mut width = 0;
                for noted in record.events() {
                    width = width.max(value(&noted?).chars().count());
                }
                let texts = record.events().map(|noted| Ok(value(&noted?)));
                writer.stream_texts(name, width, record.len(), texts)?;
            }
        }
    }
    for (name, text) in text_names(subject).zip(provenance(subject, simulation)) {
        writer.text(name, &text)?;
    }
    writer.finish()
}

fn numbers<R: Real>(
    writer: &mut NpzWriter,
    record: &Record<R>,
    name: &str,
    value: impl Fn(&Noted<R>) -> f64,
) -> Result<(), Error> {
    let mut array = writer.begin(name, record.len())?;
    for noted in record.events() {
        array.push(value(&noted?))?;
    }
    array.finish()
}
