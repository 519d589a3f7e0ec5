//! One trajectory: its state, its mode, and the mode machine that says what an event leads to.
//!
//! The mode, not a nudge, says on which side of a surface the state is: a guard that is `touching` has so many roots at
//! the start of the next step, which are divided out. Intervals are half open: an event at the end of a step belongs to
//! it, one at the start does not.

mod alone;
mod corners;
mod digest;
mod impacts;
mod ordinary;
mod recurrence;
mod reset;
mod rest;
mod roots;
mod settled;
mod start;

use super::chatter::{Accumulation, ChatterTracker};
use super::error::FlowError;
use super::modes::closed::{Closed, Grip};
use super::modes::guard::GuardKind;
use super::modes::limits::Corner;
use super::modes::program::{Program, ProgramConstants};
use super::modes::standing::StandingTapes;
use super::occurrence::Occurrence;
use super::sections::sides::Sides;
use super::step::flight;
use super::step::flight::Outcome;
use super::step::{NO_EVENT, ORDER_CLASSES, Workspace};
use super::system::System;
use super::touch::{TouchConstants, with_terms};
use super::touching::{Left, Touching};
use crate::expressions::{Sides as SurfaceSides, Surfaces};
use crate::model::Simultaneous;
use crate::numerics::dispatch::dispatch_narrow;
use crate::numerics::{Real, WithTerms, index_of};
use alone::{StepAlone, Stepped};
use corners::Crossings;
use impacts::collisions::Collisions;
use impacts::orders::Tie;
pub(crate) use impacts::orders::{NoDerivative, SAME_DERIVATIVE, SAME_RATE, UNFELT, orders};
use impacts::stall::Stall;
use impacts::tops::Tops;
use ordinary::Untold;
pub(crate) use ordinary::{Caught, Passed};
use recurrence::Latest;
use std::collections::VecDeque;

/// A trajectory, at a time and state, in a mode.
#[derive(Clone, Debug)]
pub struct Trajectory<R> {
    /// Those of the model, then those of the pieces of lookups.
    parameters: Vec<R>,
    /// By number of the mode; none where it was never entered.
    pub(crate) constants: Vec<Option<ProgramConstants<R>>>,
    /// How often pieces of lookups have changed, and by number of the mode up to which of these changes constants are known.
    knots: u64,
    known_at: Vec<u64>,
    /// By number of the mode of free flight.
    touch_constants: Vec<Option<TouchConstants<R>>>,
    law: Simultaneous,
    time: R,
    time_low: R,
    pub(crate) state: Vec<R>,
    pub(crate) low: Vec<R>,
    /// How many of the states are the model's own; columns of derivatives follow.
    coordinates: usize,
    pub(crate) closed: Closed,
    /// Those of them that no force is asked of.
    idle: Closed,
    /// Number of the mode in which these are closed.
    pub(crate) mode: usize,
    /// Number of the mode on the same sides of all surfaces in which nothing is closed.
    flight: usize,
    /// The side of each surface.
    regime: SurfaceSides,
    /// The piece of each lookup.
    pieces: Vec<i64>,
    /// Per guard of the mode's program: how many roots lie at the present state.
    pub(crate) touching: Touching,
    /// The guards that were last left from rest, and how long ago.
    left: Left<R>,
    /// What the latest step began with, if it was no longer than rounding.
    at_instant: Touching,
    pub(crate) sides: Sides,
    pub(crate) reach: [R; ORDER_CLASSES],
    pub(crate) flight_time: R,
    horizon: R,
    /// Its rounding remainder.
    horizon_low: R,
    tracker: ChatterTracker<R>,
    /// The corner that ended the latest step.
    met: Option<Corner>,
    /// Surfaces that the motion has come to with it, whatever rounding says: closed contacts keep their rates the same, or an event has
    /// left the state on them.
    met_with: Surfaces,
    /// Surfaces that are crossed at the top of each flight of a sequence of impacts.
    tops: Tops,
    /// The gap of a contact at the present state, where rounding would take its digits.
    known_gap: Option<(usize, R)>,
    /// How many impacts the sequence has so far: each slower than the one before, at one contact.
    sequence: u64,
    /// Contact and incoming rate of the latest impact.
    latest_impact: Option<(usize, R)>,
    /// When a contact was last met, or the start.
    touched_at: R,
    started_at: R,
    /// The longest step since the start.
    longest_step: R,
    /// Impacts since the last flight that was longer than rounding.
    burst: usize,
    /// Corners of gaps that were crossed since then.
    crossings: Crossings<R>,
    /// Steps in a row that could not be certified, took no time and told of nothing, and when the first of them began.
    silent: (usize, R),
    /// By how much each column of derivatives shifts the time of the latest event.
    shifts: Vec<R>,
    /// What has left the columns without a meaning.
    no_derivative: Option<NoDerivative>,
    tie: Option<Tie<R>>,
    /// The latest event on each surface that changes the state.
    latest_resets: Vec<Option<Latest<R>>>,
    /// Impacts whose flights are longer, and lower than gaps are known.
    stall: Stall<R>,
    /// Collisions of squeezed bodies within each other.
    squeezes: usize,
    /// The greatest rates that contacts had in collisions since then.
    rates_of_instant: Vec<R>,
    /// Collisions that are still to come at this instant.
    collisions: Option<Collisions<R>>,
    /// The end of a chatter sequence whose latest impact has been told of, but which has not been moved to.
    completion: Option<(usize, Accumulation<R>)>,
    /// What happened last may have moved the state across a section, of which nothing has been told yet.
    may_have_crossed: bool,
    /// The guard whose zero ended the latest step.
    ended_by: Option<GuardKind>,
    /// Whether the latest event that changed the state came as a jump took the state across its surface.
    came_by_jump: bool,
    /// The mode and the pieces in which the map of the latest impact or reset was found, where it asks for corners of its own.
    asked_in: Option<(usize, Vec<i64>)>,
    pending: VecDeque<Occurrence<R>>,
    untold: Untold<R>,
}

