//! What the end of a step leads to: the transition that its guard carries.

use super::{StepResult, Trajectory};
use crate::expressions::Surfaces;
use crate::flow::error::FlowError;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::Transition;
use crate::flow::modes::program::Program;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::flight::Outcome;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touching::{Left, Touching};
use crate::numerics::Real;

impl<R: Real> Trajectory<R> {
    /// Says what a step means whose end (state, remainder and reach) is already in place.
    pub(crate) fn digest(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        result: &StepResult<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        if let Some(told) = self.digest_ordinary(system, program, result) {
            return Ok(told.map(Occurrence::ordinary_impact));
        }
        self.digest_event(system, work, program, result)
    }

    /// Says what a step means that is no ordinary one.
    pub(super) fn digest_event(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        result: &StepResult<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let before = self.doubtful_gap(system, result)?;
        let told = self.follow_event(system, work, program, result)?;
        let stays = before.is_some() && self.doubtful_gap(system, result)? == before;
        self.known_gap = result.gap.filter(|_| stays);
        Ok(told)
    }

    fn follow_event(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        result: &StepResult<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let Outcome {
            step,
            step_low,
            impact,
            flight_time,
        } = result.outcome;
        self.advance_time((step, step_low));
        (self.met, self.met_with) = (None, Surfaces::default());
        let undisturbed =
            (result.event).is_none_or(|index| program.guards[index].section().is_some());
        self.may_have_crossed = !undisturbed || result.touched.is_some();
        // As a contact opens nothing jumps: what another has left, at the same instant perhaps, it has left still.
        let opens = (result.event).is_some_and(|index| {
            matches!(program.guards[index].transition, Transition::Open { .. })
        });
        self.left = if undisturbed || opens {
            self.left.after(self.touching, step)
        } else {
            Left::NONE
        };
        let negligible = self.negligible();
        let balanced = self.balanced(program);
        self.at_instant = if step > negligible {
            Touching::NONE
        } else {
            self.touching
        };
        if !(undisturbed || opens) {
            self.touching = Touching::NONE;
        } else if step > negligible {
            self.touching = balanced;
        }
        if step > negligible {
            self.burst = 0;
            self.rates_of_instant.clear();
            self.longest_step = self.longest_step.max(step);
        }
        if !program.residuals.outputs.is_empty() {
            // An impulse that is in the state already may have taken it off what it slid along.
            let has_collided = (result.event).is_some_and(|index| {
                let transition = &program.guards[index].transition;
                matches!(transition, Transition::Impact { .. }) && result.crowd == Closed::NONE
            });
            self.stay_on_contacts(system, work, !has_collided)?;
        }
        if let Some(index) = result.touched {
            self.touching.set(index, 2);
            self.flight_time = R::splat(FOREVER);
            return self.graze(system, program, index);
        }
        let Some(index) = result.event else {
            // The rest of a predicted flight, if a section or the horizon cut it.
            self.flight_time = self.rest_of_flight(step);
            if result.at_horizon {
                // The state is where the step led, a rounding error of it off: the remainder keeps that, or it would add up
                // from one horizon to the next.
                let late = -self.remaining();
                self.time = self.horizon;
                self.time_low = self.horizon_low + late;
                return Ok(Some(Occurrence::Horizon));
            }
            return Ok(None);
        };
        let guard = &program.guards[index];
        self.ended_by = Some(guard.kind);
        match guard.transition {
            Transition::Reset { section } => {
                self.flight_time = self.rest_of_flight(step);
                self.came_by_jump = result.jumped;
                self.reset(system, work, (section, result.jumped)).map(Some)
            }
            Transition::Cross { section } => {
                if !result.jumped {
                    self.touching.set(index, 1);
                }
                self.flight_time = self.rest_of_flight(step);
                Ok(Some(Occurrence::Section { section }))
            }
            Transition::HandOver { contact } => {
                self.tracker.interrupt();
                self.hand_over(system, work, contact)
            }
            Transition::Open { contact } => {
                self.tracker.interrupt();
                self.let_go(system, work, contact)
            }
            Transition::Meet(corner) => self.meet_corner(system, work, (corner, true)),
            Transition::Part(corner) => self.meet_corner(system, work, (corner, false)),
            Transition::LeaveTable { lookup } => self.leave_table(system, work, lookup),
            Transition::Jam { contact } => Err(self.jammed(contact)),
            Transition::LeaveDomain => Err(self.left_domain()),
            Transition::Impact { contact } if result.crowd == Closed::NONE => {
                self.flight_time = flight_time;
                self.touching.set(index, 1);
                self.meet_contact(system, work, (index, contact), impact)
            }
            Transition::AskImpact { contact } if result.crowd == Closed::NONE => {
                self.ask_impact(system, work, (index, contact))
            }
            Transition::Impact { contact }
            | Transition::AskImpact { contact }
            | Transition::Collide { contact } => {
                let touching = Closed(self.closed.0 | result.crowd.0).with(contact);
                self.collide(system, work, contact, touching)
            }
        }
    }

    /// An impact that the step which ended there has applied.
    pub(super) fn meet_contact(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (index, contact): (usize, usize),
        impact: [R; IMPACT_SCALARS],
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        if impact[2] > R::ZERO && self.only_touches(&impact) {
            return self.pass_by(system, (index, contact), &impact);
        }
        self.touched_at = self.time;
        if let Some(told) = self.moved_apart(system, work, contact, &impact)? {
            return Ok(Some(told));
        }
        if system.corners().is_empty() {
            let program = self.program(system)?;
            return self.after_impact(system, work, program, (contact, &impact));
        }
        self.after_impact_at_corners(system, work, contact, impact)
    }

    /// The closed contacts whose reaction vanishes for good.
    pub(super) fn balanced(&self, program: &Program) -> Touching {
        let mut balanced = Touching::NONE;
        if self.closed == Closed::NONE {
            return balanced;
        }
        for (index, guard) in program.guards.iter().enumerate() {
            if guard.is_balanced(self.touching.get(index)) {
                balanced.set(index, Touching::BALANCED);
            }
        }
        balanced
    }

    fn graze(
        &mut self,
        system: &System,
        program: &Program,
        index: usize,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        self.tracker.interrupt();
        let Some(contact) = program.guards[index].closing() else {
            return Ok(None);
        };
        let [_, rate] = self.local_up_to(system, contact)?;
        Ok(Some(Occurrence::Graze {
            contact,
            rate: rate.value,
        }))
    }
}
