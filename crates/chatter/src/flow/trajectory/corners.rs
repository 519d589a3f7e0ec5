//! Which side of each surface the state is on, and which piece of each lookup holds (MATH.md 9).
//!
//! At a corner every mode that could follow is asked whether it does: on a side, the first derivative of the surface along
//! that side's own field that can be told from zero points away from it; sliding, each field has a part in it. A crossing has one
//! answer, attracting sliding one, repelling sliding several.

use super::Trajectory;
use super::start::{is_inside, slack};
use crate::expressions::{LookedUpIn, Side, Sides, Surfaces};
use crate::flow::error::FlowError;
use crate::flow::guard::GuardKind;
use crate::flow::limits::Corner;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, Held, Program, STANDING_ORDERS};
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::touching::Touching;
use crate::numerics::linear::solve;
use crate::numerics::{Real, WithTerms};

/// So many modes are asked at a corner of several surfaces, not more.
const MOST_CANDIDATES: usize = 81;

/// Switches without a flight longer than rounding between them: more than so many do not come to an end.
const MOST_SWITCHES: usize = 256;

/// Knots that are met within so many roundoffs of the time, or of the longest step before, are met at one instant, as those of
/// arguments that are functions of each other: so much can rounding move a crossing.
const INSTANT_ROUNDOFFS: f64 = 8.0;

/// How the state stands to a corner in a mode.
struct Standing<R> {
    corner: Corner,
    surface: WithTerms<R>,
    guards: Vec<(GuardKind, [WithTerms<R>; STANDING_ORDERS])>,
    /// How long an instant is: nothing for surfaces but that which is met now, since a sequence of crossings may become as fast
    /// as that.
    instant: R,
}

impl<R: Real> Standing<R> {
    /// The values of a guard that cannot be told from zero: by their terms, or because an instant later or earlier they are.
    ///
    /// Beyond a corner an expression of its other side may have no rate, as a root of what is negative there: the maximum is
    /// then its second argument.
    fn level(&self, orders: &[WithTerms<R>; STANDING_ORDERS]) -> R {
        (orders[1].value.abs() * self.instant).max(orders[0].level())
    }

    /// The same for what is zero, or looked up, at the corner: the guards of pieces have its rate.
    fn surface_level(&self) -> R {
        let rate = (self.guards.first()).map_or(R::ZERO, |(_, orders)| orders[1].value.abs());
        (rate * self.instant).max(self.surface.level())
    }
}

/// Sides and pieces that may hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Candidate {
    sides: Sides,
    pieces: Vec<i64>,
}

/// How a trajectory stood to corners before something changed.
#[derive(Clone, Debug)]
pub(super) struct Earlier {
    sides: Sides,
    pieces: Vec<i64>,
    /// The surfaces that anything depended on. The side of another is as it was left, wherever the state has come since.
    watched: Surfaces,
}

/// What may become of one corner.
#[derive(Clone, Copy, Debug)]
enum Choice {
    /// The side of a surface.
    Side(usize, Side),
    /// The piece of a lookup.
    Piece(usize, i64),
}

impl Choice {
    fn made(self, base: &Candidate) -> Candidate {
        let mut candidate = base.clone();
        match self {
            Self::Side(index, side) => candidate.sides = candidate.sides.with(index, side),
            Self::Piece(index, piece) => candidate.pieces[index] = piece,
        }
        candidate
    }
}

/// What asking modes has shown beside their verdicts.
#[derive(Debug, Default)]
struct Asked {
    /// Some would leave a table.
    outside: Option<FlowError>,
    /// The equations of some are singular here.
    singular: Option<FlowError>,
}

