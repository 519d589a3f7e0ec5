//! Rows under named columns, as JSON, as text and as a table.

use crate::json::{Json, Object};
use crate::numbers::{Digits, concise, full};
use chatter::numerics::{DoubleDouble, Real};
use chatter_files::tables::Table;

/// What a cell holds.
#[derive(Clone, Debug)]
pub enum Cell {
    /// A whole number.
    Whole(i64),
    /// A number to full precision, if there is one.
    Number(Option<DoubleDouble>),
    /// A number of a few digits.
    Rough(Option<f64>),
    /// Whole numbers, such as an itinerary.
    Laps(Vec<i64>),
    /// A word.
    Name(&'static str),
}

/// Rows under named columns.
pub struct Sheet {
    /// Name, as a key in JSON and of the table.
    pub name: &'static str,
    /// Title in the text.
    pub title: &'static str,
    /// Names of the columns.
    pub columns: Vec<&'static str>,
    /// Rows, each with a cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

/// Digits of what is only roughly known.
const ROUGH: u32 = 6;

impl Cell {
    fn text(&self, digits: Digits) -> String {
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        match self {
            Self::Whole(value) => value.to_string(),
            Self::Number(value) => or_dash(value.map(|value| full(value, digits))),
            Self::Rough(value) => or_dash(value.map(|value| concise(value, ROUGH))),
            Self::Laps(laps) => spaced(laps),
            Self::Name(name) => (*name).to_owned(),
        }
    }
}

fn spaced(laps: &[i64]) -> String {
    let laps: Vec<String> = laps.iter().map(i64::to_string).collect();
    laps.join(" ")
}

impl Sheet {
    /// As a list of objects.
    pub fn json(&self, digits: Digits) -> Json {
        let object = |row: &Vec<Cell>| {
            let start = Object::new(digits);
            let cells = self.columns.iter().zip(row);
            cells
                .fold(start, |object, (name, cell)| match cell {
                    Cell::Whole(value) => object.with(name, *value),
                    Cell::Number(value) => object.maybe(name, *value),
                    Cell::Rough(value) => {
                        object.maybe(name, value.filter(|value| value.is_finite()))
                    }
                    Cell::Laps(laps) => {
                        let laps = laps.iter().map(|&lap| Json::Integer(lap));
                        object.with(name, laps.collect::<Vec<Json>>())
                    }
                    Cell::Name(text) => object.with(name, *text),
                })
                .into()
        };
        Json::List(self.rows.iter().map(object).collect())
    }

    /// As rows of text with a heading.
    pub fn text(&self, digits: Digits) -> Vec<Vec<String>> {
        let heading = self.columns.iter().map(|name| name.replace('_', " "));
        let rows = self
            .rows
            .iter()
            .map(|row| row.iter().map(|cell| cell.text(digits)).collect());
        core::iter::once(heading.collect()).chain(rows).collect()
    }

    /// As a table; what there is none of is NaN. Names of columns begin with the prefix.
    pub fn table(&self, prefix: &str) -> Table {
        let start = Table::new(self.name);
        let names = self.columns.iter().enumerate();
        names.fold(start, |table, (place, name)| {
            let name = format!("{prefix}{name}");
            let cells = || self.rows.iter().map(|row| &row[place]);
            let whole: Option<Vec<i64>> = cells()
                .map(|cell| match cell {
                    Cell::Whole(value) => Some(*value),
                    _ => None,
                })
                .collect();
            if let Some(whole) = whole.filter(|_| !self.rows.is_empty()) {
                return table.column(name, whole);
            }
            let words = cells().any(|cell| matches!(cell, Cell::Laps(_) | Cell::Name(_)));
            if words {
                let words: Vec<String> = cells().map(|cell| cell.text(Digits::DOUBLE)).collect();
                return table.column(name, words);
            }
            let number = |cell: &Cell| match cell {
                Cell::Number(value) => value.map_or(f64::NAN, Real::to_f64),
                Cell::Rough(value) => value.unwrap_or(f64::NAN),
                Cell::Whole(value) => *value as f64,
                _ => f64::NAN,
            };
            table.column(name, cells().map(number).collect::<Vec<f64>>())
        })
    }
}
