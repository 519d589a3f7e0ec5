//! What a survey of branches tells of while it works, and what it is told of an earlier one that was broken off.

use super::branch::{Point, Record};
use super::error::PeriodicError;
use core::ops::ControlFlow;
use std::collections::VecDeque;

/// What a survey tells of.
#[derive(Clone, Copy, Debug)]
pub enum Told<'a> {
    /// A trajectory settles.
    Settling,
    /// At the model's own value of the parameter no orbit was found that branches could begin with, for this reason: they begin with one at another.
    Elsewhere {
        /// The model's own value.
        own: f64,
        /// Where they begin.
        at: f64,
        /// Why not at the model's own.
        why: &'a PeriodicError,
    },
    /// An orbit was found.
    Orbit(&'a Point),
    /// So far it has come: with all such records, in order, another survey goes on from there.
    Record(&'a Record),
}

/// Records of before, and whoever hears of what comes.
pub(crate) struct Diary<'a> {
    before: VecDeque<Record>,
    observer: &'a mut dyn FnMut(Told<'_>) -> ControlFlow<()>,
}

impl<'a> Diary<'a> {
    pub(crate) fn new(
        before: Vec<Record>,
        observer: &'a mut dyn FnMut(Told<'_>) -> ControlFlow<()>,
    ) -> Self {
        Self {
            before: before.into(),
            observer,
        }
    }

    /// The next record of before.
    pub(crate) fn next(&mut self) -> Option<Record> {
        self.before.pop_front()
    }

    pub(crate) fn tell(&mut self, told: Told<'_>) -> ControlFlow<()> {
        (self.observer)(told)
    }
}
