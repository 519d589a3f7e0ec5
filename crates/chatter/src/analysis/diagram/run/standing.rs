//! What is there of a sweep that was broken off.

use super::row::Row;
use super::share::Share;
use crate::analysis::diagram::sweep::Sweep;
use std::collections::BTreeMap;

/// Where a row leaves off: the next one of its piece goes on from there.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Carried {
    pub row: u64,
    pub origin: Vec<f64>,
    /// Empty where there is nothing to go on from.
    pub end: Vec<f64>,
}

impl Carried {
    pub fn of(row: &Row) -> Self {
        Self {
            row: row.row,
            origin: row.origin.clone(),
            end: row.end.clone(),
        }
    }
}

/// A piece that has been begun.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Begun {
    /// How many of its rows are done.
    pub done: u64,
    /// The latest of them, while there are more to come.
    pub latest: Option<Carried>,
}

/// Which rows are there already, from a run that was broken off.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// The pieces that have been begun.
    begun: BTreeMap<u64, Begun>,
    rows: u64,
}

impl Standing {
    /// Notes a row that is there. Those of a piece come in the order in which they were computed; a row that does not
    /// belong to the sweep, or is out of order, is not noted, and will be computed again.
    pub fn note(&mut self, sweep: &Sweep, row: &Row) -> bool {
        if row.row >= sweep.rows() {
            return false;
        }
        let piece = sweep.piece_of(row.row);
        let begun = self.begun.entry(piece).or_default();
        if begun.done >= sweep.piece_rows(piece) || row.row != sweep.row(piece, begun.done) {
            return false;
        }
        begun.done += 1;
        self.rows += 1;
        begun.latest = (begun.done < sweep.piece_rows(piece)).then(|| Carried::of(row));
        true
    }

    /// A piece, as far as it is done.
    pub(in crate::analysis::diagram) fn begun(&self, piece: u64) -> Begun {
        self.begun.get(&piece).cloned().unwrap_or_default()
    }

    /// How many rows of a piece are there.
    pub fn done(&self, piece: u64) -> u64 {
        self.begun.get(&piece).map_or(0, |begun| begun.done)
    }

    /// How many pieces of a share are done.
    pub(in crate::analysis::diagram) fn finished(&self, sweep: &Sweep, share: Share) -> u64 {
        let done = |piece: &u64| self.begun(*piece).done >= sweep.piece_rows(*piece);
        share.pieces(sweep.pieces()).filter(done).count() as u64
    }

    /// How many rows of a share are there.
    pub fn rows_of(&self, sweep: &Sweep, share: Share) -> u64 {
        let pieces = share.pieces(sweep.pieces());
        pieces.map(|piece| self.done(piece)).sum()
    }

    /// How many rows are there.
    pub fn rows(&self) -> u64 {
        self.rows
    }
}
