//! Which side of each surface the state is on, and which piece of each lookup holds (MATH.md 9).
//!
//! At a corner every mode that could follow is asked whether it does: on a side, the first derivative of the surface along
//! that side's own field that can be told from zero points away from it; sliding, each field has a part in it. A crossing has one
//! answer, attracting sliding one, repelling sliding several.

use super::Trajectory;
use crate::expressions::{LookedUpIn, Side, Sides};
use crate::flow::error::FlowError;
use crate::flow::limits::Corner;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, GuardKind, Held, STANDING_ORDERS};
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::touching::Touching;
use crate::numerics::{Real, WithTerms};

/// So many modes are asked at a corner of several surfaces, not more.
const MOST_CANDIDATES: usize = 81;

/// Switches without a flight longer than rounding between them: more than so many do not come to an end.
const MOST_SWITCHES: usize = 1000;

/// How the state stands to a corner in a mode.
struct Standing<R> {
    corner: Corner,
    surface: WithTerms<R>,
    guards: Vec<(GuardKind, [WithTerms<R>; STANDING_ORDERS])>,
}

/// Sides and pieces that may hold.
#[derive(Clone, Debug, PartialEq)]
struct Candidate {
    sides: Sides,
    pieces: Vec<i64>,
}

/// What may become of one corner.
#[derive(Clone, Copy, Debug)]
enum Choice {
    /// The side of a surface.
    Side(usize, Side),
    /// Another piece of a lookup, so many further up.
    Piece(usize, i64),
}

impl Choice {
    fn made(self, base: &Candidate) -> Candidate {
        let mut candidate = base.clone();
        match self {
            Self::Side(index, side) => candidate.sides = candidate.sides.with(index, side),
            Self::Piece(index, by) => candidate.pieces[index] += by,
        }
        candidate
    }
}

