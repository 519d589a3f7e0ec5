//! A diagram as tables: one with a row for each orbit, one with a row for each sample.

use super::job::Order;
use super::source::Rows;
use crate::named::Named;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Exponent, Range, Record, Row, Sweep, initial_name};
use chatter::model::Model;
use chatter_files::Format;
use chatter_files::tables::{Cell, CsvWriter, Dataset, NpzWriter, Table};
use std::path::{Path, PathBuf};

/// Name of the text that holds the job.
pub const SPECIFICATION: &str = "specification";
/// Name of the text that holds the model's file.
pub const MODEL: &str = "model";
/// Name of the text that holds the parameters that are not swept.
pub const PARAMETERS: &str = "parameters";
/// Name of the text that holds this program's version.
pub const VERSION: &str = "version";

/// Longest name of an outcome or of a way to start.
const WORD: usize = 16;

/// Whether names of columns can stand beside each other in one file.
pub fn check_names(sweep: &Sweep) -> Result<(), Refusal> {
    let mut table = Table::new("diagram");
    let names = columns(sweep).into_iter().chain(samples(sweep));
    for name in names.chain([SPECIFICATION, MODEL, PARAMETERS, VERSION].map(str::to_owned)) {
        table = table.column(name, Vec::<f64>::new());
    }
    table.check().map_err(|error| {
        Refusal::input(error).help("give the observed quantity another name: --observe NAME=EXPR")
    })
}

/// Headings of the table of orbits.
fn columns(sweep: &Sweep) -> Vec<String> {
    let spec = sweep.spec();
    let swept = spec.sweeps.iter().map(Range::name);
    let [outcome, period, impacts, exponent, start, attractor] =
        Sweep::CLASS_NAMES.map(str::to_owned);
    let mut names: Vec<String> = swept.chain([outcome, period, impacts]).collect();
    if spec.exponent == Exponent::Largest {
        names.push(exponent);
    }
    names.push(start);
    if sweep.compares() {
        names.push(attractor);
    }
    names.extend(origins(sweep).into_iter().map(|(_, name)| name));
    names
}

/// Where orbits started: positions of coordinates and headings. Those that are swept have a column already.
pub(super) fn origins(sweep: &Sweep) -> Vec<(usize, String)> {
    let swept: Vec<String> = sweep.spec().sweeps.iter().map(Range::name).collect();
    let names = sweep.coordinates().iter().map(|name| initial_name(name));
    let mut origins: Vec<(usize, String)> = names.enumerate().collect();
    origins.retain(|(_, name)| !swept.contains(name));
    origins
}

/// Headings of the table of samples; none if samples are not kept.
fn samples(sweep: &Sweep) -> Vec<String> {
    let spec = sweep.spec();
    if spec.record == Record::Classes {
        return Vec::new();
    }
    let observed = spec.observe.iter().map(|observed| observed.name.clone());
    [Sweep::COLUMN_NAME.to_owned()]
        .into_iter()
        .chain(observed)
        .collect()
}

/// Writes the tables of a finished diagram, with texts that say where they come from; gives the files written.
pub fn write(
    rows: &mut dyn Rows,
    texts: &[(&str, String)],
    path: &Path,
) -> Result<Vec<PathBuf>, Refusal> {
    match Format::of_table(path).map_err(Refusal::input)? {
        Format::Npz => write_npz(rows, path, texts),
        _ => write_csv(rows, path, texts),
    }
}