/// What the kernel found for one trajectory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepResult<R> {
    pub outcome: Outcome<R>,
    /// The guard that ended it.
    pub event: Option<usize>,
    pub touched: Option<usize>,
    /// Other contacts that close at the same instant: the impact has not been applied then.
    pub crowd: Closed,
    /// A section was crossed by a jump: the state does not lie on it.
    pub jumped: bool,
    pub at_horizon: bool,
    /// The gap of the contact that was met last, as the flight led to it, if that was cut or begins with one.
    pub gap: Option<(usize, R)>,
}

impl<R: Real> Trajectory<R> {
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

    pub(crate) fn grip(&self) -> Grip {
        Grip {
            closed: self.closed,
            idle: self.idle,
        }
    }

    /// The unit of time of the motion so far, where that is longer than one: its longest step was some of these long.
    pub(crate) fn pace(&self) -> f64 {
        const STEPS: f64 = 8.0;
        const LONGEST: f64 = 1e12;
        (self.longest_step.to_f64() / STEPS).clamp(1.0, LONGEST)
    }

    /// The time at which the trajectory stops next.
    pub fn horizon(&self) -> R {
        self.horizon
    }

    /// The guard whose zero ended the latest step, if one did.
    pub(crate) fn ended_by(&self) -> Option<GuardKind> {
        self.ended_by
    }

    /// Whether the latest event that changed the state came as a jump took the state across its surface, at the instant of that jump.
    pub(crate) fn came_by_jump(&self) -> bool {
        self.came_by_jump
    }

    /// Mode and pieces that the map of the event at the end of the latest step belongs to, if it asks for corners of its own.
    pub(crate) fn asked_in(&self) -> Option<(usize, &[i64])> {
        let (mode, pieces) = self.asked_in.as_ref()?;
        Some((*mode, pieces))
    }

    /// The piece of each lookup.
    pub(crate) fn pieces(&self) -> &[i64] {
        &self.pieces
    }

    /// Sets the time at which the trajectory stops next, for [`run_fleet`](super::run_fleet).
    pub fn set_horizon(&mut self, horizon: R) {
        self.set_horizon_parts((horizon, R::ZERO));
    }

    /// As [`set_horizon`](Self::set_horizon), with the rounding remainder of the time: many periods after the start their
    /// sum is no number of this type.
    pub fn set_horizon_parts(&mut self, (horizon, low): (R, R)) {
        self.horizon = horizon;
        self.horizon_low = low;
    }

    /// Whether no time is left. Asked of the time without its remainder first: what has just been stored as two numbers and is read as
    /// a pair stalls the processor.
    #[inline(always)]
    fn is_over(&self) -> bool {
        let ahead = self.horizon - self.time;
        let is_clear = ahead > self.time.abs() * R::splat(4.0 * R::ROUNDOFF);
        !is_clear && self.remaining() <= R::ZERO
    }

    #[inline(always)]
    pub(crate) fn remaining(&self) -> R {
        let horizon = (self.horizon, self.horizon_low);
        flight::remaining(horizon, (self.time, self.time_low))
    }

    /// Whether the next call to [`advance`](Self::advance) needs no step.
    pub(crate) fn has_pending(&self) -> bool {
        !self.pending.is_empty()
            || self.collisions.is_some()
            || self.completion.is_some()
            || self.remaining() <= R::ZERO
    }

    /// Where no more impacts of a sequence are followed: the same trajectory as it follows them on, and the time of the sequence's end.
    pub(crate) fn within_sequence(&self) -> Option<(Self, R)> {
        let (_, end) = self.completion.as_ref()?;
        let on = Self {
            completion: None,
            ..self.clone()
        };
        Some((on, self.time + end.after))
    }

    /// Whether the next step asks for more than its row in a vector would hold.
    pub(crate) fn steps_alone(&self) -> bool {
        self.known_gap.is_some()
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
        self.set_horizon(horizon);
        self.advance_to_horizon(system, work)
    }

