//! In place of machine code on processors that none is made for.

use super::Places;
use crate::expressions::tape::Tape;

/// There is none.
#[derive(Debug)]
pub(crate) enum Executable {}

impl Executable {
    pub(super) fn new<S: 'static>(_: &Tape, _: usize) -> Option<Self> {
        None
    }

    pub(crate) fn run<S: 'static>(&self, _: Places<'_, S>, _: usize) {
        match *self {}
    }
}

pub(super) fn lanes_of<S: 'static>() -> Option<usize> {
    None
}