/// What a candidate says of the corners that are touched.
struct Verdict<R> {
    candidate: Candidate,
    /// Roots of its guards at the present state.
    roots: Vec<(GuardKind, u8)>,
    /// Nothing moves it off a corner.
    is_balanced: bool,
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
        let first = corners.first_slot;
        self.parameters.truncate(first);
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
            self.parameters.extend(slots);
        }
        self.pieces.clone_from(&candidate.pieces);
        self.forget_constants();
        Ok(())
    }

    /// Sides and pieces as they are now.
    fn standing_sides(&self) -> Candidate {
        Candidate {
            sides: self.regime,
            pieces: self.pieces.clone(),
        }
    }

    /// Enters the mode of these sides, the same contacts closed; whether there is one.
    fn try_sides(&mut self, system: &System, candidate: &Candidate) -> Result<bool, FlowError> {
        self.take_sides(system, candidate)?;
        let mode = system.meet(self.closed, self.regime);
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
        let standing = |(tapes, constants): (&super::StandingTapes, &[Vec<R>; 2])| {
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
            }
        };
        Ok((program.standings.iter().zip(&constants.standings))
            .map(standing)
            .collect())
    }

    /// Puts the mode right after the state, or what is closed, may have changed by a jump, or has met the corner `met`. Tells
    /// of what changes. Returns whether anything did.
    pub(super) fn settle_corners(
        &mut self,
        system: &System,
        met: Option<Corner>,
    ) -> Result<bool, FlowError> {
        if system.corners().is_empty() {
            return Ok(false);
        }
        let before = self.standing_sides();
        let count = system.corners().surfaces.len() + system.corners().lookups.len();
        let mut chosen: Vec<Corner> = Vec::new();
        for _ in 0..4 * count + 4 {
            let standings = self.standings(system)?;
            let beyond = (standings.iter())
                .filter(|standing| {
                    Some(standing.corner) != met && !chosen.contains(&standing.corner)
                })
                .find_map(|standing| self.beyond(system, standing));
            if let Some(candidate) = beyond {
                self.try_sides(system, &candidate)?;
                continue;
            }
            let touched: Vec<Corner> = (standings.iter())
                .filter(|standing| !chosen.contains(&standing.corner))
                .filter(|standing| Some(standing.corner) == met || self.is_touched(standing))
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
            self.choose_sides(system, &touched)?;
            chosen.extend(touched);
        }
        let changed = before != self.standing_sides();
        if changed {
            self.tell_changes(system, before.sides);
        }
        Ok(changed)
    }

    /// The sides without a contradiction: the state is clearly beyond the corner.
    fn beyond(&self, system: &System, standing: &Standing<R>) -> Option<Candidate> {
        let mut candidate = self.standing_sides();
        match standing.corner {
            Corner::Surface(index) => {
                let value = standing.surface;
                let clear = value.value.abs() > value.level();
                let side = if value.value > R::ZERO {
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
                    .any(|(_, orders)| orders[0].value < -orders[0].level());
                if !outside {
                    return None;
                }
                let wide = standing.surface.value.to_double_double();
                let graph = &system.model().graph;
                let piece = match system.corners().lookups[index].within {
                    LookedUpIn::WholeNumbers => libm::floor(wide.to_f64()) as i64,
                    LookedUpIn::Curve(id) => graph.curve(id).piece_at(wide),
                };
                if piece == self.pieces[index] {
                    return None;
                }
                candidate.pieces[index] = piece;
            }
        }
        Some(candidate)
    }

    fn is_touched(&self, standing: &Standing<R>) -> bool {
        let reached = |value: &WithTerms<R>| value.value <= value.level();
        match standing.corner {
            Corner::Surface(index) if self.regime.get(index) == Side::Sliding => {
                standing.guards.is_empty()
                    || (standing.guards.iter())
                        .any(|(_, orders)| reached(&orders[0]) || !orders[0].value.is_finite())
            }
            _ => (standing.guards.iter()).any(|(_, orders)| reached(&orders[0])),
        }
    }

    /// Chooses sides at corners that the state lies on.
    fn choose_sides(&mut self, system: &System, touched: &[Corner]) -> Result<(), FlowError> {
        let now = self.standing_sides();
        let mut candidates = vec![now.clone()];
        for &corner in touched {
            let jumps = self.jumps(system, corner, &now)?;
            let options = self.options(system, corner, jumps)?;
            let wider = candidates.len() * options.len();
            if wider > MOST_CANDIDATES {
                return Err(self.no_mode(system, touched));
            }
            candidates = (options.iter())
                .flat_map(|option| candidates.iter().map(|base| option.made(base)))
                .collect();
        }
        let mut verdicts: Vec<Verdict<R>> = Vec::new();
        for candidate in candidates {
            if !self.try_sides(system, &candidate)? {
                continue;
            }
            verdicts.extend(self.verdict(system, candidate, touched)?);
        }
        let place = match verdicts.len() {
            0 => {
                self.try_sides(system, &now)?;
                return Err(self.no_mode(system, touched));
            }
            1 => 0,
            _ => {
                let current = verdicts.iter().position(|v| v.candidate == now);
                let agree = (verdicts.iter()).all(|v| same_field(&v.field, &verdicts[0].field));
                match current {
                    Some(place) if agree || verdicts[place].is_balanced => place,
                    _ if agree => 0,
                    _ => {
                        self.try_sides(system, &now)?;
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
        Ok(())
    }

    /// Whether the field differs on the two sides of a surface, so that it may be slid along; the present sides are kept.
    fn jumps(
        &mut self,
        system: &System,
        corner: Corner,
        now: &Candidate,
    ) -> Result<bool, FlowError> {
        let Corner::Surface(index) = corner else {
            return Ok(false);
        };
        if let Some(rubs) = system.rubbing().iter().find(|r| r.surface == index) {
            return Ok(self.closed.contains(rubs.contact));
        }
        let mut fields = Vec::with_capacity(2);
        for side in [Side::Above, Side::Below] {
            let mut candidate = now.clone();
            candidate.sides = now.sides.with(index, side);
            if self.try_sides(system, &candidate)? {
                fields.push(self.field_here(system)?);
            }
        }
        self.try_sides(system, now)?;
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

    /// What may become of one corner, the sides first.
    fn options(
        &self,
        system: &System,
        corner: Corner,
        jumps: bool,
    ) -> Result<Vec<Choice>, FlowError> {
        let mut options = Vec::new();
        match corner {
            Corner::Surface(index) => {
                let sides = [Side::Above, Side::Below, Side::Sliding];
                for &side in &sides[..if jumps { 3 } else { 2 }] {
                    options.push(Choice::Side(index, side));
                }
            }
            Corner::Lookup(index) => {
                let standings = self.standings(system)?;
                let own = standings.iter().find(|s| s.corner == corner);
                let reached = |end: Side| {
                    own.is_some_and(|own| {
                        (own.guards.iter()).any(|(kind, orders)| {
                            *kind == GuardKind::Piece(index, end)
                                && orders[0].value <= orders[0].level()
                        })
                    })
                };
                // The end that is nearer, where rounding says that neither is reached.
                let nearer = || {
                    let gap = |end: Side| {
                        own.and_then(|own| {
                            (own.guards.iter())
                                .find(|(kind, _)| *kind == GuardKind::Piece(index, end))
                                .map(|(_, orders)| orders[0].value.to_f64())
                        })
                    };
                    if gap(Side::Below) < gap(Side::Above) {
                        Side::Below
                    } else {
                        Side::Above
                    }
                };
                let mut ends: Vec<Side> = [Side::Below, Side::Above]
                    .into_iter()
                    .filter(|&end| reached(end))
                    .collect();
                if ends.is_empty() {
                    ends.push(nearer());
                }
                options.push(Choice::Piece(index, 0));
                for end in ends {
                    let by = if end == Side::Above { 1 } else { -1 };
                    options.push(Choice::Piece(index, by));
                }
            }
        }
        Ok(options)
    }

    /// What the present mode says of itself; none where it does not hold.
    fn verdict(
        &self,
        system: &System,
        candidate: Candidate,
        touched: &[Corner],
    ) -> Result<Option<Verdict<R>>, FlowError> {
        let field = self.field_here(system)?;
        if !field.iter().all(|f| f.value.is_finite()) {
            return Ok(None);
        }
        let mut verdict = Verdict {
            candidate,
            roots: Vec::new(),
            is_balanced: false,
            field,
        };
        for standing in self.standings(system)? {
            if !touched.contains(&standing.corner) {
                continue;
            }
            let is_slid = matches!(standing.corner, Corner::Surface(k)
                if verdict.candidate.sides.get(k) == Side::Sliding);
            let is_surface = matches!(standing.corner, Corner::Surface(_));
            if is_slid && standing.guards.is_empty() {
                return Ok(None);
            }
            for (kind, orders) in &standing.guards {
                // The surface of a side is touched, whatever rounding says; the ends of sliding or of a piece may be far.
                let is_far = orders[0].value > orders[0].level() && (is_slid || !is_surface);
                if !orders.iter().all(|order| order.value.is_finite()) {
                    return Ok(None);
                }
                if is_far {
                    continue;
                }
                if is_slid && orders[0].value < -orders[0].level() {
                    return Ok(None);
                }
                if !is_surface && orders[0].value < -orders[0].level() {
                    return Ok(None);
                }
                let moving = (orders.iter().enumerate().skip(1))
                    .find(|(_, order)| order.value.abs() > order.level());
                match moving {
                    Some((_, order)) if order.value < R::ZERO => return Ok(None),
                    Some((order, _)) => verdict.roots.push((*kind, (order as u8).min(2))),
                    None => {
                        verdict.is_balanced = true;
                        verdict.roots.push((*kind, Touching::BALANCED));
                    }
                }
            }
        }
        Ok(Some(verdict))
    }

    /// Tells of surfaces crossed, entered and left.
    fn tell_changes(&mut self, system: &System, before: Sides) {
        for surface in 0..system.corners().surfaces.len() {
            let (old, new) = (before.get(surface), self.regime.get(surface));
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
            self.pending.push_back(told);
        }
    }

    /// A corner was met by the motion itself.
    pub(super) fn meet_corner(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        kind: GuardKind,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let (corner, ends_sliding) = match kind {
            GuardKind::Switch(index) => (Corner::Surface(index), false),
            GuardKind::Leave(index, _) => (Corner::Surface(index), true),
            GuardKind::Piece(index, _) => (Corner::Lookup(index), false),
            _ => return Ok(None),
        };
        self.tracker.interrupt();
        self.flight_time = R::splat(FOREVER);
        self.burst += 1;
        if self.burst > MOST_SWITCHES {
            return Err(FlowError::SwitchesWithoutEnd {
                time: self.time.to_f64(),
                count: self.burst,
            });
        }
        // Sliding ends where its field is that of the side it ends to: columns go on as they are.
        let shifts = if ends_sliding {
            Vec::new()
        } else {
            self.corner_shifts(system, corner)?
        };
        self.shift_columns(system, work, &shifts, R::ONE)?;
        self.settle_corners(system, Some(corner))?;
        self.shift_columns(system, work, &shifts, -R::ONE)?;
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

    /// Contacts that are closed after a corner of their gap, or of the field, has been passed: a rate that has jumped away
    /// from zero opens them or is an impact.
    fn keep_contacts(&mut self, system: &System, work: &mut Workspace<R>) -> Result<(), FlowError> {
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