    /// As [`advance`](Self::advance), to the horizon that was set.
    ///
    /// # Errors
    /// As for [`advance`](Self::advance).
    pub fn advance_to_horizon(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        work.step = R::ZERO;
        self.ended_by = None;
        self.asked_in = None;
        if let Some(occurrence) = self.pending.pop_front() {
            return Ok(Some(occurrence));
        }
        if self.collisions.is_some() {
            return self.collide_on(system, work);
        }
        let program = self.program(system)?;
        let stays = self.completion.is_some() || self.is_over();
        if stays && self.may_have_crossed {
            self.may_have_crossed = false;
            if let Some(told) = self.cross_here(system, work, program)? {
                return Ok(Some(told));
            }
        }
        if let Some((contact, end)) = self.completion.take() {
            return self.complete(system, work, contact, &end).map(Some);
        }
        if self.is_over() {
            return Ok(Some(Occurrence::Horizon));
        }
        let step = StepAlone {
            trajectory: self,
            system,
            work,
            program,
        };
        match dispatch_narrow(step) {
            Stepped::Ordinary(told) => Ok(told.map(Occurrence::ordinary_impact)),
            Stepped::Event(result) => self.digest_event(system, work, program, &result),
            Stepped::Uncertain => self.advance_settled(system, work, program),
        }
    }

    #[inline(always)]
    fn program<'s>(&self, system: &'s System) -> Result<&'s Program, FlowError> {
        system
            .program(self.mode)
            .ok_or_else(|| self.dependent(&self.closed.contacts().collect::<Vec<_>>()))
    }

    /// The order class of the next step and its unit of time.
    #[inline(always)]
    pub(crate) fn plan(&self) -> (usize, R) {
        let (class, unit) = flight::plan(self.flight_time, &self.reach);
        (index_of(class.to_f64()), unit)
    }

    #[inline(always)]
    fn load(&self, work: &mut Workspace<R>) -> usize {
        if let Some(constants) = &self.constants[self.mode] {
            work.load_constants(constants);
        }
        let (class, tau) = self.plan();
        work.state.copy_from_slice(&self.state);
        work.low.copy_from_slice(&self.low);
        for (section, side) in work.sides.iter_mut().enumerate() {
            *side = self.sides.get(section);
        }
        work.reach = self.reach;
        work.horizon = self.remaining();
        work.time = self.time;
        work.known_gap = self.known_gap;
        work.longest = self.longest_step;
        work.tau = tau;
        class
    }

    #[inline(always)]
    fn result(&self, work: &Workspace<R>) -> StepResult<R> {
        let remaining = self.remaining();
        let event = work.event.to_f64();
        StepResult {
            outcome: work.outcome(),
            event: (event >= 0.0).then(|| index_of(event)),
            touched: None,
            crowd: Closed::NONE,
            jumped: false,
            at_horizon: event == NO_EVENT && flight::reaches(work.step, remaining),
            gap: None,
        }
    }

    /// Takes over where a step ended.
    #[inline(always)]
    fn accept(&mut self, work: &Workspace<R>) {
        self.state.copy_from_slice(&work.state);
        self.low.copy_from_slice(&work.low);
        self.keep_sides(work);
        self.reach = work.reach;
    }

    #[inline(always)]
    fn keep_sides(&mut self, work: &Workspace<R>) {
        for (section, &side) in work.sides.iter().enumerate() {
            self.sides.set(section, side);
        }
    }

    /// The rate of each coordinate, and how large the terms are that it is the sum of.
    pub(crate) fn rates(&self, system: &System) -> Option<Vec<WithTerms<R>>> {
        let (program, constants) = (
            system.program(self.mode)?,
            self.constants[self.mode].as_ref()?,
        );
        let start = (&self.state[..], &self.low[..]);
        Some(with_terms(&program.field, &constants.field, start))
    }

    /// What is left of a predicted flight after a step that did not end it.
    fn rest_of_flight(&self, step: R) -> R {
        flight::rest_of_flight(self.flight_time, step)
    }

    fn advance_time(&mut self, step: (R, R)) {
        (self.time, self.time_low) = flight::later((self.time, self.time_low), step);
    }

    /// That what must not vanish in the present mode does so, and how near it is to that.
    fn singular_near(&self, system: &System) -> Option<(f64, FlowError)> {
        let state = &self.state[..self.coordinates];
        let (near, kind, expression) = system.singular_at(self.mode, state, &self.parameters)?;
        let time = self.time.to_f64();
        let singular = FlowError::Singular {
            time,
            kind,
            expression,
        };
        Some((near, singular))
    }

    /// That something has no value here: what vanishes that must not, if anything does.
    fn undefined_here(&self, system: &System) -> FlowError {
        match self.singular_near(system) {
            Some((0.0, singular)) => singular,
            _ => self.left_domain(),
        }
    }

    fn left_domain(&self) -> FlowError {
        let state = &self.state[..self.coordinates];
        FlowError::LeftDomain {
            time: self.time.to_f64(),
            state: state.iter().map(|x| x.to_f64()).collect(),
        }
    }
}
