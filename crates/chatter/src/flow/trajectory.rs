//! One trajectory: its state, its phase, and the mode machine that says what an event leads to.
//!
//! The phase, not a nudge, says on which side of a surface the state is: a guard that is `touching` has so many roots at
//! the start of the next step, which are divided out. Intervals are half open: an event at the end of a step belongs to
//! it, one at the start does not.

use super::chatter::{Accumulation, ChatterTracker, LocalPoint};
use super::error::FlowError;
use super::occurrence::Occurrence;
use super::program::{Closed, GuardKind, LOCAL_SCALARS, Program, ProgramConstants};
use super::resolve::{Resolution, resolve};
use super::step::{FOREVER, NO_EVENT, ORDER_CLASSES, Workspace, legal_rates};
use super::system::System;
use super::touching::Touching;
use crate::expressions::Operand;
use crate::numerics::polynomial::magnitude;
use crate::numerics::{Real, two_sum};

/// A quantity this small against the state and its rate of change counts as zero where a trajectory starts, or where a
/// contact comes to rest: given states are rarely good to more digits.
const REST: f64 = 1e-13;

/// A section contains the state at the end of a chatter sequence if it is this small there against what it was at the
/// latest impact, or would become at the pace it had then.
const AT_REST: f64 = 1e-12;

/// An order is used up to this part of the time that it reaches: a prediction is not exact.
const REACH_USED: f64 = 0.95;

/// Rounding errors of the flights of a sequence add up like the steps of a random walk of this many roundoffs each.
const WALK_ROUNDOFFS: f64 = 4.0;

/// First guess of the unit of time, before anything is known; a step finds its own size from there.
const FIRST_UNIT: f64 = 0.125;

/// More impacts at one instant than this are no sequence of collisions of several contacts.
const INSTANT_IMPACTS: usize = 1000;

/// A trajectory, at a time and state, in a phase.
#[derive(Clone, Debug)]
pub struct Trajectory<R> {
    pub(crate) constants: Vec<Option<ProgramConstants<R>>>,
    time: R,
    time_low: R,
    pub(crate) state: Vec<R>,
    pub(crate) low: Vec<R>,
    /// How many of the states are the model's own; columns of derivatives follow.
    coordinates: usize,
    pub(crate) closed: Closed,
    /// Per guard of the phase's program: how many roots lie at the present state.
    pub(crate) touching: Touching,
    pub(crate) reach: [R; ORDER_CLASSES],
    pub(crate) flight_time: R,
    horizon: R,
    tracker: ChatterTracker<R>,
    /// How many impacts the sequence has so far: each slower than the one before, at one contact.
    sequence: u64,
    /// Contact and incoming rate of the latest impact.
    latest_impact: Option<(usize, R)>,
    instant_impacts: usize,
    /// The end of a chatter sequence whose latest impact has been told of, but which has not been moved to.
    completion: Option<(usize, Accumulation<R>)>,
    pending: Option<Occurrence<R>>,
}

/// What the kernel found for one trajectory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepResult<R> {
    pub step: R,
    pub event: Option<usize>,
    pub touched: Option<usize>,
    pub at_horizon: bool,
    pub impact: [R; super::program::IMPACT_SCALARS],
    pub flight_time: R,
}

