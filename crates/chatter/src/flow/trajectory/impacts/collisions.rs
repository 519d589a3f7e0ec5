//! Impacts of several contacts at one instant.
//!
//! *Binary* collisions: of the contacts that touch, the one that closes fastest collides, x+ = x - (1 + r) v W / b, and so on
//! until none that touches closes any more. Contacts that were closed collide like any other. A cascade without a last
//! collision, as of plastic bodies between others, converges geometrically, and is followed to rounding. *Moreau's* law:
//! one impulse vector with 0 <= p, v+ + r v- >= 0, p (v+ + r v-) = 0 for all contacts that touch.
//!
//! Each collision is told by itself, one a call. Where columns of derivatives are carried, they are those of the point of
//! the event while it lasts: m + f s with the shift s = -grad(h) m / v of its time, and m - f s again afterwards. Where
//! flights of several contacts end at once each has a shift of its own (`orders`).

use super::burst::BURST;
use super::cascade::Cascade;
use super::orders::NoDerivative;
use crate::expressions::Tape;
use crate::flow::chatter::LocalPoint;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::flight;
use crate::flow::step::{FOREVER, Workspace, flight_time, legal_rates};
use crate::flow::system::System;
use crate::flow::touch::Touch;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::corners::Earlier;
use crate::model::Simultaneous;
use crate::numerics::complementarity::complementary;
use crate::numerics::{Real, WithTerms, two_sum};

/// So many collisions of an instant are told one by one; what follows of a cascade is told as a whole.
const TOLD: u64 = 64;

/// A cascade has converged long before, whatever the restitution, unless one body is a million times as heavy as another.
const MOST: u64 = 1_000_000;

/// A cascade that is told as a whole stops where no rate is closing by more than rounding; what it would still do to the rates
/// of contacts beside is a few times that.
const SETTLED_LEVELS: f64 = 64.0;

/// Outcomes of two orders of collisions are one if they agree to this part of the greatest rate.
const SAME_OUTCOME: f64 = 1e-9;

/// Collisions that are still to come at the present instant.
#[derive(Clone, Debug)]
pub(in crate::flow::trajectory) struct Collisions<R> {
    touching: Closed,
    law: Simultaneous,
    /// The contact whose flight ended first, if the flight of one did.
    came: Option<usize>,
    /// How many there were so far.
    count: u64,
    /// The rate before the latest.
    latest: R,
    /// The mode before them.
    mode: usize,
    /// How the state stood to corners before them.
    sides: Earlier,
    /// The greatest rate that each contact of the system has had at this instant, in earlier collisions, too: from what a
    /// squeezed body has lost, nothing is told apart any more.
    greatest: Vec<R>,
    /// The shift of the event's time, one a column of derivatives.
    shifts: Vec<R>,
    /// The columns after all collisions, where flights of several contacts end.
    columns: Option<Vec<R>>,
}

impl<R: Real> Trajectory<R> {
    /// Begins the collisions of contacts that touch now, one of which closes, and carries out the first.
    pub(in crate::flow::trajectory) fn collide(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        touching: Closed,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        // More contacts than coordinates may touch at once: then each gap is as near to zero as it is.
        let (state, low) = (self.state.clone(), self.low.clone());
        if self.close_gaps(system, touching).is_err() {
            (self.state, self.low) = (state, low);
        }
        let touch = self.touch_values(system)?;
        let law = self.law_of(&touch, touching);
        let flights = self.ending(&touch, touching);
        let mut columns = None;
        if self.carries_columns() {
            if law == Simultaneous::Moreau && touching.contacts().count() > 1 {
                self.no_derivative = Some(NoDerivative::Joint(contact));
            } else if flights.len() > 1 {
                columns = self.columns_after(system, work, (&flights, touching))?;
                if columns.is_none() {
                    self.note_order(contact, touching);
                }
            }
        }
        let shifts = self.event_columns(system, work, &touch, contact)?;
        self.collisions = Some(Collisions {
            touching,
            law,
            came: flights.first().copied(),
            count: 0,
            latest: R::ZERO,
            mode: self.mode,
            sides: self.standing_now(system),
            greatest: self.greatest_rates(system),
            shifts,
            columns,
        });
        if law == Simultaneous::Binary
            && let Some((contact, other)) = ambiguity(&touch, touching)
        {
            self.no_derivative = Some(NoDerivative::Order(contact));
            return Ok(Some(Occurrence::Ambiguity { contact, other }));
        }
        self.collide_on(system, work)
    }

