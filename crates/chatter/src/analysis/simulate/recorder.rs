//! Takes note of a trajectory while it moves.

use super::result::{ContactPhase, Counts, Event, EventDetail, Outcome, Simulation};
use super::samples::{Sampler, Sink};
use super::spec::{EventKind, Sampling};
use crate::flow::{Closed, Dense, Occurrence, System, Trajectory, Workspace};
use crate::numerics::Real;
use core::ops::ControlFlow;

pub(super) struct Recorder<R> {
    pub(super) counts: Counts,
    events: Vec<Event<R>>,
    /// Whether the latest occurrence became an event.
    fresh: bool,
    contact_phases: Vec<ContactPhase<R>>,
    start: (R, Vec<R>),
    /// Time and closed contacts before the next step.
    before: (R, Closed),
    in_flight: bool,
    samplers: Vec<Sampler<R>>,
}

impl<R: Real> Recorder<R> {
    pub(super) fn new(sampling: &[Sampling], trajectory: &Trajectory<R>) -> Self {
        let mut recorder = Self {
            counts: Counts::default(),
            events: Vec::new(),
            fresh: false,
            contact_phases: Vec::new(),
            start: (trajectory.time(), trajectory.state().to_vec()),
            before: (trajectory.time(), Closed::NONE),
            in_flight: false,
            samplers: (sampling.iter())
                .map(|&sampling| Sampler::new(sampling, trajectory))
                .collect(),
        };
        recorder.follow_phases(trajectory);
        recorder
    }

    /// Notes the step just made.
    pub(super) fn motion(
        &mut self,
        dense: &Dense<'_, R>,
        trajectory: &Trajectory<R>,
        sink: &mut Option<&mut Sink<'_, R>>,
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
        self.follow_phases(trajectory);
        goes_on
    }

    /// Opens and ends contact phases where the set of closed contacts has changed.
    fn follow_phases(&mut self, trajectory: &Trajectory<R>) {
        let (time, closed) = (trajectory.time(), trajectory.closed());
        let before = self.before.1;
        for contact in closed.contacts().filter(|&c| !before.contains(c)) {
            self.contact_phases.push(ContactPhase {
                contact,
                start: time,
                end: None,
            });
            self.in_flight = false;
        }
        for contact in before.contacts().filter(|&c| !closed.contains(c)) {
            let open = |phase: &&mut ContactPhase<R>| phase.contact == contact;
            if let Some(phase) = self.contact_phases.iter_mut().rev().find(open) {
                phase.end = Some(time);
            }
        }
        self.before = (time, closed);
    }

    /// Notes what happened.
    pub(super) fn event(&mut self, occurrence: Occurrence<R>, trajectory: &Trajectory<R>) {
        self.fresh = true;
        let detail = match occurrence {
            Occurrence::Impact {
                contact,
                rate_before,
                rate_after,
            } => {
                self.counts.impacts += 1;
                self.in_flight = false;
                EventDetail::Impact {
                    contact,
                    rate_before,
                    rate_after,
                    closes: rate_after <= R::ZERO && trajectory.closed().contains(contact),
                }
            }
            Occurrence::Accumulation {
                contact,
                impacts,
                error,
            } => {
                self.counts.accumulations += 1;
                EventDetail::Accumulation {
                    contact,
                    impacts,
                    error,
                }
            }
            Occurrence::Release { contact } => {
                self.counts.releases += 1;
                EventDetail::Release { contact }
            }
            Occurrence::Graze { contact, rate } => {
                self.counts.grazes += 1;
                EventDetail::Graze { contact, rate }
            }
            Occurrence::Section { section } => {
                self.counts.sections += 1;
                EventDetail::Section { section }
            }
            Occurrence::Cascade {
                contact,
                impacts,
                error,
            } => EventDetail::Cascade {
                contact,
                impacts,
                error,
            },
            Occurrence::Ambiguity { contact, other } => {
                self.counts.ambiguities += 1;
                EventDetail::Ambiguity { contact, other }
            }
            Occurrence::Switch { .. }
            | Occurrence::Slide { .. }
            | Occurrence::Leave { .. }
            | Occurrence::Stick { .. }
            | Occurrence::Slip { .. }
            | Occurrence::Reset { .. } => {
                let Some((kind, place, side)) = EventKind::of_corner(&occurrence) else {
                    return;
                };
                self.counts.switches += 1;
                EventDetail::Corner { kind, place, side }
            }
            // The impact before it says so already.
            Occurrence::Capture { .. } | Occurrence::Horizon => {
                self.fresh = false;
                return;
            }
        };
        for sampler in &mut self.samplers {
            sampler.event(trajectory);
        }
        self.events.push(Event {
            time: trajectory.time(),
            state: trajectory.state().to_vec(),
            detail,
        });
    }

    /// The event that the latest occurrence became.
    pub(super) fn latest(&self) -> Option<&Event<R>> {
        self.events.last().filter(|_| self.fresh)
    }

    /// Whether a contact is closed and nothing moves: then, in an autonomous system, nothing ever will. Asked before the step
    /// is noted: it is no part of the run.
    pub(super) fn at_rest(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        trajectory: &Trajectory<R>,
    ) -> bool {
        trajectory.closed() != Closed::NONE
            && work.dense().step() > R::ZERO
            && trajectory.is_in_equilibrium(system, work)
    }

    pub(super) fn finish(
        mut self,
        outcome: Outcome,
        trajectory: &Trajectory<R>,
        sink: &mut Option<&mut Sink<'_, R>>,
    ) -> Simulation<R> {
        for (list, sampler) in self.samplers.iter_mut().enumerate() {
            // Nothing comes after this.
            let _ = sampler.hand_over(list, 0, sink);
        }
        let (start_time, start_state) = self.start;
        let time = match outcome {
            Outcome::Rest => self.before.0,
            _ => trajectory.time(),
        };
        Simulation {
            outcome,
            start_time,
            start_state,
            time,
            state: trajectory.state().to_vec(),
            closed: trajectory.closed(),
            counts: self.counts,
            events: self.events,
            contact_phases: self.contact_phases,
            samples: (self.samplers.into_iter()).map(Sampler::finish).collect(),
        }
    }
}
