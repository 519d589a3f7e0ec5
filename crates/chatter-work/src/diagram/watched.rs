//! A diagram that is gone through while an observer hears how far.

use super::source::{Class, Source};
use crate::observer::Observer;
use crate::refusal::Refusal;

/// A source that is gone through so many times.
pub struct Watched<'a> {
    source: &'a mut dyn Source,
    rows: u64,
    passes: u32,
    done: u32,
    observer: &'a dyn Observer,
}

impl<'a> Watched<'a> {
    /// Of so many rows.
    pub fn new(
        source: &'a mut dyn Source,
        (rows, passes): (u64, u32),
        observer: &'a dyn Observer,
    ) -> Self {
        Self {
            source,
            rows,
            passes,
            done: 0,
            observer,
        }
    }

    /// One pass; `go` goes through the source, and says at which row it is.
    fn pass(
        &mut self,
        go: impl FnOnce(&mut dyn Source, &dyn Fn(u64)) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        if self.observer.going_on().is_break() {
            return Err(Refusal::Interrupted);
        }
        let (rows, passes, done, observer) = (self.rows, self.passes, self.done, self.observer);
        go(self.source, &|row| {
            let part = (row + 1) as f64 / rows as f64;
            let all = (f64::from(done) + part) / f64::from(passes);
            observer.progress(all, &|| format!("drawing, {} of {rows} orbits", row + 1));
        })?;
        self.done += 1;
        Ok(())
    }
}

impl Source for Watched<'_> {
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Refusal> {
        self.pass(|source, tell| {
            let mut before = None;
            source.samples(&mut |row, sample| {
                if before != Some(row) {
                    tell(row);
                    before = Some(row);
                }
                visit(row, sample);
            })
        })
    }

    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Refusal> {
        self.pass(|source, tell| {
            source.classes(&mut |row, class| {
                tell(row);
                visit(row, class);
            })
        })
    }
}
