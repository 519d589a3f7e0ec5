//! Contacts at rest that neither force nor acceleration decides about: the jerks do, or the first derivative that can be told from
//! zero, or nothing moves them.

use crate::expressions::{Operand, Tape};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::{Guard, GuardKind};
use crate::flow::modes::program::Program;
use crate::flow::step::{ORDER_CLASSES, Workspace};
use crate::flow::system::System;
use crate::flow::touch::{after_all_roots, series_with_terms, with_terms};
use crate::flow::touching::Touching;
use crate::flow::trajectory::Trajectory;
use crate::numerics::complementarity::complementary;
use crate::numerics::linear::solve;
use crate::numerics::polynomial::{horner, magnitude};
use crate::numerics::{Real, WithTerms, dot};

/// A gap that no order of its expansion moves by more than this part of the state's own motion stays as it is.
const BALANCE_ROUNDOFFS: f64 = 1024.0;

/// Of a derivative that is the sum of forces in balance so many times as much may be left as rounding makes of its terms.
pub(in crate::flow::trajectory) const BALANCE_LEVELS: f64 = 32.0;

/// Gap, rate, acceleration and jerk have been asked of a contact at rest.
const ORDERS_AT_REST: usize = 4;

/// Parts of a unit of time in which the motion that roots take part in is compared with that without them.
const BEGINNING: [f64; 2] = [1.0 / 64.0, 1.0 / 1024.0];

/// The series of a gap, each coefficient with its terms.
struct GapSeries<R> {
    /// Its unit of time.
    unit: R,
    series: Vec<WithTerms<R>>,
}

impl<R: Real> Trajectory<R> {
    /// Contacts at rest without acceleration in the present mode, which `held` keeps closed: the rates at which their forces begin to
    /// grow, and their jerks, obey the law that forces and accelerations do. Those that are balanced are returned.
    pub(super) fn settle_by_jerks(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (held, contacts): (Closed, &[usize]),
    ) -> Result<Vec<usize>, FlowError> {
        let mut rest = contacts.to_vec();
        if contacts.len() > 1 {
            let mut jerks = Vec::with_capacity(contacts.len());
            for &contact in contacts {
                let [.., jerk] = self.local(system, contact)?;
                jerks.push(jerk);
            }
            let level = jerks.iter().map(|jerk| jerk.level()).fold(R::ZERO, R::max);
            let free: Vec<R> = jerks.iter().map(|jerk| jerk.value).collect();
            let block = self.coupling_beside(system, held, contacts)?;
            let levels = vec![level; free.len()];
            let found = block.and_then(|block| complementary(&block, &free, &levels));
            let mut leaving = Vec::new();
            if let Some(found) = found {
                rest.clear();
                for (k, &contact) in contacts.iter().enumerate() {
                    if found.p[k] > level {
                        self.enter(system, self.closed.with(contact))?;
                        self.touch(system, GuardKind::Reaction(contact), 1);
                    } else if found.w[k] > level {
                        leaving.push(contact);
                    } else {
                        rest.push(contact);
                    }
                }
            }
            for contact in leaving {
                self.leave_gap(system, contact, 3);
            }
        }
        let mut balanced = Vec::new();
        for contact in rest {
            let closes = self.settle_by_jerk(system, work, contact)?;
            if closes && self.roots(system, GuardKind::Reaction(contact)) == Touching::BALANCED {
                balanced.push(contact);
            }
        }
        Ok(balanced)
    }

    /// How impulses at contacts change their rates while others are held closed; none where those depend on each other.
    fn coupling_beside(
        &self,
        system: &System,
        held: Closed,
        contacts: &[usize],
    ) -> Result<Option<Vec<Vec<R>>>, FlowError> {
        let held: Vec<usize> = held.contacts().collect();
        let all = [&held[..], contacts].concat();
        let (count, block) = (held.len(), self.touch_values(system)?.block(&all));
        let (above, below) = block.split_at(count);
        let own: Vec<Vec<R>> = above.iter().map(|row| row[..count].to_vec()).collect();
        let mut rows: Vec<Vec<R>> = below.iter().map(|row| row[count..].to_vec()).collect();
        for column in 0..contacts.len() {
            let pushed: Vec<R> = above.iter().map(|row| row[count + column]).collect();
            let Some(forces) = solve(&own, &pushed) else {
                return Ok(None);
            };
            for (row, below) in rows.iter_mut().zip(below) {
                row[column] -= dot(&below[..count], &forces);
            }
        }
        Ok(Some(rows))
    }

