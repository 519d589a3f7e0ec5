//! Windows of the map: fold, period doubling, superstable point and graze of the fixed point on each lap.

use crate::json::{Json, Object};
use crate::numbers::{Digits, full};
use crate::options::Counts;
use chatter::analysis::universal::{Argument, Universal, UniversalError};
use chatter::numerics::Real;
use chatter_files::tables::Table;

/// One window, in mu or in a model's parameter. What there is none of is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window<R> {
    /// Number of the lap.
    pub n: i64,
    /// Multiplier +1.
    pub fold: Option<R>,
    /// Multiplier -1.
    pub period_doubling: Option<R>,
    /// Multiplier 0.
    pub superstable: Option<R>,
    /// u_1 = 3/8.
    pub grazing: Option<R>,
}

/// Headings of the columns.
const NAMES: [&str; 5] = ["n", "fold", "period_doubling", "superstable", "grazing"];

impl<R: Real> Window<R> {
    /// The windows of these laps in mu, for a map with slope K.
    pub fn list(
        universal: &Universal<R>,
        slope: R,
        laps: Counts,
    ) -> Result<Vec<Self>, UniversalError>
    where
        R: Argument<Real = R>,
    {
        let windows = universal.windows(slope, laps.first..=laps.last)?;
        let list = windows.into_iter().map(|window| Self {
            n: window.lap,
            fold: window.fold.map(|point| point.mu),
            period_doubling: window.period_doubling.map(|point| point.mu),
            superstable: Some(window.superstable.mu),
            grazing: Some(window.grazing.mu),
        });
        Ok(list.collect())
    }

    /// With all values replaced.
    pub fn map(self, by: impl Fn(R) -> R) -> Self {
        Self {
            n: self.n,
            fold: self.fold.map(&by),
            period_doubling: self.period_doubling.map(&by),
            superstable: self.superstable.map(&by),
            grazing: self.grazing.map(&by),
        }
    }

    fn values(&self) -> [Option<R>; 4] {
        [
            self.fold,
            self.period_doubling,
            self.superstable,
            self.grazing,
        ]
    }
}

/// As JSON.
pub fn window_list<R: Real>(windows: &[Window<R>], digits: Digits) -> Json {
    let object = |window: &Window<R>| {
        let start = Object::new(digits).with(NAMES[0], window.n);
        let named = NAMES[1..].iter().zip(window.values());
        named
            .fold(start, |object, (name, value)| object.maybe(name, value))
            .into()
    };
    Json::List(windows.iter().map(object).collect())
}

/// As rows of text with a heading.
pub fn window_rows<R: Real>(windows: &[Window<R>], digits: Digits) -> Vec<Vec<String>> {
    let mut rows = vec![NAMES.map(|name| name.replace('_', " ")).to_vec()];
    for window in windows {
        let mut row = vec![window.n.to_string()];
        let text = |value: Option<R>| value.map_or_else(|| "-".to_owned(), |v| full(v, digits));
        row.extend(window.values().map(text));
        rows.push(row);
    }
    rows
}

/// As a table; what there is none of is NaN. Names of columns begin with the prefix.
pub fn window_table<R: Real>(windows: &[Window<R>], prefix: &str) -> Table {
    let laps: Vec<i64> = windows.iter().map(|window| window.n).collect();
    let named = |name: &str| format!("{prefix}{name}");
    let start = Table::new("windows").column(named(NAMES[0]), laps);
    let names = NAMES[1..].iter().enumerate();
    names.fold(start, |table, (place, name)| {
        let values = windows.iter().map(|window| window.values()[place]);
        let doubles: Vec<f64> = values
            .map(|value| value.map_or(f64::NAN, Real::to_f64))
            .collect();
        table.column(named(name), doubles)
    })
}
