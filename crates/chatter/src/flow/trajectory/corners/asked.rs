//! Corners that only impacts and resets ask for: their side is found at that instant, by the values there, and not followed between.

use super::Candidate;
use crate::expressions::{Asked, LookedUpIn, Side};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::program::Program;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::trajectory::Trajectory;
use crate::numerics::{Mask, Real};

/// Corners within corners, as conditions are nested.
const DEEPEST: usize = 16;

impl<R: Real> Trajectory<R> {
    /// As the step itself does with an impact of one contact alone whose map has no corners of its own: the impact that ended
    /// the latest step, the state before it in place.
    pub(in crate::flow::trajectory) fn ask_impact(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (index, contact): (usize, usize),
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        self.ask_at_impacts(system, Closed::NONE.with(contact))?;
        let program = self.program(system)?;
        if let Some(constants) = &self.constants[self.mode] {
            work.load_constants(constants);
        }
        work.state.copy_from_slice(&self.state);
        work.low.copy_from_slice(&self.low);
        work.collide_at(program, contact, R::Mask::splat(true));
        self.state.copy_from_slice(&work.state);
        self.low.copy_from_slice(&work.low);
        let impact = work.impact;
        self.flight_time = work.flight_time;
        self.leave_gap(system, contact, 1);
        self.meet_contact(system, work, (index, contact), impact)
    }

    /// Finds what impacts at these contacts ask for.
    pub(in crate::flow::trajectory) fn ask_at_impacts(
        &mut self,
        system: &System,
        contacts: Closed,
    ) -> Result<(), FlowError> {
        self.find_asked(system, |asked, _| {
            (contacts.contacts()).fold(Asked::default(), |all, contact| all.or(asked[contact]))
        })?;
        Ok(())
    }

    /// Finds what the reset of a section asks for; whether the motion says what a whole part in it is.
    pub(in crate::flow::trajectory) fn ask_at_reset(
        &mut self,
        system: &System,
        section: usize,
    ) -> Result<bool, FlowError> {
        self.find_asked(system, |_, asked| asked[section])
    }

    fn find_asked(
        &mut self,
        system: &System,
        wanted: impl Fn(&[Asked], &[Asked]) -> Asked,
    ) -> Result<bool, FlowError> {
        let is_first = self.asked_in.is_none();
        for _ in 0..DEEPEST {
            let program = self.program(system)?;
            let asked = wanted(&program.asked_at_impacts, &program.asked_at_resets);
            if asked.is_empty() {
                break;
            }
            let (found, by_motion) = self.found_here(system, program, asked)?;
            let is_known = found == self.standing_sides();
            if !is_known {
                self.try_sides(system, &found)?;
            }
            if is_first {
                self.asked_in = Some((self.mode, self.pieces.clone()));
            }
            if is_known {
                return Ok(by_motion);
            }
        }
        Ok(false)
    }

    /// Sides and pieces as they are, but for what is `asked`: that by the values at the state. What lies on a corner is where the motion
    /// takes it, which crosses the corner first; if that does not move it, where its formula says as it stands. With whether the motion
    /// said what a whole part is.
    fn found_here(
        &self,
        system: &System,
        program: &Program,
        asked: Asked,
    ) -> Result<(Candidate, bool), FlowError> {
        let (corners, graph) = (system.corners(), &system.model().graph);
        let mut found = self.standing_sides();
        let mut by_motion = false;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok((found, by_motion));
        };
        let start = (&self.state[..], &self.low[..]);
        let values = with_terms(&program.asked_values, &constants.asked_values, start);
        let plain = corners.at(graph, &self.state[..self.coordinates], &self.parameters);
        let instant = self.instant();
        for (&corner, pair) in program.asked.iter().zip(values.chunks(2)) {
            let &[value, rate] = pair else { continue };
            let level = (rate.value.abs() * instant).max(value.level());
            let moves = rate.value.abs() > rate.level();
            match corner {
                Corner::Surface(index) if asked.surfaces.contains(index) => {
                    let side = if value.value.abs() > level {
                        side_of(value.value)
                    } else if moves {
                        side_of(rate.value)
                    } else {
                        plain.0.get(index)
                    };
                    found.sides = found.sides.with(index, side);
                }
                Corner::Lookup(index) if asked.lookups.contains(index) => {
                    self.refuse_outside(system, index, (value.value, level))?;
                    let ahead = level + level;
                    let ahead = if moves && rate.value < R::ZERO {
                        -ahead
                    } else {
                        ahead
                    };
                    let at =
                        |argument: R| corners.piece_at(graph, index, argument.to_double_double());
                    let is_clear = at(value.value - ahead) == at(value.value + ahead);
                    let is_whole = corners.lookups[index].within == LookedUpIn::WholeNumbers;
                    by_motion |= is_whole && moves && !is_clear;
                    found.pieces[index] = if is_clear {
                        at(value.value)
                    } else if moves {
                        at(value.value + ahead)
                    } else {
                        plain.1[index]
                    };
                }
                _ => {}
            }
        }
        Ok((found, by_motion))
    }

    /// Whether impacts at these contacts have no corners of their own.
    pub(in crate::flow::trajectory) fn asks_nothing(
        &self,
        system: &System,
        contacts: Closed,
    ) -> Result<bool, FlowError> {
        let asked = &self.program(system)?.asked_at_impacts;
        Ok(contacts.contacts().all(|contact| asked[contact].is_empty()))
    }

    /// Whether what an impact of a contact asks for is at another state as it is now, or on the edge of that.
    pub(in crate::flow::trajectory) fn asks_alike(
        &self,
        system: &System,
        contact: usize,
        state: &[R],
    ) -> bool {
        let Some(program) = system.program(self.mode) else {
            return true;
        };
        let asked = program.asked_at_impacts[contact];
        if asked.is_empty() {
            return true;
        }
        let (corners, graph) = (system.corners(), &system.model().graph);
        let value = |of| graph.evaluate(of, state, &self.parameters);
        let on_side = |index: usize| {
            let value: R = value(corners.surfaces[index]);
            match self.regime.get(index) {
                Side::Below => value <= R::ZERO,
                Side::Above | Side::Sliding => value >= R::ZERO,
            }
        };
        let in_piece = |index: usize| {
            let value: R = value(corners.lookups[index].argument);
            let slots = corners.slots_of::<R>(graph, index, self.pieces[index]);
            slots.is_some_and(|slots| slots[0] <= value && value <= slots[1])
        };
        asked.surfaces.members().all(on_side) && asked.lookups.members().all(in_piece)
    }
}

fn side_of<R: Real>(value: R) -> Side {
    if value > R::ZERO {
        Side::Above
    } else {
        Side::Below
    }
}
