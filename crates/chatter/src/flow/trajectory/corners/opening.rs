//! Surfaces that contacts at rest keep the state on, as friction along a gap does: the side that they leave to as these open.

use super::Candidate;
use crate::expressions::Side;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::limits::Corner;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::roots::flat_root::root_of;
use crate::numerics::Real;
use crate::numerics::linear::solve;

impl<R: Real> Trajectory<R> {
    /// What contacts at rest do to a surface, or their gaps are of it, as one of `opening` opens while the others stay closed: the side that it leaves
    /// to; none where they do nothing.
    fn side_of_opening(
        &self,
        system: &System,
        corner: Corner,
        (resting, opening): (Closed, Closed),
    ) -> Result<Option<Side>, FlowError> {
        if let Corner::Surface(index) = corner
            && let Some(side) = system.kept_on((index, opening), &self.parameters)
        {
            return Ok(Some(side));
        }
        let program = self.program(system)?;
        let found = (program.standings.iter()).position(|tapes| tapes.corner == corner);
        let (Some(place), Some(constants)) = (found, &self.constants[self.mode]) else {
            return Ok(None);
        };
        let start = (&self.state[..], &self.low[..]);
        let tape = &program.standings[place].lifts;
        let lifts = with_terms(tape, &constants.standings[place][2], start);
        let contacts: Vec<usize> = resting.contacts().collect();
        let level =
            (contacts.iter()).fold(R::ZERO, |level, &contact| level.max(lifts[contact].level()));
        let by_jump: Vec<R> = contacts.iter().map(|&k| lifts[k].value).collect();
        // A jump at one contact changes the rates of others, too: what makes one rate larger and leaves the others.
        let coupling = self.coupling(system, &contacts)?;
        let column = |k: usize| coupling.iter().map(|row| row[k]).collect();
        let columns: Vec<Vec<R>> = (0..contacts.len()).map(column).collect();
        let by_rate = solve(&columns, &by_jump).unwrap_or(by_jump);
        let mut moved = (contacts.iter().zip(by_rate))
            .filter(|&(&contact, _)| opening.contains(contact))
            .map(|(_, lift)| lift);
        let clear = moved.find(|lift| lift.abs() > level);
        Ok(clear.map(|lift| {
            if lift > R::ZERO {
                Side::Above
            } else {
                Side::Below
            }
        }))
    }

    /// The side of a surface that is the one of all motions, as a multiple of it is a gap.
    fn side_of_gap(&self, system: &System, corner: Corner) -> Option<(usize, Side)> {
        let Corner::Surface(index) = corner else {
            return None;
        };
        let all = (0..system.contacts()).fold(Closed::NONE, Closed::with);
        let side = system.kept_on((index, all), &self.parameters)?;
        Some((index, side))
    }

    /// The sides with that of a surface that is a multiple of a gap, where they have another: what no motion gets to the far side of is
    /// not slid along either, though the field there leads back.
    pub(super) fn on_side_of_gap(&self, system: &System, corner: Corner) -> Option<Candidate> {
        let (index, side) = self.side_of_gap(system, corner)?;
        let now = self.standing_sides();
        (now.side(index) != side).then(|| now.with_side(index, side))
    }

    /// Whether the state is on that side, which nothing but a jump changes. Roots say where motion has a series: they are asked as of
    /// all else.
    pub(super) fn is_on_side_of_gap(&self, system: &System, corner: Corner) -> bool {
        let is_smooth = |index: usize| {
            let program = self.program(system);
            program.is_ok_and(|program| root_of(program, GuardKind::Switch(index)).is_none())
        };
        self.side_of_gap(system, corner)
            .is_some_and(|(index, side)| self.regime.get(index) == side && is_smooth(index))
    }

    /// Whether a surface that closed contacts keep the state on, as friction along the gap does at rest, is on the side that it
    /// leaves to when they open. Until then its force and theirs are not told apart.
    pub(super) fn opens_there(&self, system: &System, corner: Corner) -> Result<bool, FlowError> {
        let Corner::Surface(index) = corner else {
            return Ok(true);
        };
        let carrying = self.grip().carrying();
        let opening = match system.rubbing().iter().find(|r| r.surface == index) {
            // Friction of a contact that another one keeps from sliding resists the opening of that.
            Some(rubs) if carrying.contains(rubs.contact) => carrying.without(rubs.contact),
            Some(_) => return Ok(true),
            None => self.closed,
        };
        let side = self.side_of_opening(system, corner, (self.closed, opening))?;
        Ok(side.is_none_or(|side| self.regime.get(index) == side))
    }

    /// Takes each surface that the state lies on to the side that it leaves to where contacts at rest open: dry friction
    /// resists that.
    pub(in crate::flow::trajectory) fn resist_opening(
        &mut self,
        system: &System,
        resting: Closed,
    ) -> Result<(), FlowError> {
        let mut candidate = self.standing_sides();
        for standing in self.standings(system)? {
            let Corner::Surface(index) = standing.corner else {
                continue;
            };
            let is_rub = system.rubbing().iter().any(|rubs| rubs.surface == index);
            if is_rub || standing.surface.value.abs() > standing.surface_level() {
                continue;
            }
            let side = self.side_of_opening(system, standing.corner, (resting, resting))?;
            if let Some(side) = side {
                candidate.sides = candidate.sides.with(index, side);
            }
        }
        self.try_sides(system, &candidate)?;
        Ok(())
    }

    /// Takes what holds contacts at rest by sliding on surfaces to the side that these would leave to, the others at rest
    /// staying closed: contacts hold it from now on. Whether there was any.
    pub(in crate::flow::trajectory) fn hold_by_contacts(
        &mut self,
        system: &System,
        (resting, held): (Closed, Closed),
    ) -> Result<bool, FlowError> {
        let mut candidate = self.standing_sides();
        for surface in self.held(system).surfaces {
            let side = self.side_of_opening(system, Corner::Surface(surface), (resting, held))?;
            if let Some(side) = side {
                candidate.sides = candidate.sides.with(surface, side);
            }
        }
        Ok(candidate != self.standing_sides() && self.try_sides(system, &candidate)?)
    }
}
