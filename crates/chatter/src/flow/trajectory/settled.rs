//! Steps that could not be certified, and are settled by full root isolation.

use super::{StepResult, Trajectory};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::program::Program;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::resolve::{Resolution, Unsettled, crossed_here, resolve};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::System;
use crate::numerics::Real;

/// So many steps of which nothing is told take time.
const MOST_SILENT: usize = 10_000;

impl<R: Real> Trajectory<R> {
    /// Moves by a step that could not be certified, with full root isolation.
    pub(crate) fn advance_settled(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let result = match self.settle(system, work, program) {
            Err(FlowError::UndecidedRelease { contact, .. })
                if self.roots(system, GuardKind::Gap(contact)) == 1 =>
            {
                // The rate after an impact is none any more. Where contacts chatter in turn, all their impacts of this instant
                // led to it.
                self.sequence = self.sequence.max(self.burst as u64);
                return self.end_here(system, work, contact).map(Some);
            }
            settled => settled?,
        };
        self.accept(work);
        let told = self.digest(system, work, program, &result)?;
        let (count, since) = self.silent;
        let has_moved = (self.time - since).abs() > self.negligible();
        self.silent = match told.is_some() || has_moved {
            true => (0, self.time),
            false => (count + 1, since),
        };
        // What grows without bound comes to no end of numbers by steps that columns of derivatives are made units between.
        if self.silent.0 > MOST_SILENT {
            return Err(self.undefined_here(system));
        }
        Ok(told)
    }

    /// Redoes a step that could not be certified, from this trajectory's state, with full root isolation.
    fn settle(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
    ) -> Result<StepResult<R>, FlowError> {
        if let Some(leaving) = self.vector_left(system, program) {
            return self.leave_zero(system, work, leaving);
        }
        let class = self.load(work);
        let mut resolved = resolve(work, program, class, (self.touching, self.left));
        let is_untold = work.event == R::splat(NO_EVENT) && work.is_untold();
        let mut at_root = None;
        if program.roots_at_sides && is_untold && resolved.is_ok() {
            at_root = self.come_to_root(system, work, (program, None));
            if at_root.is_none() {
                let class = self.load(work);
                resolved = resolve(work, program, class, (self.touching, self.left));
            }
        }
        let resolution = match (at_root, resolved) {
            (Some(resolution), _) => resolution,
            (None, Ok(mut resolution)) => {
                // A root ends where what it is taken of only touches zero.
                let ends = |&index: &usize| program.guards[index].ends_a_root(&program.tape);
                if let Some(index) = resolution.touched.filter(ends) {
                    work.event = R::splat(index as f64);
                    resolution.touched = None;
                }
                work.travel();
                resolution
            }
            (None, Err(unsettled)) => {
                let singular = match unsettled {
                    Unsettled::Singular { which, .. } => Some(which),
                    Unsettled::NotFinite => work.vanishing(program),
                    Unsettled::Stuck(_) => None,
                };
                // Next to a root what it drives seems to vanish as soon.
                let other = |nearest: &usize| singular.is_some_and(|which| which != *nearest);
                let nearest = work.vanishing(program).filter(other);
                let mut tried = singular.into_iter().chain(nearest);
                let off =
                    tried.find_map(|which| self.step_off_root(system, work, (program, which)));
                let off = off.or_else(|| self.come_to_root(system, work, (program, singular)));
                let start = (self.time, &self.state[..self.coordinates]);
                off.ok_or_else(|| unsettled.into_error(start, (system, program)))?
            }
        };
        let crowd = self.crowd(work, program);
        if crowd == Closed::NONE {
            work.collide(program);
        }
        if !work.state.iter().all(|x| x.is_finite()) {
            return Err(self.left_domain());
        }
        let mut result = self.result(work);
        let Resolution {
            touched,
            shortened,
            jumped,
        } = resolution;
        result.touched = touched;
        result.jumped = jumped;
        result.at_horizon &= !shortened;
        result.crowd = crowd;
        let gap = |slot, roots| work.value_at_end(&program.tape, slot, roots);
        result.gap = self.gap_at_end((program, self.touching), &result, gap);
        Ok(result)
    }

    /// The contacts beside the one that ended the step whose gaps cannot be told from zero there.
    fn crowd(&self, work: &Workspace<R>, program: &Program) -> Closed {
        let event = work.event.to_f64();
        let at = |index: usize| index as f64 == event;
        let mut crowd = Closed::NONE;
        for (index, guard) in program.guards.iter().enumerate() {
            if let Some(contact) = guard.closing()
                && !at(index)
                && work.closes_too(program, index, self.touching)
            {
                crowd = crowd.with(contact);
            }
        }
        let impact = (program.guards.iter().enumerate())
            .any(|(index, guard)| at(index) && guard.closing().is_some());
        if impact { crowd } else { Closed::NONE }
    }

    /// Whether the latest event took the trajectory across a section; and if so, whether by a jump.
    pub(super) fn crosses_here(&self, system: &System, work: &mut Workspace<R>) -> Option<bool> {
        let program = system.program(self.mode)?;
        let class = (system.sections() > 0).then(|| self.load(work))?;
        crossed_here(work, program, class, (self.touching, self.flight_time))
    }

    /// Tells of a section that the latest event took the trajectory across, before the next event or the end.
    pub(super) fn cross_here(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let Some(jumped) = self.crosses_here(system, work) else {
            return Ok(None);
        };
        let mut result = self.result(work);
        (result.outcome.step, result.outcome.step_low) = (R::ZERO, R::ZERO);
        result.event = Some(work.event.to_f64() as usize);
        result.jumped = jumped;
        result.gap = self.known_gap;
        self.keep_sides(work);
        let told = self.digest(system, work, program, &result)?;
        // There may be another.
        self.may_have_crossed = true;
        Ok(told)
    }
}