    /// A contact at rest without acceleration in the present mode: its jerk decides, or the first derivative that can be told from
    /// zero, or it is balanced. Returns whether it is closed.
    pub(super) fn settle_by_jerk(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<bool, FlowError> {
        let [_, _, _, jerk] = self.local(system, contact)?;
        if jerk.value > jerk.level() {
            self.leave_gap(system, contact, 3);
            return Ok(false);
        }
        let mut roots = 1;
        if jerk.value >= -jerk.level() {
            let gap = (GuardKind::Gap(contact), ORDERS_AT_REST);
            let found = match self.first_order(system, gap)? {
                None => self.order_after_roots(system, work, contact)?,
                found => found,
            };
            match found {
                Some((order, rises)) => {
                    let most = usize::from(Touching::BALANCED);
                    if rises {
                        self.leave_gap(system, contact, order.min(most) as u8);
                        return Ok(false);
                    }
                    // Two of them are the force's own.
                    roots = (order - 2).min(most - 1) as u8;
                }
                None if self.is_balanced(system, work, contact)? => roots = Touching::BALANCED,
                None => {
                    return Err(FlowError::UndecidedRelease {
                        time: self.time.to_f64(),
                        contact,
                    });
                }
            }
        }
        self.enter(system, self.closed.with(contact))?;
        self.touch(system, GuardKind::Reaction(contact), roots);
        Ok(true)
    }

    /// The first order, of those from one on, in which the field moves a guard that no lower one moves, as the gap of a contact at rest,
    /// and whether it rises; none that is computed can be told from zero by what is left of a balance of its terms.
    pub(in crate::flow::trajectory) fn first_order(
        &self,
        system: &System,
        (kind, from): (GuardKind, usize),
    ) -> Result<Option<(usize, bool)>, FlowError> {
        let Some(GapSeries { series, .. }) =
            self.series_here(system, |guard| guard.kind == kind)?
        else {
            return Ok(None);
        };
        let moves = |c: &WithTerms<R>| c.value.abs() > c.level() * R::splat(BALANCE_LEVELS);
        let found = (series.iter().enumerate().skip(from)).find(|(_, c)| moves(c));
        let is_finite = (series.iter()).all(|c| c.value.is_finite());
        Ok(found
            .filter(|_| is_finite)
            .map(|(order, c)| (order, c.value > R::ZERO)))
    }

    /// As [`first_order`](Self::first_order) of the gap of a contact at rest where roots vanish, so that it has no series: that of the motion
    /// without them, if what they add is less than it as it begins.
    fn order_after_roots(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<Option<(usize, bool)>, FlowError> {
        /// What roots may add to the acceleration.
        const LESS: f64 = 0.5;
        let program = self.program(system)?;
        let (Some((_, slot)), Some(constants), Some(plain)) = (
            program.gap_series(contact),
            &self.constants[self.mode],
            self.after_roots_here(program),
        ) else {
            return Ok(None);
        };
        let start = (&self.state[..], &self.low[..]);
        let unit = self.own_unit();
        let series = series_with_terms(&plain, &constants.tape, start, (slot, unit));
        let moves = |c: &WithTerms<R>| c.value.abs() > c.level() * R::splat(BALANCE_LEVELS);
        let moving = (series.iter().enumerate().skip(ORDERS_AT_REST)).find(|(_, c)| moves(c));
        let Some((order, first)) = moving else {
            return Ok(None);
        };
        let bends: Vec<R> = (series.iter().enumerate().skip(2))
            .map(|(k, c)| match k < order {
                true => R::ZERO,
                false => c.value * R::splat((k * (k - 1)) as f64) / (unit * unit),
            })
            .collect();
        work.expand_at(&plain, &constants.tape, start, unit);
        let as_said = BEGINNING.iter().all(|&part| {
            let plain = horner(&bends, R::splat(part));
            let own = self.acceleration_along(work, program, (contact, part));
            own.is_some_and(|own| (own - plain).abs() <= plain.abs() * R::splat(LESS))
        });
        Ok(as_said.then_some((order, first.value > R::ZERO)))
    }

    /// The unit of time of the motion: towards roots steps have shrunk.
    fn own_unit(&self) -> R {
        let unit = self.reach[ORDER_CLASSES - 1].max(self.longest_step);
        unit.max(R::splat(f64::MIN_POSITIVE))
    }

    /// The tape of a program without the roots of what vanishes here; none if there are no such roots, or more would be left out.
    fn after_roots_here(&self, program: &Program) -> Option<Tape> {
        let constants = self.constants[self.mode].as_ref()?;
        let start = (&self.state[..], &self.low[..]);
        let plain = after_all_roots(&program.tape, &constants.tape, start)?;
        (plain.singular.len() < program.tape.singular.len()).then_some(plain)
    }

    /// The acceleration of a gap where the motion that the workspace holds has come to in this part of its unit of time.
    fn acceleration_along(
        &self,
        work: &Workspace<R>,
        program: &Program,
        (contact, part): (usize, f64),
    ) -> Option<R> {
        let constants = self.constants[self.mode].as_ref()?;
        let state: Vec<R> = (0..self.state.len())
            .map(|i| horner(work.point.series(i), R::splat(part)))
            .collect();
        let none = vec![R::ZERO; state.len()];
        let (tape, constants) = (&program.locals[contact], &constants.locals[contact]);
        let local = with_terms(tape, constants, (&state, &none));
        local.get(2).map(|acceleration| acceleration.value)
    }

    /// Whether a contact at rest opens with an acceleration that flight can tell from zero: formulas had cancelled what flight rounds, as
    /// where bodies that fall side by side are measured in different units.
    pub(super) fn opens_in_flight(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<bool, FlowError> {
        let series = self.gap_series(system, contact)?;
        let bend = series.and_then(|gap| gap.series.get(2).copied());
        Ok(bend.is_none_or(|bend| bend.value > bend.level() || !bend.value.is_finite()))
    }

    /// What the gap of a contact that is open does in flight from here; none of a constant.
    fn gap_series(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<Option<GapSeries<R>>, FlowError> {
        self.series_here(system, |guard| guard.closing() == Some(contact))
    }

    /// What a guard does from here; none of a constant.
    fn series_here(
        &self,
        system: &System,
        is_asked: impl Fn(&Guard) -> bool,
    ) -> Result<Option<GapSeries<R>>, FlowError> {
        /// What rested until now may move far faster than the latest expansion says.
        const SHORTER: f64 = 1.0 / 1024.0;
        const TRIES: usize = 100;
        let program = self.program(system)?;
        let guard = (program.guards.iter()).find(|guard| is_asked(guard));
        let (Some(constants), Some(Operand::Series(slot))) =
            (&self.constants[self.mode], guard.map(|guard| guard.series))
        else {
            return Ok(None);
        };
        let start = (&self.state[..], &self.low[..]);
        // In the time that the field itself needs to change, from the latest expansion.
        let unit = self.reach[ORDER_CLASSES - 1].max(R::splat(f64::MIN_POSITIVE));
        let in_unit = |unit: R| GapSeries {
            unit,
            series: series_with_terms(&program.tape, &constants.tape, start, (slot, unit)),
        };
        let is_finite = |gap: &GapSeries<R>| gap.series.iter().all(|c| c.value.is_finite());
        let units = core::iter::successors(Some(unit), |&unit| Some(unit * R::splat(SHORTER)));
        let found = (units.take(TRIES).map(in_unit)).find(is_finite);
        // Where a root vanishes there is none in any unit: in the first its lowest coefficients are what they are.
        Ok(Some(found.unwrap_or_else(|| in_unit(unit))))
    }

    /// The guards of closed contacts whose forces vanish for good in the present mode.
    pub(in crate::flow::trajectory) fn balanced_contacts(
        &self,
        system: &System,
    ) -> Result<Vec<usize>, FlowError> {
        let guards = self.program(system)?.guards.iter().enumerate();
        Ok(guards
            .filter(|(place, guard)| {
                guard.opening().is_some() && guard.is_balanced(self.touching.get(*place))
            })
            .map(|(place, _)| place)
            .collect())
    }

    /// Whether the gap of a contact at rest stays zero by itself: the field does not move it to any order that is
    /// computed, as in an equilibrium without contact force.
    fn is_balanced(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
    ) -> Result<bool, FlowError> {
        const SHORTER: f64 = 0.125;
        const TRIES: usize = 40;
        let program = self.program(system)?;
        let guard = program
            .guards
            .iter()
            .find(|guard| guard.closing() == Some(contact));
        let (Some(constants), Some(Operand::Series(slot))) =
            (&self.constants[self.mode], guard.map(|guard| guard.series))
        else {
            return Ok(false);
        };
        let Some(GapSeries { mut unit, series }) = self.gap_series(system, contact)? else {
            return Ok(false);
        };
        // Where roots vanish that have no series here, nothing moves without them, nor with them then.
        let is_finite = series.iter().all(|c| c.value.is_finite());
        let plain = match is_finite {
            true => None,
            false => self.after_roots_here(program),
        };
        let tape = plain.as_ref().unwrap_or(&program.tape);
        let start = (&self.state[..], &self.low[..]);
        let series = match &plain {
            Some(plain) => {
                unit = self.own_unit();
                series_with_terms(plain, &constants.tape, start, (slot, unit))
            }
            None => series,
        };
        let mut levels: Vec<R> = series.iter().map(|c| c.level()).collect();
        for _ in 0..TRIES {
            work.expand_at(tape, &constants.tape, start, unit);
            let motion = (0..self.coordinates)
                .map(|i| magnitude(work.point.series(i), R::ONE))
                .fold(R::ZERO, R::max);
            let level = motion * R::splat(BALANCE_ROUNDOFFS * R::ROUNDOFF);
            let stays = |&part: &f64| {
                let own = self.acceleration_along(work, program, (contact, part));
                own.is_some_and(|own| (own * unit * unit).abs() <= level)
            };
            if plain.is_some() && !BEGINNING.iter().all(stays) {
                return Ok(false);
            }
            if (work.point.series(slot).iter()).all(|c| c.abs() <= level) {
                return Ok(true);
            }
            // Where rounding alone may be more than that, as of a stiff spring at its corner, the unit is too long to say so.
            if levels.iter().all(|&rounding| rounding <= level) {
                return Ok(false);
            }
            unit *= R::splat(SHORTER);
            let mut share = R::ONE;
            for rounding in &mut levels {
                *rounding *= share;
                share *= R::splat(SHORTER);
            }
        }
        Ok(false)
    }
}
