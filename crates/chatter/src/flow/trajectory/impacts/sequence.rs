//! The sequence that an impact belongs to: it goes on, or chatter ends.

use super::burst::{BURST, LONGEST_BURST};
use crate::expressions::Operand;
use crate::flow::chatter::{Accumulation, LocalPoint, SequenceMap};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::program::Program;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::flight;
use crate::flow::step::flight::ASKED_ROUNDOFFS;
use crate::flow::step::{Workspace, legal_rates};
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::numerics::polynomial::magnitude;
use crate::numerics::{Real, two_sum};

/// A section contains the state at the end of a chatter sequence if it is this small there against what it was at the
/// latest impact, or would become at the pace it had then.
const AT_REST: f64 = 1e-12;

/// Rounding errors of the flights of a sequence add up like the steps of a random walk of this many roundoffs each.
const WALK_ROUNDOFFS: f64 = 4.0;

impl<R: Real> Trajectory<R> {
    #[inline(always)]
    pub(in crate::flow::trajectory) fn after_impact(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        (contact, impact): (usize, &[R]),
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let &[
            rate_before,
            rate_after,
            acceleration,
            jerk,
            restitution,
            at_rest,
        ] = impact
        else {
            return Ok(None);
        };
        let finite = self.state.iter().all(|x| x.is_finite()) && rate_after.is_finite();
        if !finite {
            return Err(self.left_domain());
        }
        if rate_before >= R::ZERO && self.sequence > 0 {
            return self.end_here(system, work, contact).map(Some);
        }
        if self.may_be_rounding(rate_before) {
            let [_, rate] = self.local_up_to(system, contact)?;
            if rate_before.abs() <= rate.level() {
                return self.no_impact(system, work, contact, rate_before).map(Some);
            }
        }
        if !legal_rates(rate_before, rate_after) {
            // A rate that is the sum of large ones is changed by no more than rounding of these is known: what restitution says of it
            // holds all the same.
            let beyond = (-rate_after).max(rate_after + rate_before);
            let [_, rate] = self.local_up_to(system, contact)?;
            if beyond <= rate.level() {
                return self.collide(system, work, contact, self.closed.with(contact));
            }
            return Err(FlowError::Restitution {
                time: self.time.to_f64(),
                contact,
                value: (-rate_after / rate_before).to_f64(),
            });
        }
        self.count_impact(contact, rate_before);
        // What the impulse leaves of a plastic impact's rate is rounding.
        let is_plastic = restitution == R::ZERO;
        let rate_after = if is_plastic { R::ZERO } else { rate_after };
        let told = |closes| Occurrence::Impact {
            contact,
            rate_before,
            rate_after,
            closes,
        };
        let rebounds = rate_after > R::ZERO;
        if !rebounds {
            self.bring_to_rest(system, work, Closed::NONE.with(contact))?;
            return Ok(Some(told(self.closed.contains(contact))));
        }
        let local = LocalPoint {
            rate: rate_after,
            acceleration,
            jerk,
            restitution,
            at_rest,
        };
        self.follow_sequence(system, work, program, (contact, local))?;
        Ok(Some(told(false)))
    }

    /// After an impact that was noted and from which the contact rebounds, its flight predicted: ends the sequence it belongs to where
    /// that has become certain, or is shorter than rounding.
    #[inline(always)]
    pub(super) fn follow_sequence(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        (contact, local): (usize, LocalPoint<R>),
    ) -> Result<(), FlowError> {
        self.burst += 1;
        // Where the force of a contact can no longer be told from none, as where chatter begins with nothing, its jerk leads back.
        let by_jerk = flight::time_by_jerk(local.rate, local.acceleration, local.jerk);
        let flight_time = self.flight_time.min(by_jerk);
        let is_short = flight_time <= self.negligible();
        if system.contacts() > 1 && (is_short || self.burst.is_multiple_of(BURST)) {
            let ends = self.end_burst(system, work, self.burst_within_rounding())?
                || (self.burst >= BURST && self.end_squeeze(system, work)?);
            if ends {
                return Ok(());
            }
            if self.burst > LONGEST_BURST {
                return Err(FlowError::ImpactsWithoutEnd {
                    time: self.time.to_f64(),
                    count: self.burst,
                });
            }
        }
        let flight = (contact, local.rate, self.flight_time);
        if system.contacts() > 1 && !is_short && self.end_stall(system, work, flight)? {
            return Ok(());
        }
        if is_short && system.model().contacts[contact].reset.is_some() {
            return Err(self.resets_without_end(contact));
        }
        let rest_of_sequence = flight::rest_of_sequence(flight_time, local.at_rest);
        self.tracker.keep_pace(contact, self.time, rest_of_sequence);
        let end = if local.at_rest < R::ONE {
            self.sequence_end(system, work, program, (contact, local))
        } else {
            None
        };
        if let Some(end) = end
            && self.ends_undisturbed((system, work), program, contact, &end)
        {
            self.completion = Some((contact, end));
        } else if local.acceleration <= R::ZERO && local.at_rest < R::ONE && is_short {
            // What is left of the sequence is below rounding.
            let after = rest_of_sequence;
            let end = Accumulation {
                after,
                change: vec![R::ZERO; self.state.len()],
                late: Vec::new(),
                error: self.tracker.rest_of_impacts(contact).to_f64(),
            };
            self.completion = Some((contact, end));
        }
        Ok(())
    }

