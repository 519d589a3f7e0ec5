//! Where a trajectory starts: the contacts that a state lies on are classified.

use super::corners::Crossings;
use super::impacts::stall::Stall;
use super::impacts::tops::Tops;
use super::ordinary::Untold;
use super::{ORDER_CLASSES, Trajectory};
use crate::expressions::Surfaces;
use crate::flow::chatter::ChatterTracker;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::GuardKind;
use crate::flow::sections::sides::Sides;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::{FLIGHT, Settings, System};
use crate::flow::touching::{Left, Touching};
use crate::numerics::{Real, WithTerms};
use std::collections::VecDeque;

/// A start inside an obstacle by this part of the terms of its gap touches it: states are stored and typed with twelve
/// digits and more.
pub(super) const PENETRATION: f64 = 1e-12;

/// First guess of the unit of time, before anything is known; a step finds its own size from there.
const FIRST_UNIT: f64 = 0.125;

/// Whether a gap says that the state is inside an obstacle.
pub(super) fn is_inside<R: Real>(gap: &WithTerms<R>) -> bool {
    gap.value < -slack(gap)
}

/// How far from zero a gap may be that is touched.
pub(super) fn slack<R: Real>(gap: &WithTerms<R>) -> R {
    gap.level().max(R::splat(PENETRATION * gap.terms))
}

