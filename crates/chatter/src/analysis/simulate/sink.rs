//! Who hears of a run while it goes on.

use super::result::{ContactPhase, Event};
use super::samples::Samples;
use crate::numerics::Real;
use core::ops::ControlFlow;

/// Takes what comes of a run as it comes, so that memory does not grow with it. Each call may break the run off.
pub trait Sink<R> {
    /// The next samples of a list, of those that the specification asks for.
    fn samples(&mut self, list: usize, samples: &Samples<R>) -> ControlFlow<()>;

    /// What happened next.
    fn event(&mut self, event: &Event<R>) -> ControlFlow<()>;

    /// A contact phase that has begun, or the same that has ended. They are numbered from zero, in order of their start.
    fn contact_phase(&mut self, number: u64, phase: &ContactPhase<R>) -> ControlFlow<()>;
}

/// Keeps everything.
pub(super) struct Keeper<R> {
    pub samples: Vec<Samples<R>>,
    pub events: Vec<Event<R>>,
    pub contact_phases: Vec<ContactPhase<R>>,
}

impl<R: Real> Keeper<R> {
    pub(super) fn new() -> Self {
        Self {
            samples: Vec::new(),
            events: Vec::new(),
            contact_phases: Vec::new(),
        }
    }
}

impl<R: Real> Sink<R> for Keeper<R> {
    fn samples(&mut self, list: usize, samples: &Samples<R>) -> ControlFlow<()> {
        let lists = self.samples.len().max(list + 1);
        (self.samples).resize_with(lists, || Samples::new(samples.states.len()));
        self.samples[list].append(samples);
        ControlFlow::Continue(())
    }

    fn event(&mut self, event: &Event<R>) -> ControlFlow<()> {
        self.events.push(event.clone());
        ControlFlow::Continue(())
    }

    fn contact_phase(&mut self, number: u64, phase: &ContactPhase<R>) -> ControlFlow<()> {
        let number = number as usize;
        match self.contact_phases.get_mut(number) {
            Some(known) => *known = *phase,
            None => self.contact_phases.push(*phase),
        }
        ControlFlow::Continue(())
    }
}
