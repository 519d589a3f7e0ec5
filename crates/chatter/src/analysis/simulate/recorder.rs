//! Takes note of a trajectory while it moves.

use super::result::{ContactPhase, Counts, Event, Outcome, Simulation};
use super::samples::Sampler;
use super::sink::Sink;
use super::spec::Sampling;
use crate::flow::{Closed, Dense, EventKind, Held, Occurrence, System, Trajectory, Workspace};
use crate::numerics::Real;
use core::ops::ControlFlow;

pub(super) struct Recorder<R> {
    pub(super) counts: Counts,
    /// The event that the latest occurrence became.
    latest: Option<Event<R>>,
    /// Contact phases that have not ended, with their numbers, and the number of the next.
    open: Vec<(u64, ContactPhase<R>)>,
    phases: u64,
    start: (R, Vec<R>, Held),
    /// Time and closed contacts before the next step.
    before: (R, Closed),
    in_flight: bool,
    samplers: Vec<Sampler<R>>,
}

impl<R: Real> Recorder<R> {
    pub(super) fn new(
        sampling: &[Sampling],
        initial: &[R],
        (system, trajectory): (&System, &Trajectory<R>),
    ) -> Self {
        Self {
            counts: Counts::default(),
            latest: None,
            open: Vec::new(),
            phases: 0,
            start: (trajectory.time(), initial.to_vec(), trajectory.held(system)),
            before: (trajectory.time(), Closed::NONE),
            in_flight: false,
            samplers: (sampling.iter())
                .map(|sampling| Sampler::new(sampling.clone(), trajectory))
                .collect(),
        }
    }

    /// Notes the step just made.
    pub(super) fn motion(
        &mut self,
        dense: &Dense<'_, R>,
        trajectory: &Trajectory<R>,
        sink: &mut dyn Sink<R>,
    ) -> ControlFlow<()> {
        let (time, closed) = self.before;
        if dense.step() > R::ZERO && closed == Closed::NONE && !self.in_flight {
            self.in_flight = true;
            self.counts.flights += 1;
        }
        let mut goes_on = ControlFlow::Continue(());
        for (list, sampler) in self.samplers.iter_mut().enumerate() {
            let sampled = sampler.motion(dense, time, closed, trajectory, (list, sink));
            if sampled.is_break() {
                goes_on = sampled;
            }
        }
        let followed = self.follow_phases(trajectory, sink);
        if followed.is_break() {
            goes_on = followed;
        }
        goes_on
    }

    /// Takes the samples that are due before a sequence ends of which no more impacts are followed.
    pub(super) fn within_sequence(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        trajectory: &Trajectory<R>,
        sink: &mut dyn Sink<R>,
    ) -> ControlFlow<()> {
        let Some((on, end)) = trajectory.within_sequence() else {
            return ControlFlow::Continue(());
        };
        for (list, sampler) in self.samplers.iter_mut().enumerate() {
            sampler.within_sequence((system, work), on.clone(), end, (list, sink))?;
        }
        ControlFlow::Continue(())
    }

    /// Opens and ends contact phases where the set of closed contacts has changed.
    pub(super) fn follow_phases(
        &mut self,
        trajectory: &Trajectory<R>,
        sink: &mut dyn Sink<R>,
    ) -> ControlFlow<()> {
        let (time, closed) = (trajectory.time(), trajectory.closed());
        let before = core::mem::replace(&mut self.before, (time, closed)).1;
        if closed == before {
            return ControlFlow::Continue(());
        }
        let mut goes_on = ControlFlow::Continue(());
        for contact in closed.contacts().filter(|&c| !before.contains(c)) {
            let phase = ContactPhase {
                contact,
                start: time,
                end: None,
            };
            let told = sink.contact_phase(self.phases, &phase);
            if told.is_break() {
                goes_on = told;
            }
            self.open.push((self.phases, phase));
            self.phases += 1;
            self.in_flight = false;
        }
        for contact in before.contacts().filter(|&c| !closed.contains(c)) {
            let is_it = |(_, phase): &(u64, ContactPhase<R>)| phase.contact == contact;
            let Some(place) = self.open.iter().position(is_it) else {
                continue;
            };
            let (number, mut phase) = self.open.swap_remove(place);
            phase.end = Some(time);
            let told = sink.contact_phase(number, &phase);
            if told.is_break() {
                goes_on = told;
            }
        }
        goes_on
    }

    /// Notes what happened.
    pub(super) fn event(
        &mut self,
        detail: Occurrence<R>,
        trajectory: &Trajectory<R>,
        sink: &mut dyn Sink<R>,
    ) -> ControlFlow<()> {
        let Some(kind) = detail.kind() else {
            self.latest = None;
            return ControlFlow::Continue(());
        };
        match kind {
            EventKind::Impact => {
                self.counts.impacts += 1;
                self.in_flight = false;
            }
            EventKind::Accumulation => self.counts.accumulations += 1,
            EventKind::Release => self.counts.releases += 1,
            EventKind::Graze => self.counts.grazes += 1,
            EventKind::Section => self.counts.sections += 1,
            EventKind::Ambiguity => self.counts.ambiguities += 1,
            EventKind::Cascade => {}
            EventKind::Switch
            | EventKind::Slide
            | EventKind::Leave
            | EventKind::Stick
            | EventKind::Slip
            | EventKind::Reset => self.counts.switches += 1,
        }
        for sampler in &mut self.samplers {
            sampler.event(trajectory);
        }
        let event = self.latest.insert(Event {
            time: trajectory.time(),
            state: trajectory.state().to_vec(),
            kind,
            detail,
        });
        sink.event(event)
    }

    /// The event that the latest occurrence became.
    pub(super) fn latest(&self) -> Option<&Event<R>> {
        self.latest.as_ref()
    }

    /// Whether a contact is closed and nothing moves: then, in an autonomous system, nothing ever will. Asked before the step
    /// is noted: it is no part of the run.
    pub(super) fn at_rest(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        trajectory: &Trajectory<R>,
    ) -> bool {
        (trajectory.closed() != Closed::NONE || trajectory.held(system) != Held::default())
            && work.dense().step() > R::ZERO
            && trajectory.is_in_equilibrium(system, work)
    }

    pub(super) fn finish(
        mut self,
        outcome: Outcome,
        (system, trajectory): (&System, &Trajectory<R>),
        sink: &mut dyn Sink<R>,
    ) -> Simulation<R> {
        for (list, sampler) in self.samplers.iter_mut().enumerate() {
            // Nothing comes after this.
            let _ = sampler.hand_over(list, 0, sink);
        }
        let (start_time, start_state, start_held) = self.start;
        let time = match outcome {
            Outcome::Rest => self.before.0,
            _ => trajectory.time(),
        };
        Simulation {
            outcome,
            start_time,
            start_state,
            start_held,
            time,
            state: trajectory.state().to_vec(),
            closed: trajectory.closed(),
            held: trajectory.held(system),
            counts: self.counts,
            events: Vec::new(),
            contact_phases: Vec::new(),
            samples: (self.samplers.into_iter()).map(Sampler::finish).collect(),
        }
    }
}