impl System {
    /// A trajectory from a state, at the time that this says, with the space for its steps.
    ///
    /// # Errors
    /// As for [`Trajectory::start`].
    pub(crate) fn trajectory_from<R: Real>(
        &self,
        parameters: &[R],
        state: &[R],
    ) -> Result<(Workspace<R>, Trajectory<R>), FlowError> {
        let mut work = self.workspace(&Settings::default());
        let clock = self.model().time.map_or(R::ZERO, |index| state[index]);
        let trajectory = Trajectory::start(self, &mut work, parameters, clock, state)?;
        Ok((work, trajectory))
    }
}

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
        Self::start_on(system, work, parameters, time, (state, Closed::NONE))
    }

    /// The same where these contacts are touched, whatever rounding has left of their gaps: of a state that is zero on them it leaves as
    /// much as of their terms.
    ///
    /// # Errors
    /// As for [`start`](Self::start).
    pub(crate) fn start_on(
        system: &System,
        work: &mut Workspace<R>,
        parameters: &[R],
        time: R,
        (state, on): (&[R], Closed),
    ) -> Result<Self, FlowError> {
        let mut trajectory = Self {
            parameters: parameters.to_vec(),
            constants: Vec::new(),
            knots: 0,
            known_at: Vec::new(),
            touch_constants: Vec::new(),
            law: system.simultaneous(),
            time,
            time_low: R::ZERO,
            state: state.to_vec(),
            low: vec![R::ZERO; state.len()],
            coordinates: system.coordinates(),
            closed: Closed::NONE,
            idle: Closed::NONE,
            mode: FLIGHT,
            flight: FLIGHT,
            regime: Default::default(),
            pieces: Vec::new(),
            touching: Touching::NONE,
            left: Left::NONE,
            at_instant: Touching::NONE,
            sides: Sides::UNKNOWN,
            reach: [R::ZERO; ORDER_CLASSES],
            flight_time: R::splat(FOREVER),
            horizon: R::splat(FOREVER),
            horizon_low: R::ZERO,
            tracker: ChatterTracker::new(work.tail),
            met: None,
            met_with: Surfaces::default(),
            tops: Tops::NONE,
            known_gap: None,
            sequence: 0,
            latest_impact: None,
            touched_at: time,
            started_at: time,
            longest_step: R::ZERO,
            burst: 0,
            crossings: Crossings::none(time),
            silent: (0, time),
            shifts: Vec::new(),
            no_derivative: None,
            tie: None,
            latest_resets: Vec::new(),
            stall: Stall::NONE,
            squeezes: 0,
            rates_of_instant: Vec::new(),
            collisions: None,
            completion: None,
            may_have_crossed: false,
            ended_by: None,
            came_by_jump: false,
            asked_in: None,
            pending: VecDeque::new(),
            untold: Untold::NONE,
        };
        trajectory.restart_on(system, work, time, (state, on))?;
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
        self.restart_on(system, work, time, (state, Closed::NONE))
    }

    fn restart_on(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        time: R,
        (state, on): (&[R], Closed),
    ) -> Result<(), FlowError> {
        self.move_to(system, Closed::NONE, time, state)?;
        self.settle_corners(system, None)?;
        self.pending.clear();
        self.classify(system, work, Some(on))
    }

    /// Classifies the contacts that the state lies on, none of which is closed yet. Nothing is told of those at rest at the
    /// start of a trajectory; those that are touched there anyhow are given.
    pub(super) fn classify(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        start_on: Option<Closed>,
    ) -> Result<(), FlowError> {
        let touch = self.touch_values(system)?;
        let at_start = start_on.is_some();
        let mut touching = start_on.unwrap_or(Closed::NONE);
        let instant = self.instant();
        for (contact, gap) in touch.gap.iter().enumerate() {
            if touching.contains(contact) {
                continue;
            }
            // An event that has led here was met an instant too early or too late.
            let moved = R::splat(touch.rate[contact].terms) * instant;
            if is_inside(gap) && (at_start || gap.value < -moved) {
                let (time, gap) = (self.time.to_f64(), gap.value.to_f64());
                return Err(if at_start {
                    FlowError::Penetrates { contact, gap }
                } else {
                    FlowError::JumpsInside { time, contact, gap }
                });
            }
            if gap.value <= gap.level() {
                touching = touching.with(contact);
            }
        }
        let mut resting = Closed::NONE;
        let mut closing = None;
        for contact in touching.contacts() {
            let rate = touch.rate[contact];
            if rate.value > rate.level() {
                self.leave_gap(system, contact, 1);
            } else if rate.value >= -rate.level() {
                resting = resting.with(contact);
            } else {
                closing = Some(contact);
            }
        }
        if let Some(contact) = closing {
            let told = self.collide(system, work, contact, touching)?;
            self.pending.extend(told);
        } else if resting != Closed::NONE {
            self.bring_to_rest(system, work, resting)?;
            if at_start {
                self.pending.clear();
            }
        }
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
        let mut members = closed.contacts();
        if let (Some(contact), None) = (members.next(), members.next()) {
            let at_rest = self.at_rest(system, work, contact)?;
            self.take(0..at_rest.len(), &at_rest);
            self.settle_corners(system, None)?;
            self.pending.clear();
            return Ok(());
        }
        self.project(system, closed)?;
        self.settle_corners(system, None)?;
        self.pending.clear();
        Ok(())
    }

    /// Says that the state lies on a surface and that this does not count as a crossing: the next one does.
    pub fn leave(&mut self, system: &System, kind: GuardKind) {
        self.touch(system, kind, 1);
    }

    /// Changes the parameter values. A [`restart`](Self::restart) must follow: the mode was found with the old ones.
    pub fn set_parameters(&mut self, parameters: &[R]) {
        self.parameters.clear();
        self.parameters.extend_from_slice(parameters);
        self.constants.clear();
        self.pieces.clear();
        self.touch_constants.clear();
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
        (self.met, self.met_with) = (None, Surfaces::default());
        self.tops = Tops::NONE;
        self.known_gap = None;
        self.sequence = 0;
        self.latest_impact = None;
        self.touched_at = time;
        self.started_at = time;
        self.longest_step = R::ZERO;
        self.burst = 0;
        self.silent = (0, time);
        self.latest_resets.clear();
        self.rates_of_instant.clear();
        self.collisions = None;
        self.completion = None;
        self.may_have_crossed = false;
        self.pending.clear();
        self.closed = Closed::NONE;
        self.idle = Closed::NONE;
        self.place_on_sides(system)?;
        self.enter(system, closed)?;
        self.touching = Touching::NONE;
        self.left = Left::NONE;
        self.sides = Sides::UNKNOWN;
        Ok(())
    }
}
