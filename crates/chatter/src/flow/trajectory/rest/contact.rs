//! Contacts at rest: which of them stay closed, what holds them, and what opens them.
//!
//! The forces of contacts at rest obey 0 <= l, 0 <= a, l a = 0: who pushes stays closed, who does not push may rise. Where
//! neither force nor acceleration can be told from zero, the jerk decides, as at release.

use crate::expressions::Operand;
use crate::flow::error::FlowError;
use crate::flow::modes::at_contacts::LOCAL_SCALARS;
use crate::flow::modes::closed::{Closed, Grip};
use crate::flow::modes::guard::{Guard, GuardKind};
use crate::flow::occurrence::Occurrence;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touch::{operands_with_terms, with_terms};
use crate::flow::touching::{Left, Touching};
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::corners::Candidate;
use crate::numerics::complementarity::{Complementary, complementary};
use crate::numerics::{Real, WithTerms};

/// So often contacts that are balanced are asked whether they are so on the sides that follow, too.
const MOST_BALANCES: usize = 4;

/// By how much a contact that carries pushes.
#[derive(Clone, Copy, Debug)]
struct Push<R> {
    contact: usize,
    /// In parts of what changes its own rate.
    force: R,
    /// What cannot be told from zero.
    level: R,
}

/// What contacts at rest do: forces p and accelerations w, one of which is zero for each.
struct Forces<R> {
    /// How an impulse at one of them changes the rates of all.
    block: Vec<Vec<R>>,
    found: Complementary<R>,
    /// What cannot be told from zero.
    level: R,
}

/// The forces of contacts at rest on some sides, those that are held by them, and those that are undecided.
type Trial<R> = (Forces<R>, Closed, Closed);

impl<R: Real> Trajectory<R> {
    /// Brings contacts to rest, beside those that are closed already, and decides which of all these stay closed.
    pub(in crate::flow::trajectory) fn bring_to_rest(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        resting: Closed,
    ) -> Result<(), FlowError> {
        self.tracker.interrupt();
        self.sequence = 0;
        self.latest_impact = None;
        self.left = Left::NONE;
        self.flight_time = R::splat(FOREVER);
        let resting = Closed(resting.0 | self.just_left(system).0);
        let all = Closed(self.closed.0 | resting.0);
        let (before, sides) = (self.closed, self.standing_now(system));
        for _ in 0..MOST_BALANCES {
            let mut members = all.contacts();
            if let (Some(contact), None) = (members.next(), members.next()) {
                self.settle_one(system, work, contact)?;
            } else {
                self.settle_all(system, work, all)?;
            }
            // A balance holds in one mode: it is asked for anew on the sides that contacts open to.
            let balanced_in = (!self.balanced_contacts(system)?.is_empty()).then_some(self.mode);
            self.put_right(system, None)?;
            if balanced_in.is_none_or(|mode| mode == self.mode) {
                break;
            }
        }
        self.settle_order(system);
        let captured = self.closed.contacts().filter(|&c| !before.contains(c));
        (self.pending).extend(captured.map(|contact| Occurrence::Capture { contact }));
        self.tell_changes_since(system, &sides);
        Ok(())
    }

    /// Contacts that are open, and at rest in this instant: what comes to rest beside them may keep them closed.
    fn just_left(&self, system: &System) -> Closed {
        let at_rest = |&contact: &usize| self.roots(system, GuardKind::Gap(contact)) > 1;
        (0..system.contacts())
            .filter(at_rest)
            .fold(Closed::NONE, Closed::with)
    }

