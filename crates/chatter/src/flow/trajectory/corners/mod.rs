//! Which side of each surface the state is on, and which piece of each lookup holds (MATH.md 9).
//!
//! At a corner every mode that could follow is asked whether it does: on a side, the first derivative of the surface along
//! that side's own field that can be told from zero points away from it; sliding, each field has a part in it. A crossing has one
//! answer, attracting sliding one, repelling sliding several.

mod asked;
mod choice;
mod kink;
mod met;
mod opening;
mod options;
mod range;
mod vector;
mod verdict;

use super::{StandingTapes, Trajectory};
use crate::expressions::{Side, Sides, Surfaces};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::{Grip, Held};
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::program::Program;
use crate::flow::modes::standing::{STANDING_ORDERS, STANDING_TAPES};
use crate::flow::occurrence::Occurrence;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::touching::Touching;
use crate::numerics::{Real, WithTerms};

pub(super) use kink::Crossings;

/// How the state stands to a corner in a mode.
struct Standing<R> {
    corner: Corner,
    surface: WithTerms<R>,
    /// The motion keeps to it but for rounding of numbers.
    is_kept: bool,
    /// Its rate, where that must be zero, too, for it to be slid along, and how much of that is rounding, or comes and goes within
    /// an instant.
    rate: Option<(R, R)>,
    guards: Vec<(GuardKind, [WithTerms<R>; STANDING_ORDERS])>,
    /// How long an instant is: nothing for surfaces but that which is met now, since a sequence of crossings may become as fast
    /// as that.
    instant: R,
    /// Of the squared length of a vector that is what is nearest to being told from zero in it: the square says less.
    vector: Option<WithTerms<R>>,
}

impl<R: Real> Standing<R> {
    /// The values of a guard that cannot be told from zero: by their terms, or because an instant later or earlier they are.
    ///
    /// Beyond a corner an expression of its other side may have no rate, as a root of what is negative there: the maximum is
    /// then its second argument.
    fn level(&self, orders: &[WithTerms<R>; STANDING_ORDERS]) -> R {
        (orders[1].value.abs() * self.instant).max(orders[0].level())
    }

    /// The rate that has jumped and leads away from what is slid along.
    fn departure(&self) -> Option<R> {
        let (rate, level) = self.rate?;
        (rate.abs() > level).then_some(rate)
    }

    /// Whether the motion leaves the surface by its rate, and its acceleration brings it back.
    fn comes_back(&self) -> bool {
        self.guards.iter().all(|(_, [_, rate, acceleration, _])| {
            rate.value > rate.level() && acceleration.value < -acceleration.level()
        })
    }

    /// The same for what is zero, or looked up, at the corner: the guards of pieces have its rate.
    fn surface_level(&self) -> R {
        if self.vector.is_some() {
            return self.surface.level();
        }
        let rate = (self.guards.first()).map_or(R::ZERO, |(_, orders)| orders[1].value.abs());
        (rate * self.instant).max(self.surface.level())
    }
}

/// Sides and pieces that may hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) sides: Sides,
    pub(super) pieces: Vec<i64>,
}

impl Candidate {
    pub(super) fn side(&self, surface: usize) -> Side {
        self.sides.get(surface)
    }

    pub(super) fn with_side(&self, surface: usize, side: Side) -> Self {
        Self {
            sides: self.sides.with(surface, side),
            pieces: self.pieces.clone(),
        }
    }

    /// The same, above whatever it slides along.
    pub(super) fn sliding_nowhere(&self) -> Self {
        let slid = (0..Sides::MOST).filter(|&k| self.side(k) == Side::Sliding);
        slid.fold(self.clone(), |free, k| free.with_side(k, Side::Above))
    }
}

/// How a trajectory stood to corners before something changed.
#[derive(Clone, Debug)]
pub(super) struct Earlier {
    sides: Sides,
    pieces: Vec<i64>,
    /// The surfaces that anything depended on. The side of another is as it was left, wherever the state has come since.
    watched: Surfaces,
}