    /// The restitution of an impact of vanishing rate at the present state.
    pub(super) fn restitution_at_rest(
        &self,
        work: &mut Workspace<R>,
        program: &Program,
        contact: usize,
    ) -> Option<R> {
        let tapes = program.sequences[contact].as_ref()?;
        let constants = self.constants[self.mode].as_ref()?;
        let constants = &constants.sequences[contact];
        Some(tapes.restitution(work, constants, (&self.state, &self.low)))
    }

    /// An impact goes on with a sequence where it is slower than the one before, at the same contact.
    #[inline(always)]
    pub(in crate::flow::trajectory) fn count_impact(&mut self, contact: usize, rate: R) {
        let continues = |(before, faster)| before == contact && rate > faster;
        let goes_on = self.latest_impact.is_some_and(continues);
        self.sequence = if goes_on { self.sequence + 1 } else { 1 };
        self.latest_impact = Some((contact, rate));
    }

    /// Whether a rate or a height is so small that it is worth asking what terms it is the sum of.
    #[inline(always)]
    pub(super) fn may_be_rounding(&self, rate: R) -> bool {
        let (largest, _) = flight::largest(&self.state, self.coordinates);
        rate.abs() <= largest * R::splat(ASKED_ROUNDOFFS * R::ROUNDOFF)
    }

    /// A contact is met with a rate that cannot be told from zero: the end of a sequence, or a graze.
    fn no_impact(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        rate: R,
    ) -> Result<Occurrence<R>, FlowError> {
        if self.sequence > 0 {
            return self.end_here(system, work, contact);
        }
        self.graze_at_rest(system, work, contact, rate)
    }

    /// A contact is met with a rate that is rounding, and nothing says what led to it: a graze.
    fn graze_at_rest(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        rate: R,
    ) -> Result<Occurrence<R>, FlowError> {
        self.rest_as_before(system, contact)?;
        self.bring_to_rest(system, work, Closed::NONE.with(contact))?;
        Ok(Occurrence::Graze { contact, rate })
    }

    /// Other contacts that were left from rest in this instant are at rest still: no impact was none to them either.
    fn rest_as_before(&mut self, system: &System, contact: usize) -> Result<(), FlowError> {
        for (index, guard) in self.program(system)?.guards.iter().enumerate() {
            let roots = self.at_instant.get(index);
            let is_other = guard.closing().is_some_and(|other| other != contact);
            if is_other && roots > 1 {
                self.touching.set(index, roots);
            }
        }
        Ok(())
    }

    /// Shows an impact to the tracker; the end of the sequence where it is certain.
    #[inline(always)]
    fn sequence_end(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        program: &Program,
        (contact, local): (usize, LocalPoint<R>),
    ) -> Option<Accumulation<R>> {
        if !self.tracker.may_complete(local) {
            return None;
        }
        let tapes = program.sequences[contact].as_ref()?;
        let constants = self.constants[self.mode].as_ref()?;
        let mut map = SequenceMap {
            tapes,
            constants: &constants.sequences[contact],
            work,
            coordinates: self.coordinates,
            turn: (self.tops).tapes(system, (&self.constants, &self.known_at), contact),
        };
        let time = (self.time, self.time_low);
        let state = (&self.state[..], &self.low[..]);
        (self.tracker).observe((contact, local), time, state, &mut map)
    }

