//! Windows of the map: fold, period doubling, superstable point and graze of the fixed point on each lap.

use super::sheet::{Cell, Sheet};
use crate::options::Counts;
use chatter::analysis::universal::{Argument, Universal, UniversalError};
use chatter::numerics::Real;

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
    /// The windows of these laps in mu, for a map with slope K, and the slope that periods double at where that is another one.
    pub fn list(
        universal: &Universal<R>,
        (slope, doubling): (R, Option<R>),
        laps: Counts,
    ) -> Result<Vec<Self>, UniversalError>
    where
        R: Argument<Real = R>,
    {
        let windows = universal.windows_remembered(slope, doubling, laps.first..=laps.last)?;
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

/// As a sheet.
pub fn window_sheet<R: Real>(windows: &[Window<R>]) -> Sheet {
    let row = |window: &Window<R>| {
        let values = window.values().into_iter();
        let cells = values.map(|value| Cell::Number(value.map(Real::to_double_double)));
        let all = core::iter::once(Cell::Whole(window.n)).chain(cells);
        all.collect()
    };
    Sheet {
        name: "windows",
        title: "windows",
        columns: NAMES.to_vec(),
        rows: windows.iter().map(row).collect(),
    }
}
