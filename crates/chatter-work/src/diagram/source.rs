//! Where the results of a diagram come from, in flat memory and as often as needed.

use crate::refusal::Refusal;
use chatter::analysis::diagram::{Collector, Outcome, Row, Sweep};
use chatter::analysis::map::Map;

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
    /// Number of its attractor; zero for none, or where none are told apart.
    pub attractor: u32,
}

/// A finished diagram.
pub trait Source {
    /// Goes through all samples, in order: the row and the observed quantities of each.
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Refusal>;

    /// Goes through all rows, in order.
    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Refusal>;
}

/// A finished diagram whose rows can be had one by one.
pub trait Rows {
    /// What diagram.
    fn sweep(&self) -> &Sweep;

    /// One of its rows.
    fn row(&mut self, row: u64) -> Result<Row, Refusal>;

    /// How many of its rows are there, in order from the first.
    fn done(&self) -> u64 {
        self.sweep().rows()
    }

    /// How many samples the rows that are there have, all together.
    fn sample_count(&self) -> u64;

    /// The number of a row's attractor; zero for none, or where none are told apart.
    fn attractor(&self, row: u64) -> u32;
}

/// How many samples a row has.
pub(super) fn samples_of(sweep: &Sweep, row: &Row) -> u64 {
    (row.samples.len() / sweep.spec().observe.len().max(1)) as u64
}

impl<R: Rows + ?Sized> Source for R {
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Refusal> {
        let observed = self.sweep().spec().observe.len();
        for row in 0..self.done() {
            let row = self.row(row)?;
            for sample in row.samples.chunks_exact(observed) {
                visit(row.row, sample);
            }
        }
        Ok(())
    }

    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Refusal> {
        for row in 0..self.done() {
            let attractor = self.attractor(row);
            let row = self.row(row)?;
            let class = Class {
                attractor,
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
    /// Numbers of their attractors, if these are told apart.
    attractors: Vec<u32>,
}

impl<'a> InMemory<'a> {
    /// Rows of which none are compared.
    pub fn new(sweep: &'a Sweep, rows: &'a [Row]) -> Self {
        let attractors = Vec::new();
        Self {
            sweep,
            rows,
            attractors,
        }
    }

    /// Tells attractors apart.
    pub fn compared(mut self, map: &dyn Map) -> Self {
        if self.sweep.compares() {
            let mut collector = Collector::new(map, self.sweep);
            self.rows.iter().for_each(|row| collector.note(row));
            self.attractors = collector.finish().numbers().to_vec();
        }
        self
    }
}

impl Rows for InMemory<'_> {
    fn sweep(&self) -> &Sweep {
        self.sweep
    }

    fn row(&mut self, row: u64) -> Result<Row, Refusal> {
        let row = usize::try_from(row).ok().and_then(|row| self.rows.get(row));
        row.cloned()
            .ok_or_else(|| Refusal::Output("a row of the diagram is missing".to_owned()))
    }

    fn done(&self) -> u64 {
        self.rows.len() as u64
    }

    fn sample_count(&self) -> u64 {
        let counts = self.rows.iter().map(|row| samples_of(self.sweep, row));
        counts.sum()
    }

    fn attractor(&self, row: u64) -> u32 {
        self.attractors.get(row as usize).copied().unwrap_or(0)
    }
}