    /// The next collision of the present instant.
    pub(in crate::flow::trajectory) fn collide_on(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        loop {
            let touching = (self.collisions.as_ref()).map_or(Closed::NONE, |all| all.touching);
            self.ask_at_impacts(system, touching)?;
            let touch = self.touch_values(system)?;
            let Some(collisions) = &mut self.collisions else {
                return Ok(None);
            };
            collisions.note(&touch);
            let (touching, count) = (collisions.touching, collisions.count);
            let Some(fastest) = collisions.fastest_closing(&touch) else {
                self.end_collisions(system, work, &touch)?;
                return Ok(None);
            };
            if count >= MOST {
                return Err(FlowError::ImpactsWithoutEnd {
                    time: self.time.to_f64(),
                    count: MOST as usize,
                });
            }
            let (law, came) = (collisions.law, collisions.came);
            let is_apart = collisions.columns.is_some();
            let can_carry_on = law == Simultaneous::Binary
                && system.rubbing().is_empty()
                && self.touches(system)?.0.is_linear()
                && self.asks_nothing(system, touching)?
                && !self.carries_columns();
            let (impulses, made) = if count >= TOLD && can_carry_on {
                (Vec::new(), self.carry_on(&touch)?)
            } else {
                let impulses = match law {
                    Simultaneous::Binary => self.collide_one(system, &touch, fastest)?,
                    Simultaneous::Moreau => self.moreau(system, &touch, touching)?,
                };
                let made = impulses.len() as u64;
                (impulses, made)
            };
            let done = count + made;
            self.follow_jump(system)?;
            let (before, touch) = (touch, self.touch_values(system)?);
            let ends_flight = count == 0 && came == Some(fastest);
            if self.carries_columns() && law == Simultaneous::Binary && !ends_flight && !is_apart {
                self.note_tie(fastest, touching, (&before, &touch));
            }
            let Some(collisions) = &mut self.collisions else {
                return Ok(None);
            };
            collisions.count = done;
            if let Some(&(_, before, _)) = impulses.last() {
                collisions.latest = before;
            }
            collisions.note(&touch);
            let ended = collisions.fastest_closing(&touch).is_none();
            let error = collisions.rounding(&touch);
            if ended {
                self.end_collisions(system, work, &touch)?;
            }
            if count < TOLD {
                let closed = self.closed;
                let mut told = (impulses.into_iter()).map(|(contact, rate_before, rate_after)| {
                    Occurrence::Impact {
                        contact,
                        rate_before,
                        rate_after,
                        closes: rate_after <= R::ZERO && closed.contains(contact),
                    }
                });
                let first = told.next();
                let captures = core::mem::take(&mut self.pending);
                self.pending.extend(told);
                self.pending.extend(captures);
                return Ok(first);
            }
            if ended {
                return Ok(Some(Occurrence::Cascade {
                    contact: fastest,
                    impacts: done,
                    error,
                }));
            }
        }
    }

    /// One contact collides: its rate before and after. The state is moved.
    fn collide_one(
        &mut self,
        system: &System,
        touch: &Touch<R>,
        contact: usize,
    ) -> Result<Vec<(usize, R, R)>, FlowError> {
        let restitution = touch.restitution[contact].value;
        self.check_restitution(contact, restitution)?;
        let rate = touch.rate[contact].value;
        let after = -(restitution * rate);
        let hit = self.after_collision(system, contact)?;
        let before = (
            core::mem::replace(&mut self.state, hit.0),
            core::mem::replace(&mut self.low, hit.1),
        );
        self.rub_at_impact(system, contact, (after - rate, Some(before)))?;
        Ok(vec![(contact, rate, after)])
    }

    /// Carries on a cascade whose impulses change rates by constant amounts; returns how many collisions that were. The
    /// state is moved.
    fn carry_on(&mut self, touch: &Touch<R>) -> Result<u64, FlowError> {
        let Some(collisions) = &mut self.collisions else {
            return Ok(0);
        };
        let contacts: Vec<usize> = collisions.touching.contacts().collect();
        let mut cascade = Cascade::new(touch, &contacts, &collisions.greatest);
        cascade.carry_on(MOST - collisions.count);
        for (&contact, &greatest) in contacts.iter().zip(cascade.greatest()) {
            collisions.greatest[contact] = greatest;
        }
        for (&contact, &impulse) in contacts.iter().zip(&cascade.impulses) {
            if impulse > R::ZERO {
                self.check_restitution(contact, touch.restitution[contact].value)?;
                self.push(&touch.jump[contact], impulse);
            }
        }
        Ok(cascade.count)
    }