/// What a candidate says of the corners that are touched.
struct Verdict<R> {
    candidate: Candidate,
    /// Roots of its guards at the present state.
    roots: Vec<(GuardKind, u8)>,
    /// Nothing moves it off a corner.
    is_balanced: bool,
    /// Contacts that are closed stay so at least at first.
    contacts_stay: bool,
    /// On surfaces that closed contacts keep it on it is on the side that it leaves to with them; and they stick, if they can.
    opens_there: bool,
    /// On corners that nothing moves it off it is where plain evaluation says.
    is_plain: bool,
    field: Vec<WithTerms<R>>,
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
                let LookedUpIn::Curve(id) = corners.lookups[index].within else {
                    return Err(self.left_domain());
                };
                let state = &self.state[..self.coordinates];
                let argument = corners.lookups[index].argument;
                return Err(FlowError::OutsideTable {
                    time: self.time.to_f64(),
                    table: graph.curve(id).name().to_owned(),
                    argument: graph.evaluate(argument, state, &self.parameters).to_f64(),
                });
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
        let mode = system.meet(self.grip(), self.regime);
        if system.program(mode).is_none() {
            return Ok(false);
        }
        self.enter(system, self.closed)?;
        Ok(true)
    }

    fn standings(&self, system: &System) -> Result<Vec<Standing<R>>, FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(Vec::new());
        };
        let start = (&self.state[..], &self.low[..]);
        let is_met = |corner: Corner| {
            let expr = |corner: Corner| system.corner_expr(corner);
            self.met.is_some_and(|met| expr(corner) == expr(met))
        };
        let standing = |(tapes, constants): (&super::StandingTapes, &[Vec<R>; 3])| {
            let values = with_terms(&tapes.values, &constants[0], start);
            let guards = (tapes.guards.iter().zip(values[1..].chunks(STANDING_ORDERS)))
                .map(|(&kind, orders)| {
                    let mut own = [WithTerms::exact(R::ZERO); STANDING_ORDERS];
                    own.copy_from_slice(orders);
                    (kind, own)
                })
                .collect();
            Standing {
                corner: tapes.corner,
                surface: values[0],
                guards,
                instant: if matches!(tapes.corner, Corner::Lookup(_)) || is_met(tapes.corner) {
                    self.negligible() * R::splat(INSTANT_ROUNDOFFS)
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
                .find_map(|standing| self.beyond(system, standing));
            if let Some(candidate) = beyond {
                self.try_sides(system, &candidate)?;
                continue;
            }
            let touched: Vec<Corner> = (standings.iter())
                .filter(|standing| !chosen.contains(&standing.corner))
                .filter(|standing| is_met(standing.corner) || self.is_touched(standing))
                .map(|standing| standing.corner)
                .collect();
            if touched.is_empty() {
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
                let clear = value.abs() > standing.surface_level();
                let side = if value > R::ZERO {
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

    fn is_touched(&self, standing: &Standing<R>) -> bool {
        let reached =
            |orders: &[WithTerms<R>; STANDING_ORDERS]| orders[0].value <= standing.level(orders);
        match standing.corner {
            Corner::Surface(index) if self.regime.get(index) == Side::Sliding => {
                standing.guards.is_empty()
                    || (standing.guards.iter())
                        .any(|(_, orders)| reached(orders) || !orders[0].value.is_finite())
            }
            _ => (standing.guards.iter()).any(|(_, orders)| reached(orders)),
        }
    }

    /// Chooses sides at corners that the state lies on.
    fn choose_sides(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
    ) -> Result<(), FlowError> {
        let now = self.standing_sides();
        let mut asked = Asked::default();
        // A corner that is touched only in some of the modes has its own options there.
        let mut touched = touched.to_vec();
        let verdicts = loop {
            touched.sort_by_key(|&corner| system.corner_expr(corner));
            let candidates = self.candidates(system, (&touched, met), &now, &mut asked)?;
            let mut verdicts: Vec<Verdict<R>> = Vec::new();
            let mut more = None;
            for candidate in candidates {
                if !self.ask(system, &candidate, &mut asked)?
                    || !self.pass_others(system, &touched, &mut asked)?
                {
                    continue;
                }
                let standings = self.standings(system)?;
                more = (standings.iter())
                    .find(|s| !touched.contains(&s.corner) && self.is_touched(s))
                    .map(|standing| standing.corner)
                    .or(more);
                let candidate = self.standing_sides();
                verdicts.extend(self.verdict(system, candidate, (&touched, &mut asked))?);
            }
            let Some(more) = more else { break verdicts };
            touched.push(more);
        };
        self.take_verdict(system, verdicts, (&now, &touched), asked)
    }

    /// Enters the one mode that says of itself that it holds.
    fn take_verdict(
        &mut self,
        system: &System,
        mut verdicts: Vec<Verdict<R>>,
        (now, touched): (&Candidate, &[Corner]),
        asked: Asked,
    ) -> Result<(), FlowError> {
        if verdicts.iter().any(|verdict| verdict.contacts_stay) {
            verdicts.retain(|verdict| verdict.contacts_stay);
        }
        if verdicts.iter().any(|verdict| verdict.opens_there) {
            verdicts.retain(|verdict| verdict.opens_there);
        }
        let place = match verdicts.len() {
            0 => {
                self.try_sides(system, now)?;
                return Err(asked
                    .outside
                    .or(asked.singular)
                    .unwrap_or_else(|| self.no_mode(system, touched)));
            }
            1 => 0,
            _ => {
                let current = verdicts.iter().position(|v| v.candidate == *now);
                let agree = (verdicts.iter()).all(|v| same_field(&v.field, &verdicts[0].field));
                let mut plain = (0..verdicts.len()).filter(|&place| verdicts[place].is_plain);
                match (current, plain.next(), plain.next()) {
                    (Some(place), ..) if agree || verdicts[place].is_balanced => place,
                    _ if agree => 0,
                    (_, Some(place), None) => place,
                    _ => {
                        self.try_sides(system, now)?;
                        return Err(FlowError::NotUnique {
                            time: self.time.to_f64(),
                            surfaces: names(system, touched),
                        });
                    }
                }
            }
        };
        let verdict = verdicts.swap_remove(place);
        self.try_sides(system, &verdict.candidate)?;
        for (kind, roots) in verdict.roots {
            self.touch(system, kind, roots);
        }
        // A rounding error beside what is slid along from here on would be a side.
        self.stay_on_surfaces(system)
    }

    /// All combinations of what may become of corners that are touched, those within others first: what a corner is a
    /// function of may jump at them.
    fn candidates(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
        now: &Candidate,
        asked: &mut Asked,
    ) -> Result<Vec<Candidate>, FlowError> {
        let mut candidates = vec![now.clone()];
        for &corner in touched {
            let mut wider: Vec<Candidate> = Vec::new();
            for base in &candidates {
                let options = self.options(system, (corner, met), base, asked)?;
                wider.extend(options.into_iter().map(|option| option.made(base)));
            }
            if wider.len() > MOST_CANDIDATES {
                return Err(self.no_mode(system, touched));
            }
            candidates = wider;
        }
        candidates.retain(|candidate| self.slide_alike(system, candidate.sides));
        Ok(candidates)
    }

    /// Whether contacts that carry and rub by one rate slide one way, or stick all.
    fn slide_alike(&self, system: &System, sides: Sides) -> bool {
        let carrying = self.grip().carrying();
        let rubbing = (system.rubbing().iter()).filter(|rubs| carrying.contains(rubs.contact));
        let rate = |surface: usize| system.corner_expr(Corner::Surface(surface));
        rubbing.clone().all(|one| {
            rubbing.clone().all(|other| {
                rate(one.surface) != rate(other.surface)
                    || sides.get(one.surface) == sides.get(other.surface)
            })
        })
    }

    /// As [`try_sides`](Self::try_sides); a piece beyond the end of a table is none, and noted.
    fn ask(
        &mut self,
        system: &System,
        candidate: &Candidate,
        asked: &mut Asked,
    ) -> Result<bool, FlowError> {
        match self.try_sides(system, candidate) {
            Err(outside @ FlowError::OutsideTable { .. }) => {
                asked.outside = Some(outside);
                Ok(false)
            }
            tried => tried,
        }
    }

    /// Puts the present candidate right where it says that other corners are clearly passed. Whether that is possible.
    fn pass_others(
        &mut self,
        system: &System,
        touched: &[Corner],
        asked: &mut Asked,
    ) -> Result<bool, FlowError> {
        let count = system.corners().surfaces.len() + system.corners().lookups.len();
        for _ in 0..count {
            let standings = self.standings(system)?;
            let others = (standings.iter()).filter(|s| !touched.contains(&s.corner));
            let Some(further) = others.filter_map(|s| self.beyond(system, s)).next() else {
                break;
            };
            if !self.ask(system, &further, asked)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the field differs on the two sides of a surface, so that it may be slid along; all else as in `base`.
    fn jumps(
        &mut self,
        system: &System,
        index: usize,
        (base, asked): (&Candidate, &mut Asked),
    ) -> Result<bool, FlowError> {
        if let Some(rubs) = system.rubbing().iter().find(|r| r.surface == index) {
            return Ok(self.grip().carrying().contains(rubs.contact));
        }
        let mut fields = Vec::with_capacity(2);
        for side in [Side::Above, Side::Below] {
            let mut candidate = base.clone();
            candidate.sides = base.sides.with(index, side);
            if self.ask(system, &candidate, asked)? {
                fields.push(self.field_here(system)?);
            }
        }
        Ok(match &fields[..] {
            [above, below] => !same_field(above, below),
            _ => true,
        })
    }

    /// The field of the present mode at the state.
    fn field_here(&self, system: &System) -> Result<Vec<WithTerms<R>>, FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(Vec::new());
        };
        let start = (&self.state[..], &self.low[..]);
        Ok(with_terms(&program.field, &constants.field, start))
    }

    /// What may become of one corner beside what `base` has chosen, the sides first.
    fn options(
        &mut self,
        system: &System,
        (corner, met): (Corner, Option<Corner>),
        base: &Candidate,
        asked: &mut Asked,
    ) -> Result<Vec<Choice>, FlowError> {
        match corner {
            Corner::Surface(index) => {
                let jumps = self.jumps(system, index, (base, asked))?;
                let sides = [Side::Above, Side::Below, Side::Sliding];
                let possible = &sides[..if jumps { 3 } else { 2 }];
                Ok((possible.iter())
                    .map(|&side| Choice::Side(index, side))
                    .collect())
            }
            Corner::Lookup(index) => {
                let stays = vec![Choice::Piece(index, base.pieces[index])];
                if !self.ask(system, base, asked)? {
                    return Ok(stays);
                }
                let standings = self.standings(system)?;
                let Some(own) = standings.iter().find(|s| s.corner == corner) else {
                    return Ok(stays);
                };
                // A knot that cannot be told from the argument is as large as that.
                let level = own.surface_level() * R::splat(2.0);
                let level = level.max(R::splat(f64::MIN_POSITIVE));
                let (graph, corners) = (&system.model().graph, system.corners());
                let at = |value: R| corners.piece_at(graph, index, value.to_double_double());
                let value = own.surface.value;
                let mut near = vec![base.pieces[index]];
                near.retain(|&piece| at(value - level) <= piece && piece <= at(value + level));
                near.extend([at(value - level), at(value), at(value + level)]);
                if met == Some(corner) && near.iter().all(|&piece| piece == base.pieces[index]) {
                    // The end that is nearer, where rounding says that neither is reached.
                    let gaps = own
                        .guards
                        .iter()
                        .map(|(_, orders)| orders[0].value.to_f64());
                    let gaps: Vec<f64> = gaps.collect();
                    let by = if gaps.first() < gaps.get(1) { -1 } else { 1 };
                    near.push(base.pieces[index] + by);
                }
                let mut options: Vec<Choice> = Vec::new();
                for (place, &piece) in near.iter().enumerate() {
                    if !near[..place].contains(&piece) {
                        options.push(Choice::Piece(index, piece));
                    }
                }
                Ok(options)
            }
        }
    }

    /// What the present mode says of itself; none where it does not hold.
    fn verdict(
        &self,
        system: &System,
        candidate: Candidate,
        (touched, asked): (&[Corner], &mut Asked),
    ) -> Result<Option<Verdict<R>>, FlowError> {
        let field = self.field_here(system)?;
        if !field.iter().all(|f| f.value.is_finite()) {
            asked.singular = self.singular_here(system);
            return Ok(None);
        }
        let mut verdict = Verdict {
            candidate,
            roots: Vec::new(),
            is_balanced: false,
            contacts_stay: true,
            opens_there: true,
            is_plain: true,
            field,
        };
        for standing in self.standings(system)? {
            if !touched.contains(&standing.corner) {
                continue;
            }
            let is_slid = matches!(standing.corner, Corner::Surface(k)
                if verdict.candidate.sides.get(k) == Side::Sliding);
            let is_surface = standing.corner.is_surface();
            if is_slid && standing.guards.is_empty() {
                return Ok(None);
            }
            for (kind, orders) in &standing.guards {
                // The surface of a side is touched, whatever rounding says; the ends of sliding or of a piece may be far.
                let level = standing.level(orders);
                let is_far = orders[0].value > level && (is_slid || !is_surface);
                // What follows the first that decides may be infinite, as the derivative of a root that begins here.
                let moving = (orders.iter().enumerate().skip(1)).find(|(_, order)| {
                    !order.value.is_finite() || order.value.abs() > order.level()
                });
                let decides = orders.iter().take(1).chain(moving.map(|(_, order)| order));
                if !decides.into_iter().all(|order| order.value.is_finite()) {
                    asked.singular = self.singular_here(system);
                    return Ok(None);
                }
                if is_far {
                    continue;
                }
                if (is_slid || !is_surface) && orders[0].value < -level {
                    return Ok(None);
                }
                match moving {
                    Some((_, order)) if order.value < R::ZERO => return Ok(None),
                    Some((order, _)) => verdict.roots.push((*kind, order as u8)),
                    None => {
                        verdict.is_balanced = true;
                        verdict.opens_there &=
                            is_slid || self.opens_there(system, standing.corner)?;
                        verdict.is_plain &= is_slid || self.is_plain(system, &standing);
                        verdict.roots.push((*kind, Touching::BALANCED));
                    }
                }
            }
        }
        verdict.contacts_stay = self.contacts_stay(system);
        Ok(Some(verdict))
    }

    /// What contacts at rest do to a surface as one of `opening` opens while the others stay closed: the side that it leaves
    /// to; none where they do nothing.
    fn side_of_opening(
        &self,
        system: &System,
        corner: Corner,
        (resting, opening): (Closed, Closed),
    ) -> Result<Option<Side>, FlowError> {
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

    /// Whether a surface that closed contacts keep the state on, as friction along the gap does at rest, is on the side that it
    /// leaves to when they open. Until then its force and theirs are not told apart.
    fn opens_there(&self, system: &System, corner: Corner) -> Result<bool, FlowError> {
        let Corner::Surface(index) = corner else {
            return Ok(true);
        };
        if let Some(rubs) = system.rubbing().iter().find(|r| r.surface == index) {
            // What does not slide, held by another contact, sticks as well.
            return Ok(!self.grip().carrying().contains(rubs.contact));
        }
        let side = self.side_of_opening(system, corner, (self.closed, self.closed))?;
        Ok(side.is_none_or(|side| self.regime.get(index) == side))
    }

    /// Takes each surface that the state lies on to the side that it leaves to where contacts at rest open: dry friction
    /// resists that.
    pub(super) fn resist_opening(
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
    pub(super) fn hold_by_contacts(
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

    /// That what must not vanish in the present mode does so.
    fn singular_here(&self, system: &System) -> Option<FlowError> {
        let state = &self.state[..self.coordinates];
        let (kind, expression) = system.singular_at(self.mode, state, &self.parameters)?;
        Some(FlowError::Singular {
            time: self.time.to_f64(),
            kind,
            expression,
        })
    }

    /// Whether plain evaluation takes the piece of a corner that the state is on.
    fn is_plain(&self, system: &System, standing: &Standing<R>) -> bool {
        let value = standing.surface.value;
        match standing.corner {
            Corner::Surface(index) => {
                self.regime.get(index) == system.corners().side_at(index, value)
            }
            Corner::Lookup(index) => {
                let graph = &system.model().graph;
                let wide = value.to_double_double();
                self.pieces[index] == system.corners().piece_at(graph, index, wide)
            }
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

    /// A corner was met by the motion itself; `jumps` where the field does there, which it does not where sliding ends.
    pub(super) fn meet_corner(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (corner, jumps): (Corner, bool),
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        if !(jumps && self.is_top(system, corner)?) {
            self.tracker.interrupt();
            self.tops.interrupt();
        }
        self.flight_time = R::splat(FOREVER);
        self.burst += 1;
        if self.burst > MOST_SWITCHES {
            return Err(FlowError::SwitchesWithoutEnd {
                time: self.time.to_f64(),
                count: self.burst,
            });
        }
        // Sliding ends where its field is that of the side it ends to: columns go on as they are.
        let shifts = if jumps {
            self.corner_shifts(system, corner)?
        } else {
            Vec::new()
        };
        self.shift_columns(system, work, &shifts, R::ONE)?;
        self.met = Some(corner);
        let before = match system.gaps_have_corners() {
            true => Some(self.touch_values(system)?.gap),
            false => None,
        };
        self.settle_corners(system, Some(corner))?;
        self.shift_columns(system, work, &shifts, -R::ONE)?;
        if let Some(before) = before {
            self.follow_gaps(system, &before)?;
        }
        self.keep_contacts(system, work)?;
        Ok(self.pending.pop_front())
    }

    /// The shifts of the time of a crossing, one a column of derivatives.
    fn corner_shifts(&self, system: &System, corner: Corner) -> Result<Vec<R>, FlowError> {
        if self.state.len() == self.coordinates {
            return Ok(Vec::new());
        }
        let program = self.program(system)?;
        let found = (program.standings.iter()).position(|tapes| tapes.corner == corner);
        let (Some(place), Some(constants)) = (found, &self.constants[self.mode]) else {
            return Ok(Vec::new());
        };
        let start = (&self.state[..], &self.low[..]);
        let tapes = &program.standings[place];
        let slopes = with_terms(&tapes.slopes, &constants.standings[place][1], start);
        let values = with_terms(&tapes.values, &constants.standings[place][0], start);
        // The surface's own rate, whatever the sign of the guard.
        let sign = match (corner, tapes.guards.first()) {
            (Corner::Surface(index), _) => R::splat(self.regime.get(index).sign()),
            (Corner::Lookup(_), _) => R::ONE,
        };
        let rate = values[2].value * sign;
        Ok(slopes.iter().map(|slope| -(slope.value / rate)).collect())
    }

    /// A gap may have jumped: the contact is open then, or the state inside an obstacle.
    fn follow_gaps(&mut self, system: &System, before: &[WithTerms<R>]) -> Result<(), FlowError> {
        let touch = self.touch_values(system)?;
        for (contact, (gap, before)) in touch.gap.iter().zip(before).enumerate() {
            // What a gap has left of terms that are gone is no jump.
            let jump = (gap.value - before.value).abs();
            if jump <= slack(gap).max(slack(before)) {
                continue;
            }
            if is_inside(gap) {
                return Err(FlowError::JumpsInside {
                    time: self.time.to_f64(),
                    contact,
                    gap: gap.value.to_f64(),
                });
            }
            if self.closed.contains(contact) && gap.value > slack(gap) {
                self.open(system, contact, 0)?;
                self.pending.push_back(Occurrence::Release { contact });
            }
        }
        Ok(())
    }

    /// Contacts that are closed after a corner of their gap, or of the field, has been passed: a rate that has jumped away
    /// from zero opens them or is an impact.
    pub(super) fn keep_contacts(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<(), FlowError> {
        if self.closed == Closed::NONE {
            return Ok(());
        }
        let touch = self.touch_values(system)?;
        let moves = |contact: usize| {
            let rate = &touch.rate[contact];
            rate.value.abs() > rate.level()
        };
        if !self.closed.contacts().any(moves) {
            // The force that holds a contact may have jumped, too.
            let pressed = |contact: usize| {
                let free = &touch.acceleration[contact];
                free.value < -free.level()
            };
            let mut members = self.closed.contacts();
            if let (Some(contact), None) = (members.next(), members.next())
                && pressed(contact)
            {
                return Ok(());
            }
            return self.rest_again(system, work);
        }
        let fastest = (self.closed.contacts()).min_by(|&a, &b| {
            let (a, b) = (touch.rate[a].value, touch.rate[b].value);
            a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
        });
        let Some(fastest) = fastest else {
            return Ok(());
        };
        if touch.rate[fastest].value < -touch.rate[fastest].level() {
            let told = self.collide(system, work, fastest, self.closed)?;
            self.pending.extend(told);
            return Ok(());
        }
        let leaving: Vec<usize> = self.closed.contacts().filter(|&c| moves(c)).collect();
        for contact in leaving {
            self.open(system, contact, 1)?;
            self.pending.push_back(Occurrence::Release { contact });
        }
        Ok(())
    }

    /// Decides anew which of the closed contacts stay closed; tells of those that open.
    fn rest_again(&mut self, system: &System, work: &mut Workspace<R>) -> Result<(), FlowError> {
        let before = self.closed;
        self.bring_to_rest(system, work, Closed::NONE)?;
        for contact in before.contacts().filter(|&c| !self.closed.contains(c)) {
            self.pending.push_back(Occurrence::Release { contact });
        }
        Ok(())
    }

    fn no_mode(&self, system: &System, touched: &[Corner]) -> FlowError {
        FlowError::NoMode {
            time: self.time.to_f64(),
            surfaces: names(system, touched),
        }
    }
}

/// Whether two fields move the state alike.
fn same_field<R: Real>(a: &[WithTerms<R>], b: &[WithTerms<R>]) -> bool {
    (a.iter().zip(b)).all(|(a, b)| (a.value - b.value).abs() <= a.level() + b.level())
}

fn names(system: &System, corners: &[Corner]) -> Vec<String> {
    corners
        .iter()
        .map(|&corner| system.corner_name(corner))
        .collect()
}
