//! What of a side is on record: read where a survey goes on, written while it works.

use super::record::{Record, Then};
use crate::analysis::periodic::branch::{End, Point, Special};
use crate::analysis::periodic::diary::{Diary, Told};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Workshop;
use crate::flow::System;
use core::ops::ControlFlow;
use std::sync::Arc;

/// After so many stations what came about is recorded.
const STATIONS_A_RECORD: usize = 64;

/// What is on record of a side.
pub(in crate::analysis::periodic) struct Kept {
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    /// How it goes on, if anything is.
    pub then: Option<Then>,
}

impl Kept {
    /// Takes all records of one side. Without a workshop: of a side that has no equations.
    pub(in crate::analysis::periodic) fn read(
        diary: &mut Diary<'_>,
        workshop: Option<&Arc<Workshop>>,
    ) -> Result<Self, PeriodicError> {
        let (mut points, mut special, mut then) = (Vec::new(), Vec::new(), None);
        while let Some(record) = diary.next() {
            let (new_points, new_special, how) = record.restored(workshop)?;
            points.extend(new_points);
            special.extend(new_special);
            let is_all = matches!(how, Then::Ended(_));
            then = Some(how);
            if is_all {
                break;
            }
        }
        Ok(Self {
            points,
            special,
            then,
        })
    }
}

/// How much of a side is on record.
pub(in crate::analysis::periodic) struct Ledger<'a> {
    /// Without one the side has no equations.
    system: Option<&'a System>,
    points: usize,
    special: usize,
    /// Stations that were made then.
    stations: usize,
}

/// Points and special points of a side.
type Found<'a> = (&'a [Point], &'a [Special]);

impl<'a> Ledger<'a> {
    /// Of what is on record already, after so many stations.
    pub(in crate::analysis::periodic) fn new(
        system: Option<&'a System>,
        (points, special): Found<'_>,
        stations: usize,
    ) -> Self {
        Self {
            system,
            points: points.len(),
            special: special.len(),
            stations,
        }
    }

    /// How many special points are on record.
    pub(in crate::analysis::periodic) fn special_points(&self) -> usize {
        self.special
    }

    /// Whether a record is due.
    pub(in crate::analysis::periodic) fn is_due(&self, stations: usize) -> bool {
        stations >= self.stations + STATIONS_A_RECORD
    }

    /// Tells of what came about since the record before.
    pub(in crate::analysis::periodic) fn keep(
        &mut self,
        (points, special): Found<'_>,
        (then, stations): (Then, usize),
        diary: &mut Diary<'_>,
    ) -> ControlFlow<()> {
        let new = (&points[self.points..], &special[self.special..]);
        let record = Record::new(self.system, new, then);
        *self = Self::new(self.system, (points, special), stations);
        diary.tell(Told::Record(&record))
    }

    /// Tells how the side ended. What cannot be kept is broken off.
    pub(in crate::analysis::periodic) fn close(
        mut self,
        found: Found<'_>,
        end: End,
        diary: &mut Diary<'_>,
    ) -> End {
        if end == End::Interrupted {
            return end;
        }
        let then = (Then::Ended(end.clone()), self.stations);
        match self.keep(found, then, diary) {
            ControlFlow::Continue(()) => end,
            ControlFlow::Break(()) => End::Interrupted,
        }
    }
}