/// Where the diagram of a model comes from: enough to compute it again.
pub fn provenance(order: &Order, model: &Model) -> Result<[(&'static str, String); 4], Refusal> {
    let parameters = Named::new(model.parameter_names(), model.parameter_values::<f64>(&[]));
    Ok([
        (SPECIFICATION, json(&order.job)?),
        (MODEL, order.model_text.clone()),
        (PARAMETERS, json(&parameters)?),
        (VERSION, order.job.version.clone()),
    ])
}

/// A value as a document.
pub fn json(value: &impl serde::Serialize) -> Result<String, Refusal> {
    serde_json::to_string(value).map_err(|error| Refusal::Output(error.to_string()))
}

fn output(error: impl ToString) -> Refusal {
    Refusal::Output(error.to_string())
}

fn write_npz(
    store: &mut dyn Rows,
    path: &Path,
    texts: &[(&str, String)],
) -> Result<Vec<PathBuf>, Refusal> {
    let mut writer = NpzWriter::create(path).map_err(output)?;
    let sweep = &store.sweep().clone();
    let rows = sweep.rows();
    for (place, range) in sweep.spec().sweeps.iter().enumerate() {
        let values = (0..rows).map(|row| sweep.values(row)[place]);
        writer.stream(&range.name(), rows, values).map_err(output)?;
    }
    let [outcome, period, impacts, exponent, start, attractor] = Sweep::CLASS_NAMES;
    words(&mut writer, outcome, store, rows, |row| row.outcome.name())?;
    numbers(&mut writer, period, store, rows, |row| row.period as i64)?;
    numbers(&mut writer, impacts, store, rows, |row| {
        row.impacts_per_return
    })?;
    if sweep.spec().exponent == Exponent::Largest {
        numbers(&mut writer, exponent, store, rows, |row| row.exponent)?;
    }
    words(&mut writer, start, store, rows, |row| row.start.name())?;
    if sweep.compares() {
        let told = (0..rows).map(|row| i64::from(store.attractor(row)));
        writer.stream(attractor, rows, told).map_err(output)?;
    }
    for (index, name) in origins(sweep) {
        numbers(&mut writer, &name, store, rows, |row| row.origin[index])?;
    }
    if sweep.spec().record == Record::Samples {
        let observed = sweep.spec().observe.len();
        let count = store.sample_count();
        let column = Sweep::COLUMN_NAME;
        let mut array = writer.begin::<i64>(column, count).map_err(output)?;
        for row in 0..rows {
            let count = store.row(row)?.samples.len() / observed;
            let repeated = std::iter::repeat_n(row as i64, count);
            array.extend(repeated).map_err(output)?;
        }
        array.finish().map_err(output)?;
        for (place, quantity) in sweep.spec().observe.iter().enumerate() {
            let name = &quantity.name;
            let mut array = writer.begin::<f64>(name, count).map_err(output)?;
            for row in 0..rows {
                let row = store.row(row)?;
                let values = row.samples.iter().skip(place).step_by(observed);
                array.extend(values.copied()).map_err(output)?;
            }
            array.finish().map_err(output)?;
        }
    }
    for (name, text) in texts {
        writer.text(name, text).map_err(output)?;
    }
    writer.finish().map_err(output)?;
    Ok(vec![path.to_path_buf()])
}

fn words(
    writer: &mut NpzWriter,
    name: &str,
    store: &mut dyn Rows,
    rows: u64,
    word: fn(&Row) -> &'static str,
) -> Result<(), Refusal> {
    let mut failure = None;
    let texts = (0..rows).map(|row| match store.row(row) {
        Ok(row) => Ok(word(&row)),
        Err(error) => {
            failure = Some(error);
            Ok("")
        }
    });
    let written = writer.stream_texts(name, WORD, rows, texts);
    match failure {
        Some(failure) => Err(failure),
        None => written.map_err(output),
    }
}

fn numbers<T: chatter_files::tables::Element>(
    writer: &mut NpzWriter,
    name: &str,
    store: &mut dyn Rows,
    rows: u64,
    number: impl Fn(&Row) -> T,
) -> Result<(), Refusal> {
    let mut array = writer.begin::<T>(name, rows).map_err(output)?;
    for row in 0..rows {
        array.push(number(&store.row(row)?)).map_err(output)?;
    }
    array.finish().map_err(output)
}

/// Files are named as by [`Dataset::write`].
fn write_csv(
    store: &mut dyn Rows,
    path: &Path,
    texts: &[(&str, String)],
) -> Result<Vec<PathBuf>, Refusal> {
    let sweep = &store.sweep().clone();
    let spec = sweep.spec();
    let with_samples = spec.record == Record::Samples;
    let file = |table: &str| path.with_extension(format!("{table}.csv"));
    let orbits = if with_samples {
        file("columns")
    } else {
        path.to_path_buf()
    };
    let headings = columns(sweep);
    let origins = origins(sweep);
    let mut writer = csv(&orbits, &headings)?;
    for row in 0..sweep.rows() {
        let attractor = store.attractor(row);
        let row = store.row(row)?;
        let mut cells: Vec<Cell> = sweep.values(row.row).into_iter().map(Cell::Float).collect();
        cells.push(Cell::Text(row.outcome.name()));
        cells.push(Cell::Integer(row.period as i64));
        cells.push(Cell::Float(row.impacts_per_return));
        if spec.exponent == Exponent::Largest {
            cells.push(Cell::Float(row.exponent));
        }
        cells.push(Cell::Text(row.start.name()));
        if sweep.compares() {
            cells.push(Cell::Integer(attractor.into()));
        }
        cells.extend(
            origins
                .iter()
                .map(|(index, _)| Cell::Float(row.origin[*index])),
        );
        writer.row(&cells).map_err(output)?;
    }
    writer.finish().map_err(output)?;
    let mut written = vec![orbits];
    if with_samples {
        let path = file("samples");
        let mut writer = csv(&path, &samples(sweep))?;
        for row in 0..sweep.rows() {
            let row = store.row(row)?;
            for sample in row.samples.chunks_exact(spec.observe.len()) {
                let column = Cell::Integer(row.row as i64);
                let values = sample.iter().copied().map(Cell::Float);
                let cells: Vec<Cell> = [column].into_iter().chain(values).collect();
                writer.row(&cells).map_err(output)?;
            }
        }
        writer.finish().map_err(output)?;
        written.push(path);
    }
    let (names, texts): (Vec<String>, Vec<String>) = texts
        .iter()
        .map(|(name, text)| ((*name).to_owned(), text.clone()))
        .unzip();
    let about = Table::new("metadata")
        .column("name", names)
        .column("text", texts);
    let path = metadata_file(path);
    written.extend(Dataset::new().table(about).write(&path).map_err(output)?);
    Ok(written)
}

/// The file that says what a diagram in CSV is about.
pub fn metadata_file(path: &Path) -> PathBuf {
    path.with_extension("metadata.csv")
}

fn csv(path: &Path, headings: &[String]) -> Result<CsvWriter, Refusal> {
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    CsvWriter::create(path, &headings).map_err(output)
}
