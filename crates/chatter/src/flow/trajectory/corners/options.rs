//! What may become of one corner: its sides, the piece on either side, or sliding where the fields of both sides differ.

use super::Candidate;
use super::choice::{Asked, Fields, vanishes};
use crate::expressions::Side;
use crate::flow::error::FlowError;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::standing::STANDING_ORDERS;
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::numerics::{Real, WithTerms};

/// What may become of one corner.
#[derive(Clone, Copy, Debug)]
pub(super) enum Choice {
    /// The side of a surface.
    Side(usize, Side),
    /// The piece of a lookup.
    Piece(usize, i64),
}

/// The motion on one side of a surface.
struct Beside<R> {
    field: Fields<R>,
    /// How fast the surface's function rises along it, and how much of that may be rounding, or what an instant changes.
    rate: Option<(R, R)>,
    /// It leads along it.
    is_kept: bool,
}

/// Whether the function of a surface moves, and as fast on both sides.
fn is_unheld<R: Real>(beside: &[Beside<R>]) -> bool {
    let rates = match beside {
        [above, below] => above.rate.zip(below.rate),
        _ => None,
    };
    rates.is_some_and(|((above, a), (below, b))| {
        (above - below).abs() <= a + b && above.abs() > a + b
    })
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

impl<R: Real> Trajectory<R> {
    /// What may become of one corner beside what `base` has chosen, the sides first.
    pub(super) fn options(
        &mut self,
        system: &System,
        (corner, met): (Corner, Option<Corner>),
        base: &Candidate,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<Vec<Choice>, FlowError> {
        match corner {
            // Of a vector any direction is on the one side of its zero.
            Corner::Surface(index) if system.corners().is_disc(index) => {
                asked.slippery = asked.slippery.with(index);
                Ok([Side::Above, Side::Sliding]
                    .map(|side| Choice::Side(index, side))
                    .to_vec())
            }
            Corner::Surface(index) => {
                let jumps = self.jumps(system, index, (base, touched, &mut *asked))?;
                if jumps {
                    asked.slippery = asked.slippery.with(index);
                }
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

    /// A candidate with one of its corners chosen. What is slid along has others on the sides that its two fields find themselves on:
    /// those may be in use on one side only, where the state has not been.
    pub(super) fn choose(
        &mut self,
        system: &System,
        (choice, base): (Choice, &Candidate),
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<Candidate, FlowError> {
        let Choice::Side(index, Side::Sliding) = choice else {
            return Ok(choice.made(base));
        };
        let mut found = base.clone();
        let sides = match system.corners().is_disc(index) {
            true => &[Side::Above][..],
            false => &[Side::Above, Side::Below],
        };
        for &side in sides {
            if self.ask_beside(system, &found.with_side(index, side), (touched, asked))? {
                found = self.standing_sides();
            }
        }
        Ok(found.with_side(index, Side::Sliding))
    }

    /// Whether the field differs on the two sides of a surface, so that it may be slid along; all else as in `base`.
    fn jumps(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        if let Some(rubs) = system.rubbing().iter().find(|r| r.surface == index) {
            return Ok(self.grip().carrying().contains(rubs.contact));
        }
        let agree = |beside: &[Beside<R>]| match beside {
            [above, below] => Some(vanishes(&above.field, &below.field)),
            _ => None,
        };
        let beside = self.beside(system, index, (base, touched, asked))?;
        let free = base.sliding_nowhere();
        let (slides, is_free) = (free != *base, is_unheld(&beside));
        // Nothing holds a rate that no side changes, unless by what is slid along elsewhere, which may end here.
        if is_free && !slides {
            return Ok(false);
        }
        if beside.iter().any(|beside| beside.is_kept) {
            // That side's motion is what sliding would be.
            return Ok(false);
        }
        let mut known = agree(&beside);
        if slides && (is_free || known != Some(false)) {
            let freely = self.beside(system, index, (&free, touched, asked))?;
            if is_free && is_unheld(&freely) {
                return Ok(false);
            }
            // What is slid along elsewhere may be so on one of these sides only, or hide the jump: of three bodies that hold each
            // other one pair is at rest whatever rubs between them.
            if known != Some(false) {
                known = agree(&freely).or(known);
            }
        }
        match known {
            Some(true) => self.is_held_by_nothing(system, index, (base, touched, asked)),
            _ => Ok(true),
        }
    }

    /// The fields on the sides of a surface, and the rates at which they lead across, as far as there are modes.
    fn beside(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<Vec<Beside<R>>, FlowError> {
        let instant = self.instant();
        let mut beside = Vec::with_capacity(2);
        for side in [Side::Above, Side::Below] {
            if self.ask_beside(system, &base.with_side(index, side), (touched, asked))? {
                let standings = self.standings(system)?;
                let own = (standings.iter()).find(|s| s.corner == Corner::Surface(index));
                let is_kept = own.is_some_and(|own| own.is_kept);
                let rate = own.and_then(|own| {
                    let (_, [_, rate, change, _]) = own.guards.first()?;
                    let level = rate.level() + change.value.abs() * instant;
                    let sign = R::splat(if side == Side::Below { -1.0 } else { 1.0 });
                    Some((rate.value * sign, level))
                });
                let field = self.fields_here(system, asked)?;
                beside.push(Beside {
                    field,
                    rate,
                    is_kept,
                });
            }
        }
        Ok(beside)
    }

    /// Whether sliding along a surface on which both fields agree is not at its end, as where friction begins that has nothing to hold
    /// yet: its share of either side is no quotient of what vanishes.
    fn is_held_by_nothing(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        let candidate = base.with_side(index, Side::Sliding);
        if !self.ask_beside(system, &candidate, (touched, asked))? {
            return Ok(false);
        }
        let standings = self.standings(system)?;
        let own = (standings.iter()).find(|s| s.corner == Corner::Surface(index));
        Ok(own.is_some_and(|own| {
            let lasts = |(_, orders): &(_, [WithTerms<R>; STANDING_ORDERS])| {
                let is_smooth = orders.iter().all(|order| order.value.is_finite());
                is_smooth && orders[0].value > own.level(orders)
            };
            !own.guards.is_empty() && own.guards.iter().all(lasts)
        }))
    }
}
