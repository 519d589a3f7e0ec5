//! Contacts whose gaps stay zero as long as those of others do, as the third leg of a beam: the motion is determined, their
//! forces are not (MATH.md 9). A least set of contacts carries, the others are idle; where a force of those that carry vanishes
//! an idle contact may take its place.

use crate::expressions::{Operand, Side, Sides};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::{Closed, Grip};
use crate::flow::modes::guard::GuardKind;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::start::{PENETRATION, is_inside};
use crate::numerics::linear::independent;
use crate::numerics::{Real, WithTerms};

impl<R: Real> Trajectory<R> {
    /// Which of these contacts are idle where the others carry.
    pub(super) fn idle_among(&self, system: &System, closed: Closed) -> Result<Closed, FlowError> {
        let idle = match closed == self.closed {
            true => self.idle,
            false => self.dependent_among(system, closed)?,
        };
        self.idle_on_surfaces(system, Grip { closed, idle })
    }

    /// Which of these contacts depend on the others.
    fn dependent_among(&self, system: &System, closed: Closed) -> Result<Closed, FlowError> {
        let all = Grip {
            closed,
            idle: Closed::NONE,
        };
        let is_determined = || system.program(system.meet(all, self.regime)).is_some();
        if closed.contacts().nth(1).is_none() || self.idle == Closed::NONE && is_determined() {
            return Ok(Closed::NONE);
        }
        let contacts: Vec<usize> = closed.contacts().collect();
        let carrying = independent(&self.touch_values(system)?.block(&contacts));
        let carries = |place: &usize| carrying.contains(place);
        Ok((0..contacts.len())
            .filter(|place| !carries(place))
            .fold(Closed::NONE, |idle, place| idle.with(contacts[place])))
    }

    /// Which contacts are idle on the present sides beside those that are anyway: of bodies that are all held on surfaces, as by friction
    /// of their own, the contacts between them have nothing to hold. They are idle as long as that is so, and no longer.
    fn idle_on_surfaces(&self, system: &System, grip: Grip) -> Result<Closed, FlowError> {
        let exists = |grip: Grip| system.program(system.meet(grip, self.regime)).is_some();
        let slides = (0..Sides::MOST).any(|k| self.regime.get(k) == Side::Sliding);
        if grip.closed == Closed::NONE || !grip.has_idle() && (!slides || exists(grip)) {
            return Ok(grip.idle);
        }
        let contacts: Vec<usize> = grip.closed.contacts().collect();
        let block = self.touch_values(system)?.block(&contacts);
        let mut anyway = grip;
        for contact in grip.idle.contacts() {
            let beside = (anyway.carrying(), &[contact][..]);
            if self.idle_beside(&block, &contacts, beside) == Closed::NONE {
                anyway.idle = anyway.idle.without(contact);
            }
        }
        let mut found = anyway.without_forces();
        if !slides || exists(anyway) || !exists(found) {
            return Ok(anyway.idle);
        }
        for contact in anyway.carrying().contacts() {
            let idle = found.idle.without(contact);
            if exists(Grip { idle, ..found }) {
                found.idle = idle;
            }
        }
        Ok(found.idle)
    }

    /// Which of the undecided contacts depend on those that are held, given how they are coupled.
    pub(super) fn idle_beside(
        &self,
        block: &[Vec<R>],
        contacts: &[usize],
        (held, undecided): (Closed, &[usize]),
    ) -> Closed {
        let mut idle = Closed::NONE;
        let places = |among: Closed| -> Vec<usize> {
            (0..contacts.len())
                .filter(|&place| among.contains(contacts[place]))
                .collect()
        };
        let mut carrying = held;
        for &contact in undecided {
            let with = places(carrying.with(contact));
            let rows: Vec<Vec<R>> = (with.iter())
                .map(|&i| with.iter().map(|&j| block[i][j]).collect())
                .collect();
            if independent(&rows).len() < with.len() {
                idle = idle.with(contact);
            } else {
                carrying = carrying.with(contact);
            }
        }
        idle
    }

