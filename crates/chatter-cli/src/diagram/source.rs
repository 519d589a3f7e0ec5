//! Where the results of a diagram come from, in flat memory and as often as needed.

use crate::failure::Failure;
use chatter::analysis::diagram::{Outcome, Row, Sweep};

/// What a row was classified as.
#[derive(Clone, Copy, Debug)]
pub struct Class {
    /// What its orbit settled to.
    pub outcome: Outcome,
    /// Its period; zero for none.
    pub period: u64,
    /// Mean number of impacts from sample to sample.
    pub impacts_per_return: f64,
    /// Largest Lyapunov exponent; NaN where it is not known.
    pub exponent: f64,
}

/// A finished diagram.
pub trait Source {
    /// Goes through all samples, in order: the row and the observed quantities of each.
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Failure>;

    /// Goes through all rows, in order.
    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Failure>;
}

/// A finished diagram whose rows can be had one by one.
pub trait Rows {
    /// What diagram.
    fn sweep(&self) -> &Sweep;

    /// One of its rows.
    fn row(&mut self, row: u64) -> Result<Row, Failure>;
}

impl<R: Rows> Source for R {
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Failure> {
        let observed = self.sweep().spec().observe.len();
        for row in 0..self.sweep().rows() {
            let row = self.row(row)?;
            for sample in row.samples.chunks_exact(observed) {
                visit(row.row, sample);
            }
        }
        Ok(())
    }

    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Failure> {
        for row in 0..self.sweep().rows() {
            let row = self.row(row)?;
            let class = Class {
                outcome: row.outcome,
                period: row.period,
                impacts_per_return: row.impacts_per_return,
                exponent: row.exponent,
            };
            visit(row.row, &class);
        }
        Ok(())
    }
}

/// A diagram in memory: all rows, in order.
pub struct InMemory<'a> {
    /// What diagram.
    pub sweep: &'a Sweep,
    /// Its rows.
    pub rows: &'a [Row],
}

impl Rows for InMemory<'_> {
    fn sweep(&self) -> &Sweep {
        self.sweep
    }

    fn row(&mut self, row: u64) -> Result<Row, Failure> {
        let row = usize::try_from(row).ok().and_then(|row| self.rows.get(row));
        row.cloned()
            .ok_or_else(|| Failure::Output("a row of the diagram is missing".to_owned()))
    }
}