    /// A single contact at rest: closed, or lifting off at once.
    fn settle_one(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<(), FlowError> {
        self.enter(system, Closed::NONE)?;
        let at_rest = self.at_rest(system, work, contact)?;
        // Columns stay as they are if the contact lifts off at once: nothing holds it.
        let coordinates = self.coordinates;
        self.take(0..coordinates, &at_rest);
        self.put_right(system, None)?;
        if !system.rubbing().is_empty() {
            let touch = self.touch_values(system)?;
            if self.jamming(system, (&touch, Closed::NONE.with(contact)))? == Some(contact) {
                return Err(self.jammed(contact));
            }
        }
        let mut acceleration = self.acceleration(system, contact)?;
        // What slides along holds nothing that moves with it a moment later.
        if acceleration.value.abs() <= acceleration.level()
            && !self.jerks(system, contact)?
            && self.hold_by_contacts(
                system,
                (Closed::NONE.with(contact), Closed::NONE.with(contact)),
            )?
        {
            acceleration = self.acceleration(system, contact)?;
        }
        let opens = acceleration.value > acceleration.level();
        if opens && self.opens_in_flight(system, contact)? {
            self.leave_gap(system, contact, 2);
            return Ok(());
        }
        if acceleration.value < -acceleration.level() {
            self.take(coordinates..at_rest.len(), &at_rest);
            return self.enter(system, Closed::NONE.with(contact));
        }
        if self.settle_by_jerk(system, work, contact)? {
            self.take(coordinates..at_rest.len(), &at_rest);
        }
        Ok(())
    }

    /// Several contacts at rest: which of them stay closed, with the sides of the corners that the state lies on.
    ///
    /// Dry friction resists what opens, up to its limit: so it is taken first. Where contacts do not open as was taken, because
    /// what slides is held by more than them, the corners are put right as if no contact held the state.
    fn settle_all(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        all: Closed,
    ) -> Result<(), FlowError> {
        // Impulses that make rates zero move by rounding what sticks: the state is on what has been closed already, and what sticks is
        // put back.
        if self.closed.0 != all.0 {
            self.project(system, all)?;
            self.stay_on_surfaces(system)?;
        }
        if system.corners().is_empty() {
            return self.settle_together(system, work, all);
        }
        let (before, sides) = (self.clone(), self.standing_sides());
        if self.may_stick(system, all)? {
            if self.stick_together(system, all).unwrap_or(false) {
                return self.hold_columns_on_contacts(system);
            }
            self.clone_from(&before);
        }
        self.resist_opening(system, all)?;
        let settled = self.settle_together(system, work, all);
        if settled.is_ok()
            && self.put_right(system, None).is_ok()
            && self.opens_apart(system, all)?
        {
            return Ok(());
        }
        *self = before;
        self.enter(system, Closed::NONE)?;
        if self.put_right(system, None).is_err() {
            self.try_sides(system, &sides)?;
        }
        self.settle_together(system, work, all)
    }

    /// Whether contacts at rest that have opened move apart.
    fn opens_apart(&self, system: &System, all: Closed) -> Result<bool, FlowError> {
        for contact in Closed(all.0 & !self.closed.0).contacts() {
            let [_, _, acceleration, jerk] = self.local(system, contact)?;
            let first = if acceleration.value.abs() > acceleration.level() {
                acceleration.value
            } else {
                jerk.value
            };
            if first <= R::ZERO {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Forces and accelerations of contacts at rest, on the sides that hold now.
    fn forces_at_rest(&self, system: &System, contacts: &[usize]) -> Result<Forces<R>, FlowError> {
        let touch = self.touch_values(system)?;
        let all = contacts.iter().fold(Closed::NONE, |all, &i| all.with(i));
        if let Some(contact) = self.jamming(system, (&touch, all))? {
            return Err(self.jammed(contact));
        }
        let free: Vec<R> = (contacts.iter())
            .map(|&i| touch.acceleration[i].value)
            .collect();
        let block = touch.block(contacts);
        // A force is told from zero by all that it balances.
        let terms = |&i: &usize| touch.acceleration[i].level();
        let level = contacts.iter().map(terms).fold(R::ZERO, R::max);
        let levels = vec![level; contacts.len()];
        let Some(found) = complementary(&block, &free, &levels) else {
            return Err(self.dependent(contacts));
        };
        Ok(Forces {
            block,
            found,
            level,
        })
    }

    /// Whether the contacts that are closed stay so on the sides that hold now: none of them pulls, with the friction that sticks; and
    /// whether all of them push.
    pub(in crate::flow::trajectory) fn contacts_stay(&self, system: &System) -> [bool; 2] {
        let Ok(reactions) = self.reactions(system) else {
            return [false; 2];
        };
        let stays = reactions.iter().all(|push| push.force >= -push.level);
        [stays, reactions.iter().all(|push| push.force > push.level)]
    }

    /// By how much the contacts that carry push in the present mode.
    fn reactions(&self, system: &System) -> Result<Vec<Push<R>>, FlowError> {
        if self.closed == Closed::NONE {
            return Ok(Vec::new());
        }
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(Vec::new());
        };
        let start = (&self.state[..], &self.low[..]);
        let pushing = |guard: &Guard| Some((guard.opening()?, guard.series));
        let (contacts, places): (Vec<usize>, Vec<Operand>) =
            program.guards.iter().filter_map(pushing).unzip();
        let forces = operands_with_terms(&program.tape, &constants.tape, start, &places);
        // A force is told from zero by all that it balances, which formulas may have cancelled.
        let greatest = self.touch_values(system)?.greatest_accelerations();
        let level = (self.closed.contacts())
            .map(|contact| WithTerms::exact(greatest[contact]).level())
            .fold(R::ZERO, R::max);
        let all = contacts.into_iter().zip(forces);
        Ok(all
            .map(|(contact, force)| Push {
                contact,
                force: force.value,
                level: level.max(force.level()),
            })
            .collect())
    }

    /// Whether any of several contacts at rest has friction and does not slide.
    fn may_stick(&self, system: &System, all: Closed) -> Result<bool, FlowError> {
        for rubbing in system.rubbing() {
            if all.contains(rubbing.contact) {
                let rate = self.rate_of_sliding(system, rubbing.contact)?;
                if rate.is_some_and(|rate| rate.value.abs() <= rate.level()) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Several contacts at rest, some of which may stick: their friction decides about the forces of the others, and these about what
    /// it can hold. All are taken as closed, on the sides that follow from that; one that pulls opens, the one that pulls most first,
    /// until all push. Whether what is left holds: so it is one of the motions of contacts that obey Coulomb's law, be their forces
    /// determined or not. The mode may be any if it does not.
    fn stick_together(&mut self, system: &System, all: Closed) -> Result<bool, FlowError> {
        self.enter(system, all)?;
        while self.closed != Closed::NONE {
            self.put_right(system, None)?;
            let reactions = self.reactions(system)?;
            let weakest = reactions.iter().reduce(|a, b| {
                let is_less = b.force / b.level < a.force / a.level;
                if is_less { b } else { a }
            });
            let Some(&Push {
                contact,
                force,
                level,
            }) = weakest
            else {
                break;
            };
            if force > level {
                break;
            }
            // What neither pushes nor pulls is decided by derivatives, and idle contacts may push in the place of others.
            if force >= -level || self.idle != Closed::NONE {
                return Ok(false);
            }
            self.enter(system, self.closed.without(contact))?;
        }
        for contact in Closed(all.0 & !self.closed.0).contacts() {
            let acceleration = self.acceleration(system, contact)?;
            if acceleration.value <= acceleration.level() {
                return Ok(false);
            }
            self.leave_gap(system, contact, 2);
        }
        Ok(true)
    }

    /// By complementarity of the contacts' forces and accelerations, on the sides that hold now and on those that contacts
    /// take over.
    fn settle_together(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        all: Closed,
    ) -> Result<(), FlowError> {
        let contacts: Vec<usize> = all.contacts().collect();
        let mut free: Option<(Candidate, Trial<R>)> = None;
        let (forces, held, undecided) = loop {
            let forces = self.forces_at_rest(system, &contacts)?;
            let (found, level) = (&forces.found, forces.level);
            let opens = |&contact: &usize| {
                (contacts.iter().zip(&found.w)).any(|(&other, &w)| other == contact && w > level)
            };
            // What would open if friction had to be held stays if friction holds all.
            if let Some((sides, found)) =
                free.take_if(|(_, (.., undecided))| undecided.contacts().any(|c| opens(&c)))
            {
                self.try_sides(system, &sides)?;
                break found;
            }
            let (mut held, mut undecided) = (Closed::NONE, Closed::NONE);
            for (k, &contact) in contacts.iter().enumerate() {
                if found.p[k] > level {
                    held = held.with(contact);
                } else if found.w[k] <= level {
                    undecided = undecided.with(contact);
                }
            }
            // What keeps them at rest without a force may be dry friction.
            let sides = self.standing_sides();
            if undecided == Closed::NONE || !self.hold_by_contacts(system, (all, undecided))? {
                break (forces, held, undecided);
            }
            free = Some((sides, (forces, held, undecided)));
        };
        let Forces {
            block,
            found,
            level,
        } = forces;
        self.enter(system, held)?;
        let mut undecided = undecided;
        for (k, &contact) in contacts.iter().enumerate() {
            if held.contains(contact) || found.w[k] <= level {
                continue;
            }
            if self.opens_in_flight(system, contact)? {
                self.leave_gap(system, contact, 2);
            } else {
                undecided = undecided.with(contact);
            }
        }
        let undecided: Vec<usize> = undecided.contacts().collect();
        let idle = self.idle_beside(&block, &contacts, (held, &undecided));
        let rest: Vec<usize> = (undecided.iter().copied())
            .filter(|&contact| !idle.contains(contact))
            .collect();
        let balanced = self.settle_by_jerks(system, work, (held, &rest))?;
        if idle != Closed::NONE {
            let closed = Closed(self.closed.0 | idle.0);
            self.enter_grip(system, Grip { closed, idle })?;
        }
        // Each was found while the others that are balanced do not push: so none does.
        for contact in balanced {
            self.touch(system, GuardKind::Reaction(contact), Touching::BALANCED);
        }
        self.hold_columns_on_contacts(system)
    }

    /// Replaces a range of states; one that does not change keeps its rounding remainder.
    pub(in crate::flow::trajectory) fn take(
        &mut self,
        range: core::ops::Range<usize>,
        values: &[R],
    ) {
        for index in range {
            if self.state[index] != values[index] {
                self.state[index] = values[index];
                self.low[index] = R::ZERO;
            }
        }
    }

    /// The state brought to rest on a contact: gap and rate zero.
    pub(in crate::flow::trajectory) fn at_rest(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Vec<R>, FlowError> {
        let program = self.program(system)?;
        let mut at_rest = self.state.clone();
        if let Some(constants) = &self.constants[self.mode] {
            work.values_at(
                &program.captures[contact],
                &constants.captures[contact],
                (&self.state, &self.low),
                &mut at_rest,
            );
        }
        Ok(at_rest)
    }

    /// Puts other columns of derivatives beside the state, one after the other; what closed contacts do not allow to vary is
    /// taken from them, and what surfaces that are slid along do not. Nothing else changes: the mode is not asked for anew, as [`restart`](Self::restart) would.
    ///
    /// # Errors
    /// The equations have no finite value at the state.
    pub fn replace_columns(&mut self, system: &System, columns: &[R]) -> Result<(), FlowError> {
        // The samples of a sequence that is being extrapolated carry the columns from before.
        self.tracker.interrupt();
        self.tops.interrupt();
        self.state[self.coordinates..].copy_from_slice(columns);
        self.low[self.coordinates..].fill(R::ZERO);
        self.hold_columns_on_contacts(system)?;
        self.hold_columns_on_surfaces(system)
    }

    /// Whether anything holds the state, so that not all displacements of it last.
    pub(crate) fn is_held(&self, system: &System) -> bool {
        self.closed != Closed::NONE || !self.held(system).surfaces.is_empty()
    }

    /// Whether impacts are being watched that may be a sequence of complete chatter.
    pub(crate) fn follows_sequence(&self) -> bool {
        self.tracker.has_samples()
    }

    /// Whether all that the latest step led to is told and done, but for what it may have caused by a jump.
    pub(crate) fn is_between_steps(&self) -> bool {
        self.completion.is_none() && self.collisions.is_none() && self.pending.is_empty()
    }

    /// Whether the latest event has taken the trajectory across a section, as one does that makes another event's surface jump: they
    /// share their shifts of time.
    pub(crate) fn has_caused_more(&self, system: &System, work: &mut Workspace<R>) -> bool {
        self.may_have_crossed && self.crosses_here(system, work).is_some()
    }

    /// The force of a closed contact has vanished: it opens, unless those of others vanish with it. Then which of them open is decided
    /// for all at once; and so where an impact elsewhere has just changed what the force does, which may begin with any of its derivatives.
    pub(in crate::flow::trajectory) fn let_go(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        if self.touched_at == self.time {
            self.rest_again(system, work)?;
            return Ok(self.pending.pop_front());
        }
        if self.grip().carrying().contacts().nth(1).is_some() {
            let (mut count, mut is_among) = (0, false);
            for push in self.reactions(system)? {
                let vanishes = push.force <= push.level;
                count += usize::from(vanishes);
                is_among |= vanishes && push.contact == contact;
            }
            if is_among && count > 1 {
                self.rest_again(system, work)?;
                return Ok(self.pending.pop_front());
            }
        }
        let before = self.regime;
        self.open(system, contact, 3)?;
        let released = Closed::NONE.with(contact);
        // Friction that comes to hold without the contact's force may keep it from opening.
        if self.regime != before && !self.opens_apart(system, released)? {
            self.bring_to_rest(system, work, released)?;
            if self.closed.contains(contact) {
                self.count_switch()?;
                (self.pending).retain(
                    |told| !matches!(told, Occurrence::Capture { contact: c } if *c == contact),
                );
                return Ok(self.pending.pop_front());
            }
        }
        Ok(Some(Occurrence::Release { contact }))
    }

    /// A closed contact opens, with so many roots of its gap here.
    pub(in crate::flow::trajectory) fn open(
        &mut self,
        system: &System,
        contact: usize,
        roots: u8,
    ) -> Result<(), FlowError> {
        self.enter(system, self.closed.without(contact))?;
        // Others that were left in this instant are left still, if that is what their gaps do without this contact's force.
        for other in self.just_left(system).contacts() {
            let [.., jerk] = self.local(system, other)?;
            if jerk.value <= jerk.level() {
                self.leave_gap(system, other, 0);
            }
        }
        self.leave_gap(system, contact, roots);
        self.flight_time = R::splat(FOREVER);
        self.settle_corners(system, None)?;
        Ok(())
    }

    /// Changes the mode; guards that both modes have keep their roots at the present state, and what was left is left still.
    pub(in crate::flow::trajectory) fn enter(
        &mut self,
        system: &System,
        closed: Closed,
    ) -> Result<(), FlowError> {
        self.flight = system.meet(Grip::NONE, self.regime);
        self.load_constants(system, self.flight);
        let idle = self.idle_among(system, closed)?;
        self.enter_grip(system, Grip { closed, idle })
    }

    /// As [`enter`](Self::enter), where it is known which of the contacts are idle.
    pub(super) fn enter_grip(&mut self, system: &System, grip: Grip) -> Result<(), FlowError> {
        let before = self.touching;
        let from = self.mode;
        let old = system.program(from);
        self.mode = system.meet(grip, self.regime);
        let closes = grip
            .closed
            .contacts()
            .any(|contact| !self.closed.contains(contact));
        (self.closed, self.idle) = (grip.closed, grip.idle);
        self.load_constants(system, self.mode);
        let program = self.program(system)?;
        self.touching = Touching::NONE;
        let mut left = Touching::NONE;
        for (index, guard) in program.guards.iter().enumerate() {
            // On the other side of a surface its guard is another function, and what closes may take the state back to it.
            let turned = |surface: usize| {
                (system.origin_of(from))
                    .is_some_and(|(_, sides, _)| sides.get(surface) != self.regime.get(surface))
            };
            let is_another =
                matches!(guard.kind, GuardKind::Switch(surface) if closes || turned(surface));
            let same = old
                .filter(|_| !is_another)
                .and_then(|old| old.guards.iter().position(|other| other.kind == guard.kind));
            let roots = same.map_or(0, |place| before.get(place));
            // A balance holds in one mode.
            if !guard.is_balanced(roots) {
                self.touching.set(index, roots);
            }
            if let Some(place) = same {
                left.set(index, self.left.roots(place));
            }
        }
        self.left = self.left.of(left);
        Ok(())
    }

    /// The constants of a mode at the present parameter values and pieces, unless they are known.
    fn load_constants(&mut self, system: &System, mode: usize) {
        if self.constants.len() <= mode {
            self.constants.resize(mode + 1, None);
            self.touch_constants.resize(mode + 1, None);
            self.known_at.resize(mode + 1, 0);
        }
        let is_known = self.constants[mode].is_some();
        if is_known && self.known_at[mode] == self.knots {
            return;
        }
        self.known_at[mode] = self.knots;
        match &mut self.constants[mode] {
            Some(constants) => system.renew_constants(mode, &self.parameters, constants),
            unknown => *unknown = system.constants(mode, &self.parameters),
        }
        let Some(touches) = system.touches(mode) else {
            return;
        };
        match &mut self.touch_constants[mode] {
            Some(constants) => touches.renew(&self.parameters, constants),
            unknown => *unknown = Some(touches.constants(&self.parameters)),
        }
    }

    /// Pieces of lookups have changed.
    pub(in crate::flow::trajectory) fn pass_knots(&mut self) {
        self.knots += 1;
    }

    /// Says how many roots of the gap of an open contact lie at the present state.
    pub(in crate::flow::trajectory) fn leave_gap(
        &mut self,
        system: &System,
        contact: usize,
        roots: u8,
    ) {
        self.touch(system, GuardKind::Gap(contact), roots);
    }

    pub(in crate::flow::trajectory) fn touch(
        &mut self,
        system: &System,
        kind: GuardKind,
        roots: u8,
    ) {
        if let Some(index) = self.guard(system, kind) {
            self.touching.set(index, roots);
        }
    }

    /// How many roots of a guard lie at the present state.
    pub(in crate::flow::trajectory) fn roots(&self, system: &System, kind: GuardKind) -> u8 {
        self.guard(system, kind)
            .map_or(0, |index| self.touching.get(index))
    }

    /// The place of a guard in the present mode.
    pub(in crate::flow::trajectory) fn guard(
        &self,
        system: &System,
        kind: GuardKind,
    ) -> Option<usize> {
        let program = system.program(self.mode)?;
        program.guards.iter().position(|guard| guard.kind == kind)
    }

    /// Whether nothing moves any more: no component of the field can be told from zero by its terms, by the forces of
    /// contacts, which may have cancelled when formulas were simplified, or by what flight adds to it in a time below
    /// rounding.
    pub fn is_in_equilibrium(&self, system: &System, work: &mut Workspace<R>) -> bool {
        let (Some(program), Some(constants)) = (
            system.program(self.mode),
            self.constants.get(self.mode).and_then(Option::as_ref),
        ) else {
            return false;
        };
        let start = (&self.state[..], &self.low[..]);
        let field = with_terms(&program.field, &constants.field, start);
        let Ok(touch) = self.touch_values(system) else {
            return false;
        };
        let (Some(flight), Some(Some(constants))) =
            (system.program(self.flight), self.constants.get(self.flight))
        else {
            return false;
        };
        work.expand_at(&flight.tape, &constants.tape, start, R::ONE);
        let added = |i: usize| work.point.series(i)[2].abs() * self.rest_of_burst();
        let accelerations = touch.greatest_accelerations();
        let forces = |i: usize| {
            (self.closed.contacts())
                .map(|contact| touch.jump[contact][i].abs() * accelerations[contact])
                .fold(R::ZERO, |sum, force| sum + force)
        };
        let level = |i: usize, f: &WithTerms<R>| {
            let forces = WithTerms::exact(forces(i)).level();
            f.level().max(forces).max(added(i))
        };
        (field.iter().enumerate()).all(|(i, f)| f.value.abs() <= level(i, f))
    }

    /// Gap, rate, acceleration and jerk of a contact in the present mode.
    pub(in crate::flow::trajectory) fn local(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<[WithTerms<R>; LOCAL_SCALARS], FlowError> {
        self.local_up_to(system, contact)
    }

    /// The first of these, whatever the others are: where a root begins a jerk is infinite.
    pub(in crate::flow::trajectory) fn local_up_to<const COUNT: usize>(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<[WithTerms<R>; COUNT], FlowError> {
        let local = self.local_values(system, contact)?;
        let known = core::array::from_fn(|k| local[k]);
        if known.iter().all(|value| value.value.is_finite()) {
            Ok(known)
        } else {
            Err(self.left_domain())
        }
    }

    /// The acceleration of a contact in the present mode.
    fn acceleration(&self, system: &System, contact: usize) -> Result<WithTerms<R>, FlowError> {
        let [_, _, acceleration] = self.local_up_to(system, contact)?;
        Ok(acceleration)
    }

    /// Whether a contact's jerk in the present mode can be told from zero.
    fn jerks(&self, system: &System, contact: usize) -> Result<bool, FlowError> {
        let [.., jerk] = self.local_values(system, contact)?;
        Ok(jerk.value.is_finite() && jerk.value.abs() > jerk.level())
    }

    pub(in crate::flow::trajectory) fn local_values(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<[WithTerms<R>; LOCAL_SCALARS], FlowError> {
        let program = self.program(system)?;
        let mut local = [WithTerms::exact(R::ZERO); LOCAL_SCALARS];
        if let Some(constants) = &self.constants[self.mode] {
            let start = (&self.state[..], &self.low[..]);
            let values = with_terms(&program.locals[contact], &constants.locals[contact], start);
            local.copy_from_slice(&values);
        }
        Ok(local)
    }
}
