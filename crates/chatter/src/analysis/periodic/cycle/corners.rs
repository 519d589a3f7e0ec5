//! Corners that a motion comes to at one instant.

use super::events::Events;
use super::itinerary::{Passage, Step};
use super::trace::Instant;
use crate::expressions::Side;
use crate::flow::leg::{Due, Jump, LegKind};
use crate::flow::{GuardKind, Occurrence, System};

/// A surface is met with another one if its function vanishes within this part of the time: others have jumped, or came into use or out of it.
const MET: f64 = 1e-11;
/// Two surfaces are always met together if the slopes of their times agree to this part.
const SAME_SLOPES: f64 = 1e-9;
/// So many surfaces are crossed at one instant, at most, for which all orders are compared.
const MOST_TOGETHER: usize = 3;

/// How corners of one instant belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shared {
    /// Wherever the state is displaced to both come at one instant, as corners of the forcing do: they are one event.
    Always,
    /// Only here: beside the orbit one of them comes first.
    Here,
    /// The one is no event of its own: it was brought about by the other.
    No,
}

/// Of corners that are met at one instant the one with the least of these comes first, or stands for all: which of them a motion meets first is
/// rounding, and differs from turn to turn.
pub(super) const fn rank(guard: GuardKind) -> (u8, usize) {
    match guard {
        GuardKind::Piece(lookup, _) => (0, lookup),
        GuardKind::Switch(surface) => (1, surface),
        GuardKind::Leave(surface, _) => (2, surface),
        _ => (3, 0),
    }
}

/// When guards vanish in a mode.
pub(super) struct Before<'s> {
    system: &'s System,
    mode: usize,
    /// With those of the pieces.
    parameters: Vec<f64>,
    state: &'s [f64],
    /// The time that its roundings are compared with.
    time: f64,
}

impl<'s> Before<'s> {
    /// In the mode that one instant ends, where another one ends the motion: mostly the same.
    pub(super) fn new(
        (system, parameters): (&'s System, &[f64]),
        (in_mode, end): (&Instant, &'s Instant),
        span: f64,
    ) -> Self {
        Self {
            system,
            mode: in_mode.mode,
            parameters: system.with_pieces(parameters, &in_mode.pieces),
            state: &end.state,
            time: end.time.abs().max(span),
        }
    }

    fn due(&self, guard: GuardKind) -> Option<Due> {
        (self.system).due((self.mode, guard), &self.parameters, self.state)
    }

    /// How a guard shares the instant of another.
    pub(super) fn shared(&self, own: GuardKind, other: GuardKind) -> Shared {
        let Some(other) = self.due(other) else {
            return Shared::No;
        };
        if other.after.abs() > MET * self.time {
            return Shared::No;
        }
        let Some(own) = self.due(own) else {
            return Shared::Here;
        };
        let is_one = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_SLOPES * a.abs().max(b.abs());
        match own.slopes.iter().zip(&other.slopes).all(is_one) {
            true => Shared::Always,
            false => Shared::Here,
        }
    }
}

/// The mode across a surface that ends another mode.
fn across(system: &System, mode: usize, surface: usize) -> Option<usize> {
    let (grip, sides, _) = system.origin_of(mode)?;
    let other = match sides.get(surface) {
        Side::Above => Side::Below,
        Side::Below => Side::Above,
        Side::Sliding => return None,
    };
    let mode = system.meet(grip, sides.with(surface, other));
    system.program(mode).map(|_| mode)
}

/// The same crossings in the modes that this order of them leads through.
pub(in crate::analysis::periodic) fn in_order(
    system: &System,
    mode: usize,
    crossings: impl IntoIterator<Item = GuardKind>,
) -> Option<Vec<LegKind>> {
    let mut mode = mode;
    let mut found = Vec::new();
    for guard in crossings {
        let GuardKind::Switch(surface) = guard else {
            return None;
        };
        found.push(LegKind {
            mode,
            ends_at: Some(guard),
            jump: Jump::None,
        });
        mode = across(system, mode, surface)?;
    }
    Some(found)
}

/// Puts surfaces that are crossed at one instant into one order, if they can come in it.
pub(super) fn sort(system: &System, steps: &mut [Step]) {
    let mut begin = 0;
    while begin < steps.len() {
        let others = steps[begin + 1..].iter();
        let together = |step: &&Step| matches!(step.passage, Passage::Together(_));
        let end = begin + 1 + others.take_while(together).count();
        let chain = &mut steps[begin..end];
        begin = end;
        let guards: Option<Vec<GuardKind>> = chain.iter().map(Step::ends_at).collect();
        let (Some(mut guards), Passage::Leg(_)) = (guards, chain[0].passage) else {
            continue;
        };
        // What jumps has its place.
        let jumps = |step: &Step| match step.passage {
            Passage::Leg(kind) | Passage::Together(kind) => kind.jump != Jump::None,
            _ => true,
        };
        if chain.len() == 1 || chain.iter().any(jumps) {
            continue;
        }
        guards.sort_by_key(|guard| rank(*guard));
        let Some(kinds) = in_order(system, chain[0].mode(), guards) else {
            continue;
        };
        for (step, kind) in chain.iter_mut().zip(kinds) {
            step.passage = match step.passage {
                Passage::Leg(_) => Passage::Leg(kind),
                _ => Passage::Together(kind),
            };
        }
    }
}

impl Events {
    /// Corners of one instant: one event with what that brings about, or several surfaces that happen to be crossed together. What held the
    /// motion, sliding or contact, and does so no more has no time of its own, wherever the state is displaced to. None where something else
    /// happens, too.
    pub(super) fn corners(
        (system, parameters): (&System, &[f64]),
        instant: &Instant,
        span: f64,
    ) -> Option<Self> {
        let guard = instant.guard?;
        let is_corner = matches!(
            guard,
            GuardKind::Switch(_) | GuardKind::Piece(..) | GuardKind::Leave(..)
        );
        if !is_corner || instant.is_caused || instant.told.is_empty() {
            return None;
        }
        let before = Before::new((system, parameters), (instant, instant), span);
        let (mut own, mut crossings) = (guard, Vec::new());
        for told in &instant.told {
            match *told {
                Occurrence::Switch { surface, .. } if GuardKind::Switch(surface) != guard => {
                    let other = GuardKind::Switch(surface);
                    match before.shared(guard, other) {
                        Shared::Always if rank(other) < rank(own) => own = other,
                        Shared::Here => crossings.push(other),
                        Shared::Always | Shared::No => {}
                    }
                }
                Occurrence::Switch { .. }
                | Occurrence::Leave { .. }
                | Occurrence::Slip { .. }
                | Occurrence::Release { .. } => {}
                _ => return None,
            }
        }
        let first = LegKind {
            mode: instant.mode,
            ends_at: Some(own),
            jump: Jump::None,
        };
        crossings.push(own);
        crossings.sort_by_key(|guard| rank(*guard));
        if crossings.len() == 1 {
            return Some(Self {
                first,
                then: Vec::new(),
            });
        }
        if crossings.len() > MOST_TOGETHER {
            return None;
        }
        let GuardKind::Switch(last) = crossings[crossings.len() - 1] else {
            return None;
        };
        let kinds = in_order(system, instant.mode, crossings)?;
        let end = across(system, kinds.last()?.mode, last)?;
        (end == instant.mode_after).then(|| Self {
            first: kinds[0],
            then: kinds[1..].iter().copied().map(Passage::Together).collect(),
        })
    }
}
