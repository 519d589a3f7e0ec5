//! How far everything is, told by parts that are computed side by side.

use crate::terminal::Progress;
use std::sync::{Mutex, PoisonError};

/// Hears what part of a piece of work has been done since it last heard.
pub type Advance<'a> = dyn Fn(f64) + Sync + 'a;

/// The whole work, and how much of it is done.
pub struct Work {
    total: f64,
    done: Mutex<(f64, Progress)>,
}

impl Work {
    /// Nothing is done yet of so much, in whatever unit.
    pub fn new(total: f64) -> Self {
        Self {
            total,
            done: Mutex::new((0.0, Progress::new())),
        }
    }

    /// So much more is done, in the unit of the total.
    pub fn advance(&self, name: &str, more: f64) {
        let mut guard = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let (done, progress) = &mut *guard;
        *done += more;
        progress.show(*done / self.total, || name.to_owned());
    }

    /// Takes the bar away.
    pub fn finish(self) {
        let done = self.done.into_inner();
        done.unwrap_or_else(PoisonError::into_inner).1.finish();
    }
}