/// The one of several numbers that is most clearly not zero.
fn clearest<R: Real>(of: &[WithTerms<R>]) -> Option<WithTerms<R>> {
    let clearness = |number: &WithTerms<R>| match number.value == R::ZERO {
        true => R::ZERO,
        false => number.value.abs() / number.level(),
    };
    (of.iter().copied()).reduce(|a, b| if clearness(&b) > clearness(&a) { b } else { a })
}

impl<R: Real> Trajectory<R> {
    /// What holds the state beside contact forces.
    pub fn held(&self, system: &System) -> Held {
        let mut held = Held::default();
        let surfaces = 0..system.corners().surfaces.len();
        for surface in surfaces.filter(|&k| self.regime.get(k) == Side::Sliding) {
            match system.rubbing().iter().find(|r| r.surface == surface) {
                None => held.surfaces.push(surface),
                Some(rubs) if self.closed.contains(rubs.contact) => {
                    held.contacts.push(rubs.contact);
                }
                Some(_) => {}
            }
        }
        held
    }

    /// Finds side and piece of every corner by the values at the state.
    pub(super) fn place_on_sides(&mut self, system: &System) -> Result<(), FlowError> {
        if system.corners().is_empty() {
            return Ok(());
        }
        let state = &self.state[..self.coordinates];
        let graph = &system.model().graph;
        let (sides, pieces) = system.corners().at(graph, state, &self.parameters);
        self.take_sides(system, &Candidate { sides, pieces })
    }

    /// Sets sides and pieces; the mode is entered by the caller.
    fn take_sides(&mut self, system: &System, candidate: &Candidate) -> Result<(), FlowError> {
        self.regime = candidate.sides;
        if self.pieces == candidate.pieces {
            return Ok(());
        }
        let (corners, graph) = (system.corners(), &system.model().graph);
        let mut parameters = Vec::with_capacity(corners.slots());
        for (index, &piece) in candidate.pieces.iter().enumerate() {
            let Some(slots) = corners.slots_of::<R>(graph, index, piece) else {
                let state = &self.state[..self.coordinates];
                let argument = corners.lookups[index].argument;
                let argument = graph.evaluate(argument, state, &self.parameters);
                return Err(self.outside_table(system, index, argument));
            };
            parameters.extend(slots);
        }
        self.parameters.truncate(corners.first_slot);
        self.parameters.extend(parameters);
        self.pieces.clone_from(&candidate.pieces);
        self.pass_knots();
        Ok(())
    }

    /// Sides and pieces as they are now.
    pub(super) fn standing_sides(&self) -> Candidate {
        Candidate {
            sides: self.regime,
            pieces: self.pieces.clone(),
        }
    }

    /// What changes are told against.
    pub(super) fn standing_now(&self, system: &System) -> Earlier {
        let all = Surfaces::all(system.corners().surfaces.len());
        let of = |program: &Program| {
            let corners = program.standings.iter().map(|tapes| tapes.corner);
            corners.fold(Surfaces::default(), |found, corner| match corner {
                Corner::Surface(index) => found.with(index),
                Corner::Lookup(_) => found,
            })
        };
        Earlier {
            sides: self.regime,
            pieces: self.pieces.clone(),
            watched: system.program(self.mode).map_or(all, of),
        }
    }

    /// Enters the mode of these sides, the same contacts closed; whether there is one.
    pub(super) fn try_sides(
        &mut self,
        system: &System,
        candidate: &Candidate,
    ) -> Result<bool, FlowError> {
        self.take_sides(system, candidate)?;
        let exists = |grip: Grip| system.program(system.meet(grip, self.regime)).is_some();
        if !exists(self.grip()) && !exists(self.grip().without_forces()) {
            return Ok(false);
        }
        self.enter(system, self.closed)?;
        Ok(true)
    }

