//! Which parameter values a figure shows.

use crate::refusal::Refusal;
use chatter::analysis::diagram::{Range, Spacing, Sweep};
use chatter_figures::{Axis, Scale};

/// The parameter values that are shown.
pub struct Window {
    /// The first value shown.
    pub low: f64,
    /// The last value shown.
    pub high: f64,
    /// How they are spaced.
    pub scale: Scale,
    /// How many values there are in it.
    pub count: u64,
    /// From half a spacing before the first of them to half a spacing after the last, so that each has a cell.
    pub cells: (f64, f64),
}

impl Window {
    /// The values of a range that lie in a zoom.
    pub fn new(range: &Range, zoom: Option<(f64, f64)>) -> Result<Self, Refusal> {
        let scale = match range.spacing {
            Spacing::Linear => Scale::Linear,
            Spacing::Logarithmic => Scale::Logarithmic,
        };
        let (low, high) = zoom.unwrap_or((range.from, range.to));
        let mut inside =
            (0..range.count).filter(|&index| (low..=high).contains(&range.value(index)));
        let Some(first) = inside.next() else {
            return Err(Refusal::input(format!(
                "there is no value of `{}` from {low} to {high}: it was swept from {} to {}",
                range.name(),
                range.from,
                range.to
            )));
        };
        let last = inside.next_back().unwrap_or(first);
        let (from, to) = (range.value(first), range.value(last));
        let cells = match range.spacing {
            _ if range.count == 1 => beside(from),
            Spacing::Linear => {
                let gaps = (range.count - 1).max(1) as f64;
                let half = (range.to - range.from) / gaps / 2.0;
                (from - half, to + half)
            }
            Spacing::Logarithmic => {
                let half = (range.value(1) / range.from).sqrt();
                (from / half, to * half)
            }
        };
        Ok(Self {
            low,
            high,
            scale,
            count: last - first + 1,
            cells,
        })
    }

    /// Whether a value is shown.
    pub fn holds(&self, x: f64) -> bool {
        (self.low..=self.high).contains(&x)
    }

    /// Whether each value is seen by itself.
    pub fn is_sparse(&self) -> bool {
        self.count < SPARSE
    }

    /// The axis over just these values; over their cells where half of the first and of the last one would be missed.
    pub fn on(&self, axis: Axis) -> Axis {
        let (low, high) = if self.is_sparse() {
            let (first, last) = self.cells;
            (first.min(self.low), last.max(self.high))
        } else {
            (self.low, self.high)
        };
        let mut axis = if low < high {
            axis.range(low, high)
        } else {
            axis.tight()
        };
        axis.scale = self.scale;
        axis
    }
}

/// Fewer values than these are seen one by one.
pub const SPARSE: u64 = 500;

/// Room beside a single value.
fn beside(value: f64) -> (f64, f64) {
    let room = if value == 0.0 {
        1.0
    } else {
        value.abs() * SINGLE
    };
    (value - room, value + room)
}

/// The room on either side of a single value, as a part of it.
const SINGLE: f64 = 0.01;

/// The parameter value of the row that samples come from, looked up once a row.
pub struct Abscissa<'a> {
    sweep: &'a Sweep,
    row: u64,
    x: f64,
}

impl<'a> Abscissa<'a> {
    /// For the rows of a sweep over one parameter.
    pub fn new(sweep: &'a Sweep) -> Self {
        let row = u64::MAX;
        Self { sweep, row, x: 0.0 }
    }

    /// The value of a row.
    pub fn of(&mut self, row: u64) -> f64 {
        if row != self.row {
            self.row = row;
            self.x = self.sweep.values(row)[0];
        }
        self.x
    }
}