impl<R: Real> StepResult<R> {
    /// Whether a step without event goes all the way of the time left, whose product with a unit of time is rounded.
    pub(crate) fn reaches(step: R, remaining: R) -> bool {
        step >= remaining * R::splat(1.0 - 4.0 * R::ROUNDOFF)
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
        self.horizon = R::splat(FOREVER);
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

    /// Time, as the sum of a leading part and its rounding remainder.
    pub fn time_parts(&self) -> (R, R) {
        (self.time, self.time_low)
    }

    /// Time.
    pub fn time(&self) -> R {
        self.time
    }

    /// State, in the order of the model.
    pub fn state(&self) -> &[R] {
        &self.state
    }

    /// The contacts that are closed.
    pub fn closed(&self) -> Closed {
        self.closed
    }

    /// The time at which the trajectory stops next.
    pub fn horizon(&self) -> R {
        self.horizon
    }

    /// Sets the time at which the trajectory stops next, for [`run_fleet`](super::run_fleet).
    pub fn set_horizon(&mut self, horizon: R) {
        self.horizon = horizon;
    }

    pub(crate) fn remaining(&self) -> R {
        (self.horizon - self.time) - self.time_low
    }

    /// Whether the next call to [`advance`](Self::advance) needs no step.
    pub(crate) fn has_pending(&self) -> bool {
        self.pending.is_some() || self.completion.is_some() || self.remaining() <= R::ZERO
    }

    /// Moves by one step: to the next event, to `horizon`, or as far as one expansion reaches. Tells what happened, if
    /// anything. The workspace's [`dense`](Workspace::dense) output covers the step.
    ///
    /// # Errors
    /// The equations leave their domain, or the mechanics do not determine what follows.
    pub fn advance(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        horizon: R,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        self.horizon = horizon;
        work.step = R::ZERO;
        if let Some(occurrence) = self.pending.take() {
            return Ok(Some(occurrence));
        }
        if let Some((contact, end)) = self.completion.take() {
            return self.complete(system, work, contact, &end).map(Some);
        }
        if self.remaining() <= R::ZERO {
            return Ok(Some(Occurrence::Horizon));
        }
        let program = self.program(system)?;
        let class = self.load(work);
        if !work.try_step(program, class, self.touching) {
            return self.advance_settled(system, work, program);
        }
        let result = self.result(work);
        self.accept(work);
        self.digest(system, work, program, &result)
    }

    /// Moves by a step that could not be certified, with full root isolation.
    pub(crate) fn advance_settled(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let result = match self.settle(work, program) {
            Err(FlowError::UndecidedRelease { .. }) if self.sequence > 0 => {
                // The rate after an impact is none any more.
                let contact = self.latest_impact.map_or(0, |(contact, _)| contact);
                return self.end_here(system, work, contact).map(Some);
            }
            settled => settled?,
        };
        self.accept(work);
        self.digest(system, work, program, &result)
    }

    /// Redoes a step that could not be certified, from this trajectory's state, with full root isolation.
    fn settle(
        &self,
        work: &mut Workspace<R>,
        program: &Program,
    ) -> Result<StepResult<R>, FlowError> {
        let class = self.load(work);
        let resolution = resolve(work, program, class, self.touching)
            .map_err(|unsettled| unsettled.into_error(self.time, &self.state, program))?;
        work.finish(program);
        let stalled = self.time + work.step == self.time
            && work.event == R::splat(NO_EVENT)
            && resolution.touched.is_none()
            && work.step < self.remaining();
        if stalled || !work.state.iter().all(|x| x.is_finite()) {
            return Err(FlowError::LeftDomain {
                time: self.time.to_f64(),
                state: self.state.iter().map(|x| x.to_f64()).collect(),
            });
        }
        let mut result = self.result(work);
        let Resolution { touched, shortened } = resolution;
        result.touched = touched;
        result.at_horizon &= !shortened;
        Ok(result)
    }

    fn program<'s>(&self, system: &'s System) -> Result<&'s Program, FlowError> {
        system
            .program(self.closed)
            .ok_or_else(|| FlowError::DependentContacts {
                time: self.time.to_f64(),
                contacts: self.closed.contacts().collect(),
            })
    }

    /// The order class of the next step and its unit of time.
    pub(crate) fn plan(&self) -> (usize, R) {
        // Every order is asked: where the answer cannot be foreseen, a branch costs more.
        let mut covers = 0_u32;
        for (class, &reach) in self.reach.iter().enumerate() {
            covers |= u32::from(self.flight_time <= reach * R::splat(REACH_USED)) << class;
        }
        if covers == 0 {
            let top = ORDER_CLASSES - 1;
            return (top, self.reach[top]);
        }
        (covers.trailing_zeros() as usize, self.flight_time)
    }

    fn load(&self, work: &mut Workspace<R>) -> usize {
        if let Some(constants) = &self.constants[self.closed.0 as usize] {
            work.load_constants(constants);
        }
        let (class, tau) = self.plan();
        work.state.copy_from_slice(&self.state);
        work.low.copy_from_slice(&self.low);
        work.reach = self.reach;
        work.horizon = self.remaining();
        work.tau = tau;
        class
    }

    fn result(&self, work: &Workspace<R>) -> StepResult<R> {
        let remaining = self.remaining();
        let event = work.event.to_f64();
        StepResult {
            step: work.step,
            event: (event >= 0.0).then_some(event as usize),
            touched: None,
            at_horizon: event == NO_EVENT && StepResult::reaches(work.step, remaining),
            impact: work.impact,
            flight_time: work.flight_time,
        }
    }

    /// Takes over where a step ended.
    fn accept(&mut self, work: &Workspace<R>) {
        self.state.copy_from_slice(&work.state);
        self.low.copy_from_slice(&work.low);
        self.reach = work.reach;
    }

    /// Says what a step means whose end (state, remainder and reach) is already in place.
    #[inline(always)]
    pub(crate) fn digest(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        result: &StepResult<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        self.advance_time(result.step);
        let balanced = self.balanced(program);
        self.touching = Touching::NONE;
        if result.step > R::ZERO {
            self.instant_impacts = 0;
        }
        let undisturbed = match result.event {
            Some(index) => matches!(program.guards[index].kind, GuardKind::Section(_)),
            None => true,
        };
        if undisturbed {
            self.touching = balanced;
        }
        if let Some(index) = result.touched {
            self.touching.set(index, 2);
            self.flight_time = R::splat(FOREVER);
            return self.graze(system, work, program, index);
        }
        let Some(index) = result.event else {
            // The rest of a predicted flight, if a section or the horizon cut it.
            self.flight_time = self.rest_of_flight(result.step);
            if result.at_horizon {
                self.time = self.horizon;
                self.time_low = R::ZERO;
                return Ok(Some(Occurrence::Horizon));
            }
            return Ok(None);
        };
        match program.guards[index].kind {
            GuardKind::Section(section) => {
                self.touching.set(index, 1);
                self.flight_time = self.rest_of_flight(result.step);
                Ok(Some(Occurrence::Section { section }))
            }
            GuardKind::Reaction(contact) => {
                self.open(system, contact, 3)?;
                self.tracker.interrupt();
                Ok(Some(Occurrence::Release { contact }))
            }
            GuardKind::Gap(contact) => {
                self.flight_time = result.flight_time;
                self.touching.set(index, 1);
                self.after_impact(system, work, contact, &result.impact)
            }
        }
    }

    /// What is left of a predicted flight after a step that did not end it.
    fn rest_of_flight(&self, step: R) -> R {
        if self.flight_time < R::splat(FOREVER) && self.flight_time > step {
            self.flight_time - step
        } else {
            R::splat(FOREVER)
        }
    }

    /// The closed contacts whose reaction vanishes for good.
    fn balanced(&self, program: &Program) -> Touching {
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

    fn advance_time(&mut self, step: R) {
        let (time, error) = two_sum(self.time, step);
        let (time, low) = two_sum(time, error + self.time_low);
        self.time = time;
        self.time_low = low;
    }

    fn graze(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        index: usize,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        self.tracker.interrupt();
        match program.guards[index].kind {
            GuardKind::Gap(contact) => {
                let rate = self.local(system, work, contact)?[1];
                Ok(Some(Occurrence::Graze { contact, rate }))
            }
            GuardKind::Reaction(_) | GuardKind::Section(_) => Ok(None),
        }
    }

    #[inline(always)]
    fn after_impact(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        impact: &[R],
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let &[rate_before, rate_after, acceleration, jerk, restitution] = impact else {
            return Ok(None);
        };
        let finite = self.state.iter().all(|x| x.is_finite()) && rate_after.is_finite();
        if !finite {
            return Err(self.left_domain());
        }
        if rate_before >= R::ZERO && self.sequence > 0 {
            return self.end_here(system, work, contact).map(Some);
        }
        self.instant_impacts += 1;
        if self.instant_impacts > INSTANT_IMPACTS {
            return Err(FlowError::ImpactsWithoutEnd {
                time: self.time.to_f64(),
                count: self.instant_impacts,
            });
        }
        if !legal_rates(rate_before, rate_after) {
            return Err(FlowError::Restitution {
                time: self.time.to_f64(),
                contact,
                value: (-rate_after / rate_before).to_f64(),
            });
        }
        let continues = |(before, rate)| before == contact && rate_before > rate;
        if !self.latest_impact.is_some_and(continues) {
            self.sequence = 0;
        }
        self.latest_impact = Some((contact, rate_before));
        self.sequence += 1;
        let occurrence = Occurrence::Impact {
            contact,
            rate_before,
            rate_after,
        };
        let rebounds = rate_after > R::ZERO;
        if !rebounds {
            self.rest(system, work, contact)?;
            return Ok(Some(occurrence));
        }
        if self.closed != Closed::NONE {
            self.follow_impulse(system, work)?;
        }
        let local = LocalPoint {
            rate: rate_after,
            acceleration,
            jerk,
            restitution,
        };
        let end = self.tracker.observe(
            contact,
            local,
            (self.time, self.time_low),
            (&self.state, &self.low),
        );
        let negligible = self.reach[ORDER_CLASSES - 1] * R::splat(R::ROUNDOFF);
        if let Some(end) = end
            && self.ends_undisturbed(system, work, contact, &end)?
        {
            self.completion = Some((contact, end));
        } else if acceleration < R::ZERO && self.flight_time <= negligible {
            // Flights shorter than a roundoff of the time scale, as when several contacts chatter at once: what is left
            // of the sequence is below rounding.
            let after = self.flight_time / (R::ONE - restitution);
            let end = Accumulation {
                after,
                change: vec![R::ZERO; self.state.len()],
                error: after.to_f64(),
            };
            self.completion = Some((contact, end));
        }
        Ok(Some(occurrence))
    }

    /// Whether nothing else happens until the end of a chatter sequence: the trajectory does not stop before, no other
    /// contact closes or opens, no section is crossed. Else the sequence is followed further, until what is left of it is
    /// shorter. A section that contains the state at rest is crossed without end, and never in the way.
    fn ends_undisturbed(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        end: &Accumulation<R>,
    ) -> Result<bool, FlowError> {
        /// Flights back and forth may change a guard by more than one free flight of the same length does.
        const MARGIN: f64 = 2.0;
        if end.after > self.remaining() {
            return Ok(false);
        }
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.closed.0 as usize] else {
            return Ok(true);
        };
        if program.guards.len() < 2 {
            return Ok(true);
        }
        let (state, low) = (&self.state, &self.low);
        work.expand_at(&program.tape, &constants.tape, (state, low), end.after);
        let guards = program
            .guards
            .iter()
            .filter(|guard| guard.kind != GuardKind::Gap(contact));
        let moving = guards.filter_map(|guard| match guard.series {
            Operand::Series(slot) => {
                let p = work.point.series(slot);
                let change = magnitude(&p[1..], R::ONE) * R::splat(MARGIN);
                let size = p[0].abs() + p[1].abs();
                (p[0].abs() <= change).then_some((slot, size))
            }
            Operand::Constant(_) => None,
        });
        let moving: Vec<(usize, R)> = moving.collect();
        if moving.is_empty() {
            return Ok(true);
        }
        let rest: Vec<R> = (state.iter().zip(low).zip(&end.change))
            .map(|((&x, &low), &change)| x + (low + change))
            .collect();
        let zero = vec![R::ZERO; rest.len()];
        work.expand_at(&program.tape, &constants.tape, (&rest, &zero), R::ZERO);
        Ok(moving
            .iter()
            .all(|&(slot, change)| work.point.series(slot)[0].abs() <= change * R::splat(AT_REST)))
    }

    /// Ends a chatter sequence whose rates have sunk into the rounding of the equations: none can be told from zero.
    fn end_here(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Occurrence<R>, FlowError> {
        let end = Accumulation {
            after: R::ZERO,
            change: vec![R::ZERO; self.state.len()],
            error: self.flight_time.min(self.reach[0]).to_f64(),
        };
        self.complete(system, work, contact, &end)
    }

    /// Moves to the end of a chatter sequence.
    fn complete(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        end: &Accumulation<R>,
    ) -> Result<Occurrence<R>, FlowError> {
        for ((x, low), &change) in self.state.iter_mut().zip(&mut self.low).zip(&end.change) {
            (*x, *low) = two_sum(*x, change + *low);
        }
        self.advance_time(end.after);
        let impacts = self.sequence;
        let walk = libm::sqrt(impacts as f64) * R::ROUNDOFF * WALK_ROUNDOFFS;
        let relative = walk.max(work.tail.precision);
        let error = relative.mul_add(self.time.to_f64().abs(), end.error);
        self.rest(system, work, contact)?;
        // The accumulation says more than the capture that ends it.
        self.pending = None;
        Ok(Occurrence::Accumulation {
            contact,
            impacts,
            error,
        })
    }

    /// An impulse at one contact may change the rates of contacts that are closed: they open, or collide in turn.
    fn follow_impulse(
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
    fn rest(
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
    fn take(&mut self, range: core::ops::Range<usize>, values: &[R]) {
        for index in range {
            if self.state[index] != values[index] {
                self.state[index] = values[index];
                self.low[index] = R::ZERO;
            }
        }
    }

    /// The state brought to rest on a contact: gap and rate zero.
    fn at_rest(
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

    fn open(&mut self, system: &System, contact: usize, roots: u8) -> Result<(), FlowError> {
        self.enter(system, self.closed.without(contact))?;
        self.touch(system, GuardKind::Gap(contact), roots);
        self.flight_time = R::splat(FOREVER);
        Ok(())
    }

    /// Changes the phase; guards that both phases have keep their roots at the present state.
    fn enter(&mut self, system: &System, closed: Closed) -> Result<(), FlowError> {
        let before = self.touching;
        let old = system.program(self.closed);
        self.closed = closed;
        let program = self.program(system)?;
        self.touching = Touching::NONE;
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

    fn touch(&mut self, system: &System, kind: GuardKind, roots: u8) {
        let place = system
            .program(self.closed)
            .and_then(|program| program.guards.iter().position(|guard| guard.kind == kind));
        if let Some(index) = place {
            self.touching.set(index, roots);
        }
    }

    /// Gap, rate, acceleration and jerk of a contact in the present phase.
    fn local(
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

    fn left_domain(&self) -> FlowError {
        FlowError::LeftDomain {
            time: self.time.to_f64(),
            state: self.state.iter().map(|x| x.to_f64()).collect(),
        }
    }

    fn rest_level(&self) -> R {
        let coordinates = &self.state[..self.coordinates];
        let largest = coordinates.iter().fold(R::ONE, |most, x| most.max(x.abs()));
        largest * R::splat(REST)
    }
}

impl<R: Real> Workspace<R> {
    /// Order of the latest expansion.
    pub fn order(&self) -> usize {
        self.expansion.order()
    }

    /// The latest step as polynomials: for each state its coefficients in powers of the scaled time, and the scaled and
    /// true length of the step.
    pub fn dense(&self) -> Dense<'_, R> {
        Dense { work: self }
    }
}

/// Dense output of the latest step: the expansion itself.
pub struct Dense<'w, R> {
    work: &'w Workspace<R>,
}

impl<R: Real> Dense<'_, R> {
    /// Length of the step; zero if the latest call moved nowhere.
    pub fn step(&self) -> R {
        self.work.step
    }

    /// Value of a state after a part of the step, `fraction` in [0, 1], before any impact at its end.
    pub fn state(&self, index: usize, fraction: R) -> R {
        let s = self.work.scaled_step * fraction;
        crate::numerics::polynomial::horner(self.work.expansion.series(index), s)
    }
}