    /// Moreau's impulses: contact, rate before and after of each that gets one. The state is moved.
    fn moreau(
        &mut self,
        system: &System,
        touch: &Touch<R>,
        touching: Closed,
    ) -> Result<Vec<(usize, R, R)>, FlowError> {
        let contacts: Vec<usize> = touching.contacts().collect();
        for &i in &contacts {
            if touch.rate[i].value < -touch.rate[i].level() {
                self.check_restitution(i, touch.restitution[i].value)?;
            }
        }
        let wanted = |&i: &usize| (R::ONE + touch.restitution[i].value) * touch.rate[i].value;
        let q: Vec<R> = contacts.iter().map(wanted).collect();
        let levels: Vec<R> = contacts.iter().map(|&i| touch.rate[i].level()).collect();
        let block = touch.block(&contacts);
        let Some(found) = complementary(&block, &q, &levels) else {
            return Err(self.dependent(&contacts));
        };
        let pushed = (contacts.iter().enumerate()).filter(|&(k, _)| found.p[k] > levels[k]);
        let pushed = pushed.fold(Closed::NONE, |pushed, (_, &i)| pushed.with(i));
        if let Some(contact) = self.jamming(system, (touch, pushed))? {
            return Err(self.jammed(contact));
        }
        let mut impulses = Vec::new();
        for (k, &i) in contacts.iter().enumerate() {
            if found.p[k] > levels[k] {
                let before = touch.rate[i].value;
                let change = (block[k].iter().zip(&found.p))
                    .fold(R::ZERO, |sum, (&by, &p)| by.mul_add(p, sum));
                impulses.push((i, before, before + change));
                self.push(&touch.jump[i], found.p[k]);
            }
        }
        Ok(impulses)
    }

    /// Adds so many times a direction to the coordinates.
    pub(in crate::flow::trajectory) fn push(&mut self, direction: &[R], by: R) {
        for ((x, low), &component) in self.state.iter_mut().zip(&mut self.low).zip(direction) {
            if component != R::ZERO {
                (*x, *low) = two_sum(*x, component.mul_add(by, *low));
            }
        }
    }

    /// No contact that touches closes any more: those that separate are open, those at rest are decided by their forces.
    fn end_collisions(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        touch: &Touch<R>,
    ) -> Result<(), FlowError> {
        let Some(collisions) = self.collisions.take() else {
            return Ok(());
        };
        let mut resting = Closed::NONE;
        let mut separating = Closed::NONE;
        let levels = if collisions.count > TOLD {
            SETTLED_LEVELS
        } else {
            1.0
        };
        let mut apart = Closed::NONE;
        for contact in collisions.touching.contacts() {
            let level = collisions.level(touch, contact) * R::splat(levels);
            if self.is_moved(system, contact, &touch.gap[contact])? {
                apart = apart.with(contact);
            } else if touch.rate[contact].value <= level {
                resting = resting.with(contact);
            } else {
                separating = separating.with(contact);
            }
        }
        let held = Closed(self.closed.0 & !(separating.0 | apart.0));
        self.enter(system, held)?;
        for contact in separating.contacts() {
            self.leave_gap(system, contact, 1);
        }
        self.flight_time = R::splat(FOREVER);
        if resting == Closed::NONE {
            self.put_right(system, None)?;
        }
        self.tell_changes_since(system, &collisions.sides);
        if resting != Closed::NONE {
            self.bring_to_rest(system, work, resting)?;
        }
        // At fixed time again, in the mode that follows.
        self.shift_columns(system, work, &collisions.shifts, -R::ONE)?;
        if let Some(columns) = &collisions.columns {
            self.state[self.coordinates..].copy_from_slice(columns);
            self.low[self.coordinates..].fill(R::ZERO);
        }
        let lone = (collisions.lone()).filter(|_| separating == collisions.touching);
        self.rates_of_instant = collisions.greatest;
        if let Some(contact) = lone {
            let before = (collisions.mode, collisions.latest);
            return self.after_lone_collision(system, work, contact, before);
        }
        self.burst += collisions.count as usize;
        self.after_collisions(system, work, separating)
    }

