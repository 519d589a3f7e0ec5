//! Chatter of several contacts in turn that does not end by itself.
//!
//! A body that comes to rest on a moving one is put onto it, and so moved by a roundoff of its place. What bounces on it then rises
//! about as high as that, again and again. Where flights that are lower than gaps are known have not become slower over
//! hundreds of impacts, they are rounding, and what moves in them is at rest.

use crate::flow::error::FlowError;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::numerics::Real;

/// So many impacts are compared with as many before them: sequences that end become far slower in that time.
const WINDOW: u64 = 512;
const SLOWER: f64 = 0.5;

/// Impacts further apart than so many of the longest flights among them belong to different sequences.
const APART: f64 = 64.0;

/// What is met within so many of the longest flights takes part.
const REACH: f64 = 4.0;

/// Impacts followed by flights lower than gaps are known.
#[derive(Clone, Debug)]
pub(in crate::flow::trajectory) struct Stall<R> {
    count: u64,
    latest: R,
    longest: R,
    /// The greatest rate after these impacts, and after those of the window before.
    fastest: R,
    before: R,
}

impl<R: Real> Stall<R> {
    pub const NONE: Self = Self {
        count: 0,
        latest: R::ZERO,
        longest: R::ZERO,
        fastest: R::ZERO,
        before: R::ZERO,
    };

    /// Takes note of an impact; whether those of two windows are as fast.
    fn note(&mut self, time: R, (rate, flight_time): (R, R)) -> bool {
        if time - self.latest > R::splat(APART) * self.longest {
            *self = Self::NONE;
        }
        self.latest = time;
        self.longest = self.longest.max(flight_time);
        self.fastest = self.fastest.max(rate);
        self.count += 1;
        if !self.count.is_multiple_of(WINDOW) {
            return false;
        }
        let stalls = self.before > R::ZERO && self.fastest > self.before * R::splat(SLOWER);
        (self.before, self.fastest) = (self.fastest, R::ZERO);
        stalls
    }
}

impl<R: Real> Trajectory<R> {
    /// Takes note of the flight that follows an impact; ends chatter that is nothing but rounding. Returns whether it did.
    pub(super) fn end_stall(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (contact, rate, flight_time): (usize, R, R),
    ) -> Result<bool, FlowError> {
        if flight_time >= R::splat(FOREVER) {
            return Ok(false);
        }
        // That of a parabola.
        let height = rate * flight_time * R::splat(0.25);
        if !self.may_be_rounding(height) || height > self.local(system, contact)?[0].level() {
            // Of a flight that lasts far longer either the next impact is far away, too, or others end it, as where rounding is all that
            // moves bodies together which fall side by side.
            if flight_time <= R::splat(APART) * self.stall.longest {
                self.stall = Stall::NONE;
            }
            return Ok(false);
        }
        if !self.stall.note(self.time, (rate, flight_time)) {
            return Ok(false);
        }
        let Stall { count, longest, .. } = self.stall;
        self.stall = Stall::NONE;
        self.end_burst(system, work, (longest * R::splat(REACH), count))
    }
}
