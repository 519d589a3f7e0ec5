//! What a mode says of itself at corners that the state lies on: whether it holds there, and how it leaves them.

use super::choice::{Asked, Fields, change};
use super::vector::Leaves;
use super::{Candidate, Standing};
use crate::expressions::{Side, Sides, Surfaces};
use crate::flow::error::FlowError;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::standing::STANDING_ORDERS;
use crate::flow::system::System;
use crate::flow::touching::Touching;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::roots::flat_root::root_of;
use crate::numerics::{Real, WithTerms};
use core::cmp::Ordering;

/// A surface that may jump, and is so many times what cannot be told from zero, has jumped.
const JUMPS: f64 = 1024.0;

/// What a candidate says of the corners that are touched.
pub(super) struct Verdict<R> {
    pub(super) candidate: Candidate,
    /// Roots of its guards at the present state.
    pub(super) roots: Vec<(GuardKind, u8)>,
    /// Nothing moves it off a corner.
    pub(super) is_balanced: bool,
    /// Contacts that are closed stay so at least at first, …
    pub(super) contacts_stay: bool,
    /// … and all that carry push.
    pub(super) contacts_push: bool,
    /// On surfaces that closed contacts keep it on it is on the side that it leaves to with them.
    pub(super) opens_there: bool,
    /// How many contacts rub on a side without sliding, as others keep them from it.
    pub(super) loose: usize,
    /// On corners that nothing moves it off it is where plain evaluation says.
    pub(super) is_plain: bool,
    /// Of what vanishes at corners that nothing moves it off it takes no root.
    pub(super) is_smooth: bool,
    /// Surfaces that are at rest with it, their rates held at zero, and those that it leaves by their rates, only to come back.
    pub(super) rests: Surfaces,
    pub(super) comes_back: Surfaces,
    /// Those that nothing moves it off, and that it lies beside by rounding.
    pub(super) lies_beside: Vec<usize>,
    pub(super) fields: Fields<R>,
}

/// Whether a field has one.
fn has_values<R: Real>(fields: &Fields<R>) -> bool {
    fields[0].iter().all(|f| f.value.is_finite())
}

