//! Contacts at rest: what is closed, what holds it there, and what opens it.

use super::Trajectory;
use crate::expressions::Operand;
use crate::flow::error::FlowError;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, GuardKind, LOCAL_SCALARS};
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touching::{Left, Touching};
use crate::numerics::Real;

/// A quantity this small against the state and its rate of change counts as zero where a trajectory starts, or where a
/// contact comes to rest: given states are rarely good to more digits.
const REST: f64 = 1e-13;

impl<R: Real> Trajectory<R> {
    /// An impulse at one contact may change the rates of contacts that are closed: they open, or collide in turn.
    pub(super) fn follow_impulse(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<(), FlowError> {
        for contact in self.closed.contacts() {
            let local = self.local(system, work, contact)?;
            if local[1].abs() <= self.rest_level() {
                continue;
            }
            // Either way it is an open contact now; an inward rate collides at the start of the next step.
            self.open(system, contact, u8::from(local[1] > R::ZERO))?;
        }
        Ok(())
    }

    /// Brings the state to rest on a contact and decides what holds from there: closed, or lifting off at once.
    pub(super) fn rest(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<(), FlowError> {
        self.tracker.interrupt();
        self.sequence = 0;
        self.latest_impact = None;
        self.flight_time = R::splat(FOREVER);
        let at_rest = self.at_rest(system, work, contact)?;
        // Columns stay as they are if the contact lifts off at once: nothing holds it.
        let coordinates = self.coordinates;
        self.take(0..coordinates, &at_rest);
        let [_, _, acceleration, jerk] = self.local(system, work, contact)?;
        let level = self.rest_level();
        if acceleration > level {
            self.touch(system, GuardKind::Gap(contact), 2);
            return Ok(());
        }
        if acceleration < -level {
            self.take(coordinates..at_rest.len(), &at_rest);
            return self.close(system, work, contact);
        }
        if jerk > level {
            self.touch(system, GuardKind::Gap(contact), 3);
            return Ok(());
        }
        if jerk < -level {
            self.take(coordinates..at_rest.len(), &at_rest);
            self.close(system, work, contact)?;
            self.touch(system, GuardKind::Reaction(contact), 1);
            return Ok(());
        }
        if !self.is_balanced(system, work, contact)? {
            return Err(FlowError::UndecidedRelease {
                time: self.time.to_f64(),
                contact,
            });
        }
        self.take(coordinates..at_rest.len(), &at_rest);
        self.close(system, work, contact)?;
        self.touch(system, GuardKind::Reaction(contact), Touching::BALANCED);
        Ok(())
    }

    /// Whether the gap of a contact at rest stays zero by itself: the field does not move it to any order that is
    /// computed, as in an equilibrium without contact force.
    fn is_balanced(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<bool, FlowError> {
        let program = self.program(system)?;
        let phase = self.closed.0 as usize;
        let guard = program
            .guards
            .iter()
            .find(|guard| guard.kind == GuardKind::Gap(contact));
        let (Some(constants), Some(Operand::Series(slot))) =
            (&self.constants[phase], guard.map(|guard| guard.series))
        else {
            return Ok(false);
        };
        work.expand_at(
            &program.tape,
            &constants.tape,
            (&self.state, &self.low),
            R::ONE,
        );
        let level = self.rest_level();
        Ok(work.point.series(slot).iter().all(|c| c.abs() <= level))
    }

    /// Replaces a range of states; one that does not change keeps its rounding remainder.
    pub(super) fn take(&mut self, range: core::ops::Range<usize>, values: &[R]) {
        for index in range {
            if self.state[index] != values[index] {
                self.state[index] = values[index];
                self.low[index] = R::ZERO;
            }
        }
    }

    /// The state brought to rest on a contact: gap and rate zero.
    pub(super) fn at_rest(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Vec<R>, FlowError> {
        let program = self.program(system)?;
        let mut at_rest = self.state.clone();
        if let Some(constants) = &self.constants[self.closed.0 as usize] {
            work.values_at(
                &program.captures[contact],
                &constants.captures[contact],
                (&self.state, &self.low),
                &mut at_rest,
            );
        }
        Ok(at_rest)
    }

    fn close(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<(), FlowError> {
        self.enter(system, self.closed.with(contact))?;
        self.pending = Some(Occurrence::Capture { contact });
        // The new constraint force may relieve contacts that were closed before.
        loop {
            let program = self.program(system)?;
            let Some(constants) = &self.constants[self.closed.0 as usize] else {
                return Ok(());
            };
            let mut pushes = vec![R::ZERO; self.closed.contacts().count()];
            work.values_at(
                &program.reactions,
                &constants.reactions,
                (&self.state, &self.low),
                &mut pushes,
            );
            let level = self.rest_level();
            let relieved = self
                .closed
                .contacts()
                .zip(pushes)
                .find(|&(other, push)| other != contact && push < -level);
            match relieved {
                Some((other, _)) => self.open(system, other, 2)?,
                None => return Ok(()),
            }
        }
    }

    pub(super) fn open(
        &mut self,
        system: &System,
        contact: usize,
        roots: u8,
    ) -> Result<(), FlowError> {
        self.enter(system, self.closed.without(contact))?;
        self.touch(system, GuardKind::Gap(contact), roots);
        self.flight_time = R::splat(FOREVER);
        Ok(())
    }

    /// Changes the phase; guards that both phases have keep their roots at the present state.
    pub(super) fn enter(&mut self, system: &System, closed: Closed) -> Result<(), FlowError> {
        let before = self.touching;
        let old = system.program(self.closed);
        self.closed = closed;
        let program = self.program(system)?;
        self.touching = Touching::NONE;
        self.left = Left::NONE;
        for (index, guard) in program.guards.iter().enumerate() {
            let same =
                old.and_then(|old| old.guards.iter().position(|other| other.kind == guard.kind));
            let roots = same.map_or(0, |place| before.get(place));
            // A balance holds in one phase.
            if !guard.is_balanced(roots) {
                self.touching.set(index, roots);
            }
        }
        Ok(())
    }

    pub(super) fn touch(&mut self, system: &System, kind: GuardKind, roots: u8) {
        let place = system
            .program(self.closed)
            .and_then(|program| program.guards.iter().position(|guard| guard.kind == kind));
        if let Some(index) = place {
            self.touching.set(index, roots);
        }
    }

    /// Gap, rate, acceleration and jerk of a contact in the present phase.
    pub(super) fn local(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<[R; LOCAL_SCALARS], FlowError> {
        let program = self.program(system)?;
        let mut local = [R::ZERO; LOCAL_SCALARS];
        if let Some(constants) = &self.constants[self.closed.0 as usize] {
            work.values_at(
                &program.locals[contact],
                &constants.locals[contact],
                (&self.state, &self.low),
                &mut local,
            );
        }
        if local.iter().all(|value| value.is_finite()) {
            Ok(local)
        } else {
            Err(self.left_domain())
        }
    }

    pub(super) fn rest_level(&self) -> R {
        let coordinates = &self.state[..self.coordinates];
        let largest = coordinates.iter().fold(R::ONE, |most, x| most.max(x.abs()));
        largest * R::splat(REST)
    }
}
