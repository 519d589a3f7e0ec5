//! Where a trajectory starts: the contacts that a state lies on are classified.

use super::{ORDER_CLASSES, Trajectory};
use crate::flow::chatter::ChatterTracker;
use crate::flow::error::FlowError;
use crate::flow::program::{Closed, GuardKind};
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touching::Touching;
use crate::numerics::Real;

/// First guess of the unit of time, before anything is known; a step finds its own size from there.
const FIRST_UNIT: f64 = 0.125;

impl<R: Real> Trajectory<R> {
    /// Starts at a state; contacts that it lies on are classified by their rate, acceleration and jerk.
    ///
    /// # Errors
    /// The state penetrates a contact, or the equations have no finite value there.
    pub fn start(
        system: &System,
        work: &mut Workspace<R>,
        parameters: &[R],
        time: R,
        state: &[R],
    ) -> Result<Self, FlowError> {
        let mut trajectory = Self {
            constants: system.constants(parameters),
            time,
            time_low: R::ZERO,
            state: state.to_vec(),
            low: vec![R::ZERO; state.len()],
            coordinates: system.coordinates(),
            closed: Closed::NONE,
            touching: Touching::NONE,
            reach: [R::ZERO; ORDER_CLASSES],
            flight_time: R::splat(FOREVER),
            horizon: R::splat(FOREVER),
            horizon_low: R::ZERO,
            tracker: ChatterTracker::new(work.tail),
            sequence: 0,
            latest_impact: None,
            instant_impacts: 0,
            completion: None,
            pending: None,
        };
        trajectory.restart(system, work, time, state)?;
        Ok(trajectory)
    }

    /// Starts again elsewhere, as [`start`](Self::start) does, at the same parameter values. Forgets the horizon.
    ///
    /// # Errors
    /// As for [`start`](Self::start); another restart is then needed before the trajectory can go on.
    pub fn restart(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        time: R,
        state: &[R],
    ) -> Result<(), FlowError> {
        self.move_to(system, Closed::NONE, time, state)?;
        for contact in 0..system.contacts() {
            let local = self.local(system, work, contact)?;
            if local[0] < -self.rest_level() {
                return Err(FlowError::Penetrates {
                    contact,
                    gap: local[0].to_f64(),
                });
            }
            if local[0] <= self.rest_level() && local[1].abs() <= self.rest_level() {
                self.rest(system, work, contact)?;
            } else if local[0].abs() <= self.rest_level() && local[1] > R::ZERO {
                self.touch(system, GuardKind::Gap(contact), 1);
            }
        }
        self.pending = None;
        Ok(())
    }

    /// Starts again at a state that differs little from one in which these contacts were closed: they stay so, whatever
    /// the displaced state says. Forgets the horizon.
    ///
    /// # Errors
    /// These contacts cannot be held together.
    pub fn restart_beside(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        closed: Closed,
        time: R,
        state: &[R],
    ) -> Result<(), FlowError> {
        self.move_to(system, closed, time, state)?;
        for contact in closed.contacts() {
            let at_rest = self.at_rest(system, work, contact)?;
            self.take(0..at_rest.len(), &at_rest);
        }
        Ok(())
    }

    /// Says that the state lies on a surface and that this does not count as a crossing: the next one does.
    pub fn leave(&mut self, system: &System, kind: GuardKind) {
        self.touch(system, kind, 1);
    }

    /// Changes the parameter values. A [`restart`](Self::restart) must follow: the phase was found with the old ones.
    pub fn set_parameters(&mut self, system: &System, parameters: &[R]) {
        self.constants = system.constants(parameters);
    }

    fn move_to(
        &mut self,
        system: &System,
        closed: Closed,
        time: R,
        state: &[R],
    ) -> Result<(), FlowError> {
        self.time = time;
        self.time_low = R::ZERO;
        self.state.clear();
        self.state.extend_from_slice(state);
        self.low.clear();
        self.low.resize(state.len(), R::ZERO);
        self.reach = [R::ZERO; ORDER_CLASSES];
        self.reach[ORDER_CLASSES - 1] = R::splat(FIRST_UNIT);
        self.flight_time = R::splat(FOREVER);
        self.set_horizon(R::splat(FOREVER));
        self.tracker.restart();
        self.sequence = 0;
        self.latest_impact = None;
        self.instant_impacts = 0;
        self.completion = None;
        self.pending = None;
        self.enter(system, closed)?;
        self.touching = Touching::NONE;
        Ok(())
    }
}