    /// The functions of the surfaces of the present mode, and their rates.
    pub(super) fn corner_values(
        &self,
        system: &System,
    ) -> Result<Vec<(usize, WithTerms<R>, R)>, FlowError> {
        let of = |standing: Standing<R>| match standing.corner {
            Corner::Surface(index) if standing.vector.is_none() => {
                let rate = (standing.guards.first()).map_or(R::ZERO, |(_, orders)| orders[1].value);
                Some((index, standing.surface, rate))
            }
            _ => None,
        };
        let standings = self.standings(system)?;
        Ok(standings.into_iter().filter_map(of).collect())
    }

    fn standings(&self, system: &System) -> Result<Vec<Standing<R>>, FlowError> {
        self.standings_at(system, (&self.state, &self.low))
    }

    /// How another state stands to the corners of the present mode.
    fn standings_at(
        &self,
        system: &System,
        start: (&[R], &[R]),
    ) -> Result<Vec<Standing<R>>, FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(Vec::new());
        };
        let is_met = |corner: Corner| {
            let expr = |corner: Corner| system.corner_expr(corner);
            let with = matches!(corner, Corner::Surface(k) if self.met_with.contains(k));
            with || self.met.is_some_and(|met| expr(corner) == expr(met))
        };
        let instant = self.instant();
        let standing = |(tapes, constants): (&StandingTapes, &[Vec<R>; STANDING_TAPES])| {
            let values = with_terms(&tapes.values, &constants[0], start);
            let vector = match tapes.components.outputs.is_empty() {
                true => None,
                false => clearest(&with_terms(&tapes.components, &constants[3], start)),
            };
            let (orders, rate) = values[1..].split_at(tapes.guards.len() * STANDING_ORDERS);
            let guards = (tapes.guards.iter().zip(orders.chunks(STANDING_ORDERS)))
                .map(|(&kind, orders)| {
                    let mut own = [WithTerms::exact(R::ZERO); STANDING_ORDERS];
                    own.copy_from_slice(orders);
                    (kind, own)
                })
                .collect();
            Standing {
                corner: tapes.corner,
                surface: vector.unwrap_or(values[0]),
                vector,
                is_kept: tapes.is_kept,
                rate: match rate {
                    // The faster of both accelerations, in whatever direction.
                    [rate, jump, mean] => {
                        let fastest = jump.value.abs() + mean.value.abs();
                        Some((rate.value, rate.level().max(fastest * instant)))
                    }
                    _ => None,
                },
                guards,
                instant: if matches!(tapes.corner, Corner::Lookup(_)) || is_met(tapes.corner) {
                    instant
                } else {
                    R::ZERO
                },
            }
        };
        let mut standings: Vec<Standing<R>> = (program.standings.iter().zip(&constants.standings))
            .map(standing)
            .collect();
        // Those that others are functions of come first.
        standings.sort_by_key(|standing| system.corner_expr(standing.corner));
        Ok(standings)
    }

    /// Puts the mode right after the state, or what is closed, may have changed by a jump, or has met the corner `met`. Tells
    /// of what changes. Returns whether anything did.
    pub(super) fn settle_corners(
        &mut self,
        system: &System,
        met: Option<Corner>,
    ) -> Result<bool, FlowError> {
        let before = self.standing_now(system);
        self.put_right(system, met)?;
        Ok(self.tell_changes_since(system, &before))
    }

    /// After a jump: goes over to the sides that the state is clearly on. What it lies on is left as it is.
    pub(super) fn follow_jump(&mut self, system: &System) -> Result<(), FlowError> {
        let count = system.corners().surfaces.len() + system.corners().lookups.len();
        for _ in 0..count {
            let standings = self.standings(system)?;
            let Some(candidate) = standings.iter().find_map(|s| self.beyond(system, s)) else {
                break;
            };
            self.try_sides(system, &candidate)?;
        }
        Ok(())
    }

    /// As [`settle_corners`](Self::settle_corners), telling nothing.
    pub(super) fn put_right(
        &mut self,
        system: &System,
        met: Option<Corner>,
    ) -> Result<(), FlowError> {
        if system.corners().is_empty() {
            return Ok(());
        }
        let (mode, balanced) = (self.mode, self.balanced_contacts(system)?);
        self.follow_counters(system)?;
        let count = system.corners().surfaces.len() + system.corners().lookups.len();
        let mut chosen: Vec<Corner> = Vec::new();
        for _ in 0..4 * count + 4 {
            let standings = self.standings(system)?;
            // What a corner that was met takes along by a jump is a rounding error beyond, or not, until it is chosen.
            let is_first = met.is_some_and(|met| !chosen.contains(&met));
            // Friction of several contacts may oppose one rate: their surfaces are met together. Where a function is looked up
            // at a knot it is no zero of the same function, and the other way round.
            let is_met = |corner: Corner| {
                met.is_some_and(|met| {
                    corner.is_surface() == met.is_surface()
                        && system.corner_expr(corner) == system.corner_expr(met)
                })
            };
            let beyond = (standings.iter())
                .filter(|_| !is_first)
                .filter(|standing| !is_met(standing.corner) && !chosen.contains(&standing.corner))
                .find_map(|standing| Some((standing, self.beyond(system, standing)?)));
            if let Some((standing, candidate)) = beyond {
                if standing.departure().is_some() {
                    // It leaves from the very surface, whatever rounding says.
                    self.met = Some(standing.corner);
                }
                self.try_sides(system, &candidate)?;
                continue;
            }
            let beside = (standings.iter())
                .filter(|s| !is_met(s.corner) && !chosen.contains(&s.corner))
                .filter(|standing| self.is_touched(system, standing))
                .find_map(|standing| self.on_side_of_gap(system, standing.corner));
            if let Some(candidate) = beside {
                self.try_sides(system, &candidate)?;
                continue;
            }
            let touched: Vec<Corner> = (standings.iter())
                .filter(|standing| !chosen.contains(&standing.corner))
                .filter(|standing| is_met(standing.corner) || self.is_touched(system, standing))
                .map(|standing| standing.corner)
                .collect();
            if touched.is_empty() {
                self.check_ranges(system, &standings)?;
                break;
            }
            // What is slid along is held by fields that may jump here.
            let slid = (standings.iter())
                .map(|standing| standing.corner)
                .filter(|&corner| {
                    let slides = matches!(corner, Corner::Surface(k)
                    if self.regime.get(k) == Side::Sliding);
                    slides && !touched.contains(&corner) && !chosen.contains(&corner)
                });
            let slid: Vec<Corner> = slid.collect();
            let touched = [touched, slid].concat();
            self.choose_sides(system, (&touched, met))?;
            chosen.extend(touched);
        }
        // The balance of a contact holds in one mode: in the same one still, whatever others were asked.
        for &guard in balanced.iter().filter(|_| self.mode == mode) {
            self.touching.set(guard, Touching::BALANCED);
        }
        match self.jam(system) {
            Some(contact) => Err(self.jammed(contact)),
            None => Ok(()),
        }
    }

    /// What only jumps change is on the side, and in the piece, where plain evaluation says: no motion has led there.
    fn follow_counters(&mut self, system: &System) -> Result<(), FlowError> {
        if system.counted().is_empty() {
            return Ok(());
        }
        let mut counted = self.standing_sides();
        let state = &self.state[..self.coordinates];
        let (sides, pieces) = (system.corners()).at(&system.model().graph, state, &self.parameters);
        for &corner in system.counted() {
            match corner {
                Corner::Surface(index) => {
                    counted.sides = counted.sides.with(index, sides.get(index));
                }
                Corner::Lookup(index) => counted.pieces[index] = pieces[index],
            }
        }
        if counted != self.standing_sides() {
            self.try_sides(system, &counted)?;
        }
        Ok(())
    }

    /// Tells of corners that are not as they were; whether there are any.
    pub(super) fn tell_changes_since(&mut self, system: &System, before: &Earlier) -> bool {
        let changed = before.sides != self.regime || before.pieces != self.pieces;
        if changed {
            self.tell_changes(system, before);
        }
        changed
    }

    /// The sides without a contradiction: the state is clearly beyond the corner.
    fn beyond(&self, system: &System, standing: &Standing<R>) -> Option<Candidate> {
        let mut candidate = self.standing_sides();
        match standing.corner {
            Corner::Surface(index) => {
                let value = standing.surface.value;
                let (value, clear) = match standing.departure() {
                    Some(rate) => (rate, true),
                    None => (value, value.abs() > standing.surface_level()),
                };
                let side = if value > R::ZERO || standing.vector.is_some() {
                    Side::Above
                } else {
                    Side::Below
                };
                if !clear || self.regime.get(index) == side {
                    return None;
                }
                candidate.sides = candidate.sides.with(index, side);
            }
            Corner::Lookup(index) => {
                let outside = (standing.guards.iter())
                    .any(|(_, orders)| orders[0].value < -standing.level(orders));
                if !outside {
                    return None;
                }
                let wide = standing.surface.value.to_double_double();
                let graph = &system.model().graph;
                let piece = system.corners().piece_at(graph, index, wide);
                if piece == self.pieces[index] {
                    return None;
                }
                candidate.pieces[index] = piece;
            }
        }
        Some(candidate)
    }

    fn is_touched(&self, system: &System, standing: &Standing<R>) -> bool {
        // What only jumps change is where plain evaluation says, at a threshold as well.
        if system.counted().contains(&standing.corner) {
            return false;
        }
        let reached =
            |orders: &[WithTerms<R>; STANDING_ORDERS]| orders[0].value <= standing.level(orders);
        if self.is_on_side_of_gap(system, standing.corner) {
            return false;
        }
        match standing.corner {
            Corner::Surface(index) if self.regime.get(index) == Side::Sliding => {
                standing.guards.is_empty()
                    || (standing.guards.iter())
                        .any(|(_, orders)| reached(orders) || !orders[0].value.is_finite())
            }
            _ if standing.vector.is_some() => {
                standing.surface.value.abs() <= standing.surface_level()
            }
            _ => (standing.guards.iter()).any(|(_, orders)| reached(orders)),
        }
    }

    /// Tells of surfaces crossed, entered and left. One that comes into use is crossed by nothing.
    fn tell_changes(&mut self, system: &System, before: &Earlier) {
        for surface in 0..system.corners().surfaces.len() {
            let (old, new) = (before.sides.get(surface), self.regime.get(surface));
            if old == new {
                continue;
            }
            let rubs = system.rubbing().iter().find(|r| r.surface == surface);
            let told = match (rubs.map(|rubs| rubs.contact), old, new) {
                (Some(contact), _, Side::Sliding) => Occurrence::Stick { contact },
                (Some(contact), Side::Sliding, side) if self.closed.contains(contact) => {
                    Occurrence::Slip { contact, side }
                }
                (Some(_), ..) => continue,
                (None, _, Side::Sliding) => Occurrence::Slide { surface },
                (None, Side::Sliding, side) => Occurrence::Leave { surface, side },
                (None, _, side) => Occurrence::Switch { surface, side },
            };
            // What was crossed and is crossed back at one instant is told neither time.
            let crossed = self.pending.iter().rposition(|before| {
                matches!(*before, Occurrence::Switch { surface: before, side } if before == surface && side == old)
            });
            match (told, crossed) {
                (Occurrence::Switch { .. }, Some(place)) => {
                    self.pending.remove(place);
                }
                (Occurrence::Switch { .. }, None) if !before.watched.contains(surface) => {}
                _ => self.pending.push_back(told),
            }
        }
    }
}