impl<R: Real> Trajectory<R> {
    /// What the present mode says of itself; none where it does not hold.
    pub(super) fn verdict(
        &mut self,
        system: &System,
        candidate: Candidate,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<Option<Verdict<R>>, FlowError> {
        if let Some(contact) = self.jam(system) {
            asked.singular = Some(self.jammed(contact));
            return Ok(None);
        }
        let mut fields = self.fields_here(system, asked)?;
        let at_zeros = self.at_zeros(system, &candidate, touched);
        if let Some(at_zeros) = at_zeros.filter(|_| !has_values(&fields)) {
            if self.try_sides(system, &at_zeros)? {
                fields = self.fields_here(system, asked)?;
            }
            self.try_sides(system, &candidate)?;
        }
        if !has_values(&fields) {
            asked.singular = self.singular_here(system);
            return Ok(None);
        }
        for (most, f) in asked.largest.iter_mut().zip(&fields[0]) {
            *most = most.max(f.value.abs());
        }
        let standings = self.standings_on_surfaces(system)?;
        let mut verdict = Verdict {
            candidate,
            roots: Vec::new(),
            is_balanced: false,
            contacts_stay: true,
            contacts_push: true,
            opens_there: true,
            loose: 0,
            is_plain: true,
            is_smooth: true,
            rests: Surfaces::default(),
            comes_back: Surfaces::default(),
            lies_beside: Vec::new(),
            fields,
        };
        let sides = verdict.candidate.sides;
        let is_slid =
            |corner: Corner| matches!(corner, Corner::Surface(k) if sides.get(k) == Side::Sliding);
        for standing in &standings {
            if touched.contains(&standing.corner) && !is_slid(standing.corner) {
                for (_, orders) in &standing.guards {
                    asked.note(standing.corner, orders);
                }
            }
        }
        // What an instant changes says nothing yet.
        let later = self.standings_at(system, (&asked.later.0, &asked.later.1))?;
        for (standing, later) in standings.iter().zip(&later) {
            if !touched.contains(&standing.corner) {
                continue;
            }
            let is_slid = is_slid(standing.corner);
            let may_slide = matches!(standing.corner, Corner::Surface(k)
                if asked.slippery.contains(k));
            let is_surface = standing.corner.is_surface();
            if is_slid && standing.guards.is_empty() {
                return Ok(None);
            }
            if standing.departure().is_some() {
                return Ok(None);
            }
            // What is held at a speed is not any more when that has jumped: its surface is elsewhere.
            let held = asked.held(standing.corner);
            let level = standing.surface.level().max(held) * R::splat(JUMPS);
            if is_slid
                && standing.surface.value.abs() > level
                && self.may_jump(system, standing.corner)
            {
                return Ok(None);
            }
            if standing.vector.is_some() {
                let Corner::Surface(index) = standing.corner else {
                    continue;
                };
                match (
                    self.leaves_zero(system, index, &verdict.candidate)?,
                    is_slid,
                ) {
                    (Leaves::Stays, true) => {}
                    (Leaves::After(roots), false) => {
                        verdict.roots.push((GuardKind::Switch(index), roots));
                    }
                    (Leaves::Untold, _) => {
                        asked.singular = self.singular_here(system);
                        return Ok(None);
                    }
                    _ => return Ok(None),
                }
                continue;
            }
            if let Corner::Surface(index) = standing.corner {
                if is_slid && standing.rate.is_some() {
                    verdict.rests = verdict.rests.with(index);
                } else if !is_slid && standing.comes_back() {
                    verdict.comes_back = verdict.comes_back.with(index);
                }
            }
            let rounding = match is_slid {
                true => [R::ZERO; STANDING_ORDERS],
                false => asked.rounding(standing.corner),
            };
            for ((kind, orders), (_, later)) in standing.guards.iter().zip(&later.guards) {
                // The surface of a side is touched, whatever rounding says, unless it has jumped at another corner; the ends of sliding
                // or of a piece may be far.
                let is_end = is_slid || !is_surface;
                let level = match is_end {
                    true => standing.level(orders),
                    false => standing.level(orders).max(held) * R::splat(JUMPS),
                };
                let is_clear = orders[0].value.abs() > level
                    && (is_end || self.may_jump(system, standing.corner));
                let is_far = is_clear && orders[0].value > level;
                // What follows the first that decides may be infinite, as the derivative of a root that begins here.
                let moving = (orders.iter().enumerate().skip(1)).find(|&(k, order)| {
                    let change = change(order.value, later[k].value);
                    let level = order.level().max(change).max(rounding[k]);
                    !order.value.is_finite() || order.value.abs() > level
                });
                // Nor does what is far from its end ask for them, as a share of fields along which a root begins.
                if is_far && orders[0].value.is_finite() {
                    continue;
                }
                let decides = orders.iter().take(1).chain(moving.map(|(_, order)| order));
                // Derivatives of what a root is taken of, other than the first, are those of the root.
                let off = self.moves_off_root(system, *kind)?;
                let decided = decides.into_iter().all(|order| order.value.is_finite());
                let is_known = match off {
                    Some((Ordering::Equal, _)) => moving.is_none_or(|(order, _)| order == 1),
                    Some(_) => false,
                    None => true,
                };
                let leaves = if decided && is_known {
                    if is_clear && orders[0].value < -level {
                        return Ok(None);
                    }
                    moving.map(|(order, moving)| (moving.value > R::ZERO, order as u8))
                } else {
                    let off = match off {
                        Some(off) => Some(off),
                        None => {
                            let begins = (standing.corner, *kind);
                            let moves = self.moves_by_a_root(system, begins, &verdict.fields[0])?;
                            moves.map(|moves| (moves, 1))
                        }
                    };
                    match off {
                        Some((Ordering::Greater, order)) => Some((true, order)),
                        Some((Ordering::Less, order)) => Some((false, order)),
                        Some((Ordering::Equal, _))
                            if !may_slide && self.may_rest_at(system, *kind)? =>
                        {
                            None
                        }
                        _ => {
                            asked.singular = self.singular_here(system);
                            return Ok(None);
                        }
                    }
                };
                // What four derivatives leave open the next may say; of what lies beside a surface by rounding they are rounding, too.
                let is_open = !is_end && decided && is_known && !standing.is_kept;
                let leaves = match leaves {
                    None if is_open && standing.surface.value == R::ZERO => {
                        let further = self.first_order(system, (*kind, STANDING_ORDERS))?;
                        let most = usize::from(Touching::BALANCED) - 1;
                        further.map(|(order, rises)| (rises, order.min(most) as u8))
                    }
                    leaves => leaves,
                };
                match leaves {
                    Some((false, _)) => return Ok(None),
                    Some((true, roots)) => verdict.roots.push((*kind, roots)),
                    None => {
                        verdict.is_balanced = true;
                        if let Corner::Surface(index) = standing.corner
                            && !is_slid
                            && standing.surface.value != R::ZERO
                            && !self.may_jump(system, standing.corner)
                        {
                            verdict.lies_beside.push(index);
                        }
                        verdict.loose +=
                            usize::from(!is_slid && self.rubs_at(system, standing.corner));
                        verdict.opens_there &=
                            is_slid || self.opens_there(system, standing.corner)?;
                        verdict.is_plain &= is_slid || self.is_plain(system, standing);
                        verdict.is_smooth &= root_of(self.program(system)?, *kind).is_none();
                        verdict.roots.push((*kind, Touching::BALANCED));
                    }
                }
            }
        }
        if self.presses_idle(system)? {
            return Ok(None);
        }
        [verdict.contacts_stay, verdict.contacts_push] = self.contacts_stay(system);
        Ok(Some(verdict))
    }

    /// How the state stands to corners once it is on the surfaces that the present mode slides along: what rounding has left beside
    /// these is no motion. One that may have jumped, or that the state runs away from, is left where it is.
    pub(super) fn standings_on_surfaces(
        &mut self,
        system: &System,
    ) -> Result<Vec<Standing<R>>, FlowError> {
        let standings = self.standings(system)?;
        let mut slid = (0..Sides::MOST).filter(|&k| self.regime.get(k) == Side::Sliding);
        let is_beside = slid.clone().next().is_some()
            && !slid.any(|index| self.may_jump(system, Corner::Surface(index)))
            && standings.iter().all(|s| s.departure().is_none());
        if !is_beside {
            return Ok(standings);
        }
        let beside = (self.state.clone(), self.low.clone());
        self.stay_on_surfaces(system)?;
        let standings = self.standings(system);
        (self.state, self.low) = beside;
        standings
    }

    /// Whether what is zero at a corner has corners itself.
    fn may_jump(&self, system: &System, corner: Corner) -> bool {
        match corner {
            Corner::Surface(index) => (system.corners()).is_nested(&system.model().graph, index),
            Corner::Lookup(_) => false,
        }
    }

    /// Where a guard without a derivative, the root of something that vanishes here, is a moment later, as long as steps off roots
    /// are; none if it has no value there.
    fn moves_by_a_root(
        &self,
        system: &System,
        (corner, kind): (Corner, GuardKind),
        field: &[WithTerms<R>],
    ) -> Result<Option<Ordering>, FlowError> {
        let unit = (self.reach.iter()).fold(self.longest_step, |most, &reach| most.max(reach));
        let moment = unit * R::splat(R::ROUNDOFF).sqrt();
        let (state, low) = self.after(moment, field);
        let standings = self.standings_at(system, (&state, &low))?;
        let value = (standings.iter().filter(|s| s.corner == corner))
            .flat_map(|standing| &standing.guards)
            .find(|(other, _)| *other == kind)
            .map(|(_, orders)| orders[0]);
        Ok(
            value.and_then(|value| match value.value.abs() > value.level() {
                true => value.value.partial_cmp(&R::ZERO),
                false => value.value.is_finite().then_some(Ordering::Equal),
            }),
        )
    }

    /// Whether no other motion begins where a guard vanishes than one that it vanishes along: no root of it has a slope without bound
    /// there.
    fn may_rest_at(&self, system: &System, kind: GuardKind) -> Result<bool, FlowError> {
        let program = self.program(system)?;
        let root = root_of(program, kind);
        Ok(root.is_none_or(|slot| self.has_slopes(program, &[slot]))
            || self.keeps_to_zero(system, kind)?)
    }

    /// That what must not vanish in the present mode does so.
    fn singular_here(&self, system: &System) -> Option<FlowError> {
        Some(self.singular_near(system)?.1)
    }

    /// Whether a corner is the rate of sliding of a contact that carries.
    fn rubs_at(&self, system: &System, corner: Corner) -> bool {
        let carrying = self.grip().carrying();
        let mut rubbing = system.rubbing().iter();
        rubbing.any(|r| corner == Corner::Surface(r.surface) && carrying.contains(r.contact))
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
}