    /// One impact of one contact, from a mode and a rate: it goes on with a sequence like those that steps apply themselves.
    fn after_lone_collision(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        (fall, rate_before): (usize, R),
    ) -> Result<(), FlowError> {
        let [_, rate, acceleration, jerk] = self.local(system, contact)?.map(|term| term.value);
        self.flight_time = flight_time(rate, acceleration, jerk);
        self.count_impact(contact, rate_before);
        let program = self.program(system)?;
        let at_rest = self.restitution_at_rest(work, program, contact);
        let mut at_rest = at_rest.unwrap_or(R::ONE);
        let crosses = self.mode != fall;
        self.follow_tops(system, (contact, fall, crosses), &mut at_rest);
        let local = LocalPoint {
            rate,
            acceleration,
            jerk,
            restitution: -(rate / rate_before),
            at_rest,
        };
        self.follow_sequence(system, work, program, (contact, local))
    }

    /// Predicts the next flight, and ends sequences of impacts whose flights have become shorter than rounding.
    fn after_collisions(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        separating: Closed,
    ) -> Result<(), FlowError> {
        self.tracker.interrupt();
        self.sequence = 0;
        self.latest_impact = None;
        let mut shortest = R::splat(FOREVER);
        let mut flights = Vec::new();
        for contact in separating.contacts() {
            let [_, rate, acceleration, jerk] = self.local(system, contact)?;
            let time = flight_time(rate.value, acceleration.value, jerk.value);
            flights.push((contact, rate.value, time));
            shortest = shortest.min(time);
        }
        self.flight_time = shortest;
        if shortest <= self.negligible()
            && self.end_burst(system, work, self.burst_within_rounding())?
        {
            return Ok(());
        }
        if self.burst > BURST {
            self.burst = 0;
            self.end_squeeze(system, work)?;
            return Ok(());
        }
        for flight in flights {
            if self.end_stall(system, work, flight)? {
                break;
            }
        }
        Ok(())
    }

    /// Flights shorter than this are a roundoff of the time, or of the longest step before.
    pub(in crate::flow::trajectory) fn negligible(&self) -> R {
        flight::negligible(self.time, self.longest_step)
    }

    /// What is met within this time is met at one instant, as knots are of arguments that are functions of each other: so much can
    /// rounding move a crossing.
    pub(in crate::flow::trajectory) fn instant(&self) -> R {
        const ROUNDOFFS: f64 = 8.0;
        self.negligible() * R::splat(ROUNDOFFS)
    }

    fn check_restitution(&self, contact: usize, value: R) -> Result<(), FlowError> {
        if legal_rates(-R::ONE, value) {
            return Ok(());
        }
        Err(FlowError::Restitution {
            time: self.time.to_f64(),
            contact,
            value: value.to_f64(),
        })
    }

    pub(in crate::flow::trajectory) fn dependent(&self, contacts: &[usize]) -> FlowError {
        FlowError::DependentContacts {
            time: self.time.to_f64(),
            contacts: contacts.to_vec(),
        }
    }

    /// The greatest rates of all contacts since time last passed.
    fn greatest_rates(&self, system: &System) -> Vec<R> {
        let mut rates = self.rates_of_instant.clone();
        rates.resize(system.contacts(), R::ZERO);
        rates
    }

    /// Turns columns at fixed time into those of the event's point; returns the shifts of its time.
    fn event_columns(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        touch: &Touch<R>,
        contact: usize,
    ) -> Result<Vec<R>, FlowError> {
        if !self.carries_columns() {
            return Ok(Vec::new());
        }
        let rate = touch.rate[contact].value;
        let (touches, constants) = self.touches(system)?;
        let [gap, _] = &touches.slopes(constants, (&self.state, &self.low))[contact];
        let shifts: Vec<R> = gap.iter().map(|&slope| -(slope / rate)).collect();
        self.shift_columns(system, work, &shifts, R::ONE)?;
        Ok(shifts)
    }

    /// The state after a time that is next to nothing, of either sign, in the present mode.
    pub(crate) fn a_moment_later(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        by: R,
    ) -> Result<Vec<R>, FlowError> {
        let program = self.program(system)?;
        let constants = self.constants[self.mode].as_ref();
        let constants = constants.ok_or_else(|| self.left_domain())?;
        let start = (&self.state[..], &self.low[..]);
        work.expand_at(&program.tape, &constants.tape, start, by);
        let sum = |i: usize| {
            let terms = work.point.series(i);
            terms.iter().rev().fold(R::ZERO, |sum, &term| sum + term)
        };
        Ok((0..self.state.len()).map(sum).collect())
    }

