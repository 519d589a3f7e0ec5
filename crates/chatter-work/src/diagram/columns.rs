//! A diagram as columns in memory: those of the table, by the same names.

use super::source::Rows;
use super::table::origins;
use crate::columns::Column;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Exponent, Range, Record, Sweep};

/// One value an orbit, and one value a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Of orbits.
    pub orbits: Vec<Column>,
    /// Of samples: which row of the first each belongs to, then what was observed. None where no samples are kept.
    pub samples: Vec<Column>,
}

/// Reads the rows that are there.
///
/// # Errors
/// A row cannot be read.
pub fn columns(rows: &mut dyn Rows) -> Result<Columns, Refusal> {
    let sweep = rows.sweep().clone();
    let spec = sweep.spec();
    let observed = spec.observe.len();
    let origins = origins(&sweep);
    let done = rows.done();
    let mut outcomes = Vec::new();
    let mut starts = Vec::new();
    let (mut periods, mut attractors, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    let (mut impacts, mut exponents) = (Vec::new(), Vec::new());
    let mut from: Vec<Vec<f64>> = vec![Vec::new(); origins.len()];
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); observed];
    for number in 0..done {
        attractors.push(i64::from(rows.attractor(number)));
        let row = rows.row(number)?;
        outcomes.push(row.outcome.name());
        periods.push(row.period as i64);
        impacts.push(row.impacts_per_return);
        exponents.push(row.exponent);
        starts.push(row.start.name());
        for (values, (index, _)) in from.iter_mut().zip(&origins) {
            values.push(row.origin[*index]);
        }
        if spec.record == Record::Samples {
            for sample in row.samples.chunks_exact(observed) {
                numbers.push(number as i64);
                for (values, value) in samples.iter_mut().zip(sample) {
                    values.push(*value);
                }
            }
        }
    }
    let swept = spec.sweeps.iter().enumerate().map(|(place, range)| {
        let values = (0..done).map(|row| sweep.values(row)[place]);
        Column::floats(Range::name(range), values.collect())
    });
    let [outcome, period, impacts_name, exponent, start, attractor] = Sweep::CLASS_NAMES;
    let mut orbits: Vec<Column> = swept.collect();
    orbits.push(Column::words(outcome, outcomes));
    orbits.push(Column::integers(period, periods));
    orbits.push(Column::floats(impacts_name, impacts));
    if spec.exponent == Exponent::Largest {
        orbits.push(Column::floats(exponent, exponents));
    }
    orbits.push(Column::words(start, starts));
    if sweep.compares() {
        orbits.push(Column::integers(attractor, attractors));
    }
    let named = origins.into_iter().zip(from);
    orbits.extend(named.map(|((_, name), values)| Column::floats(name, values)));
    let mut of_samples = Vec::new();
    if spec.record == Record::Samples {
        of_samples.push(Column::integers(Sweep::COLUMN_NAME, numbers));
        let named = spec.observe.iter().zip(samples);
        of_samples.extend(named.map(|(one, values)| Column::floats(&*one.name, values)));
    }
    Ok(Columns {
        orbits,
        samples: of_samples,
    })
}
