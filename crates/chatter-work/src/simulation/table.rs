//! A simulation as a table.

use super::Subject;
use crate::named::Named;
use crate::numbers::{Digits, significant};
use chatter::analysis::simulate::{Samples, Simulation};
use chatter::numerics::Real;
use chatter_files::tables::{Cell, CsvWriter, NpzWriter, Spool, Table};
use chatter_files::{Error, Format};
use std::path::{Path, PathBuf};

/// Texts of an NPZ file that say how its arrays came about.
const TEXTS: [&str; 5] = ["model", "parameters", "specification", "outcome", "version"];
/// One more, where tables of the model stand in files.
const DATA_FILES: &str = "data_files";

pub(super) fn text_names(subject: &Subject) -> impl Iterator<Item = &'static str> {
    let more = (!subject.data_files.is_empty()).then_some(DATA_FILES);
    TEXTS.into_iter().chain(more)
}

/// The samples of a simulation, written as they come.
///
/// CSV holds the table alone, NPZ also how it came about. Beyond double precision, numbers in CSV have all their digits;
/// in NPZ what the doubles leave is in columns with `_low` at the end of their names.
pub struct SampleTable<'a> {
    subject: &'a Subject<'a>,
    path: PathBuf,
    rows: Rows,
}

enum Rows {
    /// Straight into the file.
    Csv(Box<CsvWriter>),
    /// Columns on disk until their lengths are known: of numbers, of what doubles leave of each, of closed contacts.
    Npz {
        numbers: Vec<Spool<f64>>,
        low: Vec<Spool<f64>>,
        closed: Vec<Spool<i64>>,
    },
}

impl<'a> SampleTable<'a> {
    /// Starts the table that will stand at `path`.
    pub fn create(subject: &'a Subject<'a>, path: &Path) -> Result<Self, Error> {
        let is_npz = Format::of_table(path)? == Format::Npz;
        let (numbers, closed) = names(subject);
        let wide = is_npz && !subject.digits.fit_double();
        let mut all = Table::new("trajectory");
        for name in &numbers {
            all = all.column(name, Vec::<f64>::new());
            if wide {
                all = all.column(low(name), Vec::<f64>::new());
            }
        }
        for name in &closed {
            all = all.column(name, Vec::<i64>::new());
        }
        if is_npz {
            all = text_names(subject).fold(all, |all, text| all.column(text, Vec::<f64>::new()));
        }
        // Before the run, not after it.
        all.check()?;
        let rows = if is_npz {
            let folder = match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            };
            let spools = |count: usize| -> Result<Vec<Spool<f64>>, Error> {
                (0..count).map(|_| Ok(Spool::create(folder)?)).collect()
            };
            let closed: Result<Vec<Spool<i64>>, Error> =
                closed.iter().map(|_| Ok(Spool::create(folder)?)).collect();
            Rows::Npz {
                numbers: spools(numbers.len())?,
                low: spools(if wide { numbers.len() } else { 0 })?,
                closed: closed?,
            }
        } else {
            let headings: Vec<&str> = (numbers.iter().chain(&closed).map(String::as_str)).collect();
            Rows::Csv(Box::new(CsvWriter::create(path, &headings)?))
        };
        let path = path.to_path_buf();
        Ok(Self {
            subject,
            path,
            rows,
        })
    }

    /// Appends samples.
    pub fn take<R: Real>(&mut self, samples: &Samples<R>) -> Result<(), Error> {
        let subject = self.subject;
        for row in 0..samples.len() {
            let states = subject.states().map(|index| samples.states[index][row]);
            let values = core::iter::once(samples.times[row]).chain(states);
            let contacts = 0..subject.model.contacts.len();
            let closed = contacts.map(|index| i64::from(samples.closed[row].contains(index)));
            match &mut self.rows {
                Rows::Csv(writer) if subject.digits.fit_double() => {
                    let values = values.map(|value| Cell::Float(value.to_f64()));
                    let cells: Vec<Cell> = values.chain(closed.map(Cell::Integer)).collect();
                    writer.row(&cells)?;
                }
                Rows::Csv(writer) => {
                    let texts: Vec<String> =
                        values.map(|value| text(value, subject.digits)).collect();
                    let values = texts.iter().map(|text| Cell::Text(text));
                    let cells: Vec<Cell> = values.chain(closed.map(Cell::Integer)).collect();
                    writer.row(&cells)?;
                }
                Rows::Npz {
                    numbers,
                    low,
                    closed: spools,
                } => {
                    for (place, value) in values.enumerate() {
                        numbers[place].push(value.to_f64())?;
                        if let Some(low) = low.get_mut(place) {
                            low.push(value.to_double_double().low())?;
                        }
                    }
                    for (spool, closed) in spools.iter_mut().zip(closed) {
                        spool.push(closed)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Puts the file in its place.
    pub fn finish<R: Real>(self, simulation: &Simulation<R>) -> Result<(), Error> {
        let (names, closed_names) = names(self.subject);
        match self.rows {
            Rows::Csv(writer) => writer.finish()?,
            Rows::Npz {
                numbers,
                low: lows,
                closed,
            } => {
                let mut writer = NpzWriter::create(&self.path)?;
                let mut lows = lows.into_iter();
                for (name, spool) in names.iter().zip(numbers) {
                    writer.spooled(name, spool)?;
                    if let Some(spool) = lows.next() {
                        writer.spooled(&low(name), spool)?;
                    }
                }
                for (name, spool) in closed_names.iter().zip(closed) {
                    writer.spooled(name, spool)?;
                }
                for (name, text) in
                    text_names(self.subject).zip(provenance(self.subject, simulation))
                {
                    writer.text(name, &text)?;
                }
                writer.finish()?;
            }
        }
        Ok(())
    }
}

/// Names of the columns of numbers and of closed contacts.
fn names(subject: &Subject) -> (Vec<String>, Vec<String>) {
    let states = subject.states().map(|index| subject.state_name(index));
    let numbers = core::iter::once(time_name(subject)).chain(states);
    let contacts = subject.model.contacts.iter();
    (
        numbers.map(str::to_owned).collect(),
        contacts
            .map(|contact| format!("closed_{}", contact.name))
            .collect(),
    )
}

/// `time`, unless a state is called so.
pub(super) fn time_name(subject: &Subject) -> &'static str {
    match subject.model.state_index("time") {
        Some(_) => "t",
        None => "time",
    }
}

/// Name of the column that holds what doubles leave.
pub(super) fn low(name: &str) -> String {
    format!("{name}_low")
}

/// All digits; what is no number as columns of doubles have it.
pub(super) fn text<R: Real>(value: R, digits: Digits) -> String {
    match value.is_finite() {
        true => significant(value, digits.0),
        false => "nan".to_owned(),
    }
}

/// How a simulation came about, in the order of [`text_names`].
pub(super) fn provenance<R: Real>(subject: &Subject, simulation: &Simulation<R>) -> [String; 6] {
    let names = subject.model.parameter_names();
    let parameters = Named::new(names, subject.model.parameter_values::<f64>(&[]));
    [
        subject.text.to_owned(),
        stored(&parameters),
        stored(subject.spec),
        simulation.outcome.name().to_owned(),
        env!("CARGO_PKG_VERSION").to_owned(),
        stored(subject.data_files),
    ]
}

fn stored(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).expect("names and numbers are JSON")
}
