//! Events that follow themselves sooner and sooner, as Achilles and the tortoise meet: infinitely many in finite time.
//!
//! An event that puts the state before its own surface, which is then met again, is found for as long as that way can be told
//! from zero. Where the ways have become shorter each time, until one cannot be, there is no end of them, and no motion beyond.

use crate::numerics::{Real, WithTerms};

/// So many of the times between an event and the next one in a row have been shorter than those before, where the next one is lost.
const SHRUNK: u32 = 3;

/// And so many where the next one is found, after no time.
const VANISHED: u32 = 8;

/// A surface has been moved by an event if its function has changed by more roundoffs of its terms than these.
const MOVED_ROUNDOFFS: f64 = 4.0;

/// The latest event on one surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Latest<R> {
    /// When it was, with the rounding remainder.
    time: (R, R),
    /// How long the event before was past.
    interval: R,
    /// How many intervals in a row were shorter than those before them.
    shrunk: u32,
}

impl<R: Real> Latest<R> {
    pub(super) fn first(time: (R, R)) -> Self {
        Self {
            time,
            interval: R::splat(f64::INFINITY),
            shrunk: 0,
        }
    }

    /// Whether it was at this time.
    pub(super) fn is_at(&self, time: (R, R)) -> bool {
        self.time == time
    }

    pub(super) fn then(self, time: (R, R)) -> Self {
        let interval = (time.0 - self.time.0) + (time.1 - self.time.1);
        Self {
            time,
            interval,
            shrunk: match interval < self.interval {
                true => self.shrunk + 1,
                false => 0,
            },
        }
    }

    /// Whether events have come sooner and sooner until no time was left between them, as those do that other events bring about.
    pub(super) fn has_vanished(&self, instant: R) -> bool {
        self.shrunk >= VANISHED && self.interval <= instant
    }

    /// Whether the next event is no longer found, as those before it were ever sooner: the surface has been moved, but not as far as
    /// could be told from zero. It was met with `before`, its function and rate, and `after` is what the event has left of these.
    pub(super) fn is_lost(&self, before: &[WithTerms<R>], after: &[WithTerms<R>]) -> bool {
        let (value, moved) = (after[0], after[0].value - before[0].value);
        let is_moved = moved.abs() > R::splat(MOVED_ROUNDOFFS * R::ROUNDOFF * value.terms);
        // The function vanishes as the event is told, and what it is moved by against the motion is the way that is left.
        let comes_back = moved * after[1].value < R::ZERO;
        self.shrunk >= SHRUNK && is_moved && comes_back && value.value.abs() <= value.level()
    }
}