    /// Moves each column by so much time along the field: to the event's point, or, with the sign turned, back to fixed time.
    pub(in crate::flow::trajectory) fn shift_columns(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        shifts: &[R],
        sign: R,
    ) -> Result<(), FlowError> {
        if shifts.is_empty() {
            return Ok(());
        }
        self.shifts = shifts.to_vec();
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(());
        };
        let start = (&self.state[..], &self.low[..]);
        let size = self.coordinates;
        let mut without: Option<Tape> = None;
        let found = loop {
            let tape = without.as_ref().unwrap_or(&program.tape);
            work.expand_at(tape, &constants.tape, start, R::ONE);
            let field: Vec<R> = (0..size).map(|i| work.point.series(i)[1]).collect();
            if field.iter().all(|f| f.is_finite()) {
                break field;
            }
            // On the surface what a root is taken of is nothing, be it by rounding less.
            match work.point.past_a_root(tape, &constants.tape) {
                Some(left) => without = Some(left),
                None => break field,
            }
        };
        for (column, &shift) in shifts.iter().enumerate() {
            for (i, &f) in found.iter().enumerate() {
                let at = size * (column + 1) + i;
                self.state[at] = (f * sign).mul_add(shift, self.state[at]);
                self.low[at] = R::ZERO;
            }
        }
        Ok(())
    }
}

impl<R: Real> Collisions<R> {
    /// The contact, if there was one collision of one.
    fn lone(&self) -> Option<usize> {
        let mut members = self.touching.contacts();
        let alone = members.next().filter(|_| members.next().is_none());
        alone.filter(|_| self.count == 1)
    }

    /// Takes note of the rates between two collisions.
    fn note(&mut self, touch: &Touch<R>) {
        for (greatest, rate) in self.greatest.iter_mut().zip(&touch.rate) {
            *greatest = greatest.max(rate.value.abs());
        }
    }

    /// A rate this small is none: it is rounding of its terms, or of what it was before the collisions.
    fn level(&self, touch: &Touch<R>, contact: usize) -> R {
        let before = WithTerms::exact(self.greatest[contact]);
        touch.rate[contact].level().max(before.level())
    }

    /// Of the contacts that touch the one that closes fastest, the first of equals.
    fn fastest_closing(&self, touch: &Touch<R>) -> Option<usize> {
        let mut fastest: Option<usize> = None;
        for contact in self.touching.contacts() {
            let rate = touch.rate[contact].value;
            let faster = fastest.is_none_or(|other| rate < touch.rate[other].value);
            if rate < -self.level(touch, contact) && faster {
                fastest = Some(contact);
            }
        }
        fastest
    }

    /// How much of the greatest rates cannot be told from zero.
    fn rounding(&self, touch: &Touch<R>) -> f64 {
        let share = |contact: usize| (self.level(touch, contact) / self.greatest[contact]).to_f64();
        let shares = self.touching.contacts().map(share);
        shares.filter(|share| share.is_finite()).fold(0.0, f64::max)
    }
}

/// Whether the rates after all collisions depend on which of two contacts that close goes first; if so, which.
fn ambiguity<R: Real>(touch: &Touch<R>, touching: Closed) -> Option<(usize, usize)> {
    let contacts: Vec<usize> = touching.contacts().collect();
    let closes = |&&i: &&usize| touch.rate[i].value < -touch.rate[i].level();
    let mut closing: Vec<usize> = contacts.iter().filter(closes).copied().collect();
    if closing.len() < 2 {
        return None;
    }
    closing.sort_by(|&a, &b| {
        let (a, b) = (touch.rate[a].value, touch.rate[b].value);
        a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
    });
    let outcomes: Vec<Option<Vec<f64>>> = (closing.iter())
        .map(|&first| outcome(touch, &contacts, first))
        .collect();
    let scale = touch.rate[closing[0]].value.to_f64().abs();
    let same = |a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| match (a, b) {
        (Some(a), Some(b)) => (a.iter().zip(b)).all(|(a, b)| (a - b).abs() <= SAME_OUTCOME * scale),
        _ => false,
    };
    (1..closing.len())
        .find(|&k| !same(&outcomes[0], &outcomes[k]))
        .map(|k| (closing[0], closing[k]))
}

/// The impulses of all collisions if this contact goes first; none if they have no end.
fn outcome<R: Real>(touch: &Touch<R>, contacts: &[usize], first: usize) -> Option<Vec<f64>> {
    let none = vec![R::ZERO; touch.rate.len()];
    let mut cascade = Cascade::new(touch, contacts, &none);
    cascade.collide(contacts.iter().position(|&i| i == first)?);
    let ends = cascade.carry_on(MOST);
    ends.then(|| cascade.impulses.iter().map(|p| p.to_f64()).collect())
}