    /// Whether nothing else happens until the end of a chatter sequence: the trajectory does not stop before, no other
    /// contact closes or opens, no section is crossed. Else the sequence is followed further, until what is left of it is
    /// shorter. A section that contains the state at rest is crossed without end, and never in the way.
    fn ends_undisturbed(
        &self,
        (system, work): (&System, &mut Workspace<R>),
        program: &Program,
        contact: usize,
        end: &Accumulation<R>,
    ) -> bool {
        /// Flights back and forth may change a guard by more than one free flight of the same length does.
        const MARGIN: f64 = 2.0;
        if end.after > self.remaining() || !self.ends_alike(system, contact, end) {
            return false;
        }
        let Some(constants) = &self.constants[self.mode] else {
            return true;
        };
        if program.guards.len() < 2 {
            return true;
        }
        let (state, low) = (&self.state, &self.low);
        work.expand_at(&program.tape, &constants.tape, (state, low), end.after);
        let guards = program
            .guards
            .iter()
            .filter(|guard| guard.closing() != Some(contact));
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
            return true;
        }
        let rest: Vec<R> = (state.iter().zip(low).zip(&end.change))
            .map(|((&x, &low), &change)| x + (low + change))
            .collect();
        let zero = vec![R::ZERO; rest.len()];
        work.expand_at(&program.tape, &constants.tape, (&rest, &zero), R::ZERO);
        moving
            .iter()
            .all(|&(slot, change)| work.point.series(slot)[0].abs() <= change * R::splat(AT_REST))
    }

    /// Whether impacts at the end of a sequence have the map of the latest, on the same side of the corners that only they ask for.
    fn ends_alike(&self, system: &System, contact: usize, end: &Accumulation<R>) -> bool {
        let parts = self.state.iter().zip(&self.low).zip(&end.change);
        let rest: Vec<R> = (parts.take(self.coordinates))
            .map(|((&x, &low), &change)| x + (low + change))
            .collect();
        self.asks_alike(system, contact, &rest)
    }

    /// Ends a chatter sequence whose rates have sunk into the rounding of the equations: none can be told from zero. What
    /// impacts before it leave of the sequence is the error of its time: bodies that nothing presses together but others that bounce
    /// on them come to rest at a rate that is rounding long before their gaps are closed, if at all. Where they may as well part, with
    /// rates that are rounding, no end is told: what touches without a rate grazes.
    pub(in crate::flow::trajectory) fn end_here(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Occurrence<R>, FlowError> {
        let Ok(collapse) = self.tracker.rest_of_collapse(contact) else {
            let [_, rate] = self.local_up_to(system, contact)?;
            return self.graze_at_rest(system, work, contact, rate.value);
        };
        let rest = self.tracker.rest_of_impacts(contact).max(collapse);
        let end = Accumulation {
            after: R::ZERO,
            change: vec![R::ZERO; self.state.len()],
            late: Vec::new(),
            error: rest.to_f64(),
        };
        self.complete(system, work, contact, &end)
    }

    fn resets_without_end(&self, contact: usize) -> FlowError {
        FlowError::ResetsWithoutEnd {
            time: self.time.to_f64(),
            contact,
        }
    }

    /// Moves to the end of a chatter sequence.
    pub(in crate::flow::trajectory) fn complete(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        end: &Accumulation<R>,
    ) -> Result<Occurrence<R>, FlowError> {
        if system.model().contacts[contact].reset.is_some() {
            return Err(self.resets_without_end(contact));
        }
        let stopped = self.has_stopped(system, contact)?;
        for ((x, low), &change) in self.state.iter_mut().zip(&mut self.low).zip(&end.change) {
            (*x, *low) = two_sum(*x, change + *low);
        }
        self.advance_time((end.after, R::ZERO));
        let impacts = self.sequence;
        let walk = libm::sqrt(impacts as f64) * R::ROUNDOFF * WALK_ROUNDOFFS;
        let relative = walk.max(work.tail.precision);
        let error = relative.mul_add(self.time.to_f64().abs(), end.error);
        // Friction may hold what comes to rest from this instant on: columns at fixed time are to be those of the motion that follows.
        let held = self.tops.held(contact);
        let may_stick = held.is_some() || !system.rubbing().is_empty();
        let late = if may_stick { &end.late[..] } else { &[] };
        self.shift_columns(system, work, late, R::ONE)?;
        self.met = stopped.or(held).or(self.met);
        self.bring_to_rest(system, work, Closed::NONE.with(contact))?;
        self.shift_columns(system, work, late, -R::ONE)?;
        self.may_have_crossed = true;
        // The accumulation says more than the capture that ends it.
        self.pending
            .retain(|told| !matches!(told, Occurrence::Capture { .. }));
        Ok(Occurrence::Accumulation {
            contact,
            impacts,
            error,
        })
    }
}