    /// The force of a contact has vanished beside idle ones: one of them carries in its place, or it opens.
    pub(in crate::flow::trajectory) fn hand_over(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let before = self.grip();
        let rest = before.carrying().without(contact);
        self.flight_time = R::splat(FOREVER);
        for other in before.idle.contacts() {
            let idle = before.idle.without(other).with(contact);
            let grip = Grip {
                closed: before.closed,
                idle,
            };
            let carrying: Vec<usize> = grip.carrying().contacts().collect();
            let block = self.touch_values(system)?.block(&carrying);
            let exists = system.program(system.meet(grip, self.regime)).is_some();
            if !exists || independent(&block).len() < carrying.len() {
                continue;
            }
            self.enter_grip(system, grip)?;
            if self.pushes(system, work)? {
                self.settle_corners(system, None)?;
                return Ok(self.pending.pop_front());
            }
        }
        let without = |idle: Closed| Grip {
            closed: Closed(rest.0 | idle.0),
            idle,
        };
        self.enter_grip(system, without(Closed::NONE))?;
        // What depends on those that still carry stays with them, and what surfaces hold; what depends on the one that opens opens
        // with it.
        let others: Vec<usize> = before.idle.contacts().collect();
        let contacts: Vec<usize> = rest.contacts().chain(others.iter().copied()).collect();
        let block = self.touch_values(system)?.block(&contacts);
        let mut stays = Closed::NONE;
        for &other in &others {
            let beside = Grip {
                closed: rest.with(other),
                idle: Closed::NONE,
            };
            if self.idle_beside(&block, &contacts, (rest, &[other])) != Closed::NONE
                || self.idle_on_surfaces(system, beside)?.contains(other)
            {
                stays = stays.with(other);
            }
        }
        let mut opens = vec![(contact, 3)];
        for other in others.into_iter().filter(|&other| !stays.contains(other)) {
            let [_, _, acceleration, jerk] = self.local(system, other)?;
            let sign = |value: &WithTerms<R>| {
                if value.value.abs() <= value.level() {
                    R::ZERO
                } else {
                    value.value
                }
            };
            match (sign(&acceleration), sign(&jerk)) {
                (a, _) if a > R::ZERO => opens.push((other, 2)),
                (a, j) if a == R::ZERO && j > R::ZERO => opens.push((other, 3)),
                _ => return Err(self.dependent(&before.closed.contacts().collect::<Vec<_>>())),
            }
        }
        self.enter_grip(system, without(stays))?;
        for &(other, roots) in &opens {
            self.leave_gap(system, other, roots);
        }
        self.settle_corners(system, None)?;
        let released = opens.iter().skip(1);
        (self.pending).extend(released.map(|&(contact, _)| Occurrence::Release { contact }));
        Ok(Some(Occurrence::Release { contact }))
    }

    /// Whether all contacts that carry push, or begin to.
    fn pushes(&mut self, system: &System, work: &mut Workspace<R>) -> Result<bool, FlowError> {
        let touch = self.touch_values(system)?;
        let greatest = touch.greatest_accelerations();
        let level = (self.closed.contacts())
            .map(|contact| WithTerms::exact(greatest[contact]).level())
            .fold(R::ZERO, R::max);
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(false);
        };
        let start = (&self.state[..], &self.low[..]);
        work.expand_at(&program.tape, &constants.tape, start, R::ONE);
        let mut begin = Vec::new();
        for guard in &program.guards {
            let Some(contact) = guard.opening() else {
                continue;
            };
            let (value, slope) = match guard.series {
                Operand::Series(slot) => {
                    let series = work.point.series(slot);
                    (series[0], series[1])
                }
                Operand::Constant(place) => (constants.tape[place], R::ZERO),
            };
            if value <= level {
                let begins = value >= -level && slope > R::ZERO;
                if !begins {
                    return Ok(false);
                }
                begin.push(contact);
            }
        }
        for contact in begin {
            self.touch(system, GuardKind::Reaction(contact), 1);
        }
        Ok(true)
    }

    /// Whether an idle contact would be pressed shut in the present mode, though it is idle: what surfaces hold on both sides of it they
    /// move together then, and no motion does.
    pub(in crate::flow::trajectory) fn presses_idle(
        &self,
        system: &System,
    ) -> Result<bool, FlowError> {
        if self.idle == Closed::NONE {
            return Ok(false);
        }
        // Forces that cancel are told from zero by all that they balance, which formulas may have left out.
        let greatest = self.touch_values(system)?.greatest_accelerations();
        for contact in self.idle.contacts() {
            let [_, _, acceleration, jerk] = self.local_values(system, contact)?;
            // The corner is met an instant too early or too late.
            let change = jerk.value.abs() * self.instant();
            let change = if change.is_finite() { change } else { R::ZERO };
            let level = (acceleration.level())
                .max(WithTerms::exact(greatest[contact]).level())
                .max(change);
            if acceleration.value < -level {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What is idle stays closed only as long as its gap is zero.
    pub(super) fn watch_idle(&mut self, system: &System) -> Result<(), FlowError> {
        if self.idle == Closed::NONE {
            return Ok(());
        }
        let touch = self.touch_values(system)?;
        for contact in self.idle.contacts() {
            let gap = touch.gap[contact];
            if is_inside(&gap) {
                return Err(self.dependent(&self.closed.contacts().collect::<Vec<_>>()));
            }
            if gap.value > gap.level().max(R::splat(PENETRATION * gap.terms)) {
                let grip = Grip {
                    closed: self.closed.without(contact),
                    idle: self.idle.without(contact),
                };
                self.enter_grip(system, grip)?;
                self.pending.push_back(Occurrence::Release { contact });
            }
        }
        Ok(())
    }
}
