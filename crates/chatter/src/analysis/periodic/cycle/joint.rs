//! Chatter of several contacts that come to rest together.

use super::events::single;
use super::itinerary::{is_several, struck};
use super::trace::Instant;
use crate::expressions::{Expr, Node, Symbol};
use crate::flow::{Closed, Occurrence, System};
use crate::numerics::{DoubleDouble, Real};

/// Chatter of several contacts at once has neither a last impact nor a fixed order of them near its end: this last part of a period is
/// followed as a whole.
const JOINT_END: f64 = 1e-3;

/// Where the stretch of such chatter begins.
#[derive(Clone, Copy, Debug)]
pub(super) enum Joint {
    /// Just after this instant.
    After(usize),
    /// From this time on.
    Since(f64),
}

impl Joint {
    /// Of the chatter that ends at an instant, with its contacts, if it is that of several which rest there together.
    pub(super) fn ending(
        (system, instants): (&System, &[Instant]),
        index: usize,
        span: f64,
    ) -> Option<(Self, Closed)> {
        let end = &instants[index];
        let since = end.time - JOINT_END * span;
        let contacts = Closed(struck(&instants[..=index], since).0 & end.closed.0);
        if !is_several(contacts) {
            return None;
        }
        let begins = match forgets(system, end.mode_after, contacts) {
            true => Self::After(begin((instants, index), contacts)),
            false => Self::Since(since),
        };
        Some((begins, contacts))
    }

    /// Whether all of an instant is part of it.
    pub(super) fn begins_before(self, index: usize) -> bool {
        matches!(self, Self::After(begin) if begin < index)
    }

    /// Whether a step that begins at an instant is part of it.
    pub(super) fn has(self, instants: &[Instant], start: usize) -> bool {
        match self {
            Self::After(begin) => start >= begin,
            Self::Since(time) => instants[start].time >= time,
        }
    }
}

/// The instant after which nothing happens but impacts at these contacts, and ends of their chatter, up to where they rest: the first of
/// their impacts, where it is one by itself, or what came before it.
fn begin((instants, end): (&[Instant], usize), contacts: Closed) -> usize {
    let belongs = |told: &Occurrence<f64>| match *told {
        Occurrence::Impact { contact, .. }
        | Occurrence::Accumulation { contact, .. }
        | Occurrence::Cascade { contact, .. }
        | Occurrence::Graze { contact, .. } => contacts.contains(contact),
        Occurrence::Capture { .. } => true,
        _ => false,
    };
    let is_own = |index: &usize| {
        let instant = &instants[*index];
        !instant.told.is_empty() && instant.told.iter().all(belongs)
    };
    let run = (1..=end).rev().take_while(is_own);
    let first = run.last().unwrap_or(end);
    let is_alone = first < end
        && instants[first].impact().is_some()
        && single(&instants[first]).is_some()
        && instants[first - 1].time < instants[first].time;
    if is_alone { first } else { first - 1 }
}

/// Whether all that impacts at these contacts can change is held in a mode, in which they rest: then it is the same, with the same
/// derivatives, however it came there, and the order of those impacts is no matter of the orbit.
pub(in crate::analysis::periodic) fn forgets(
    system: &System,
    mode: usize,
    contacts: Closed,
) -> bool {
    let Some((grip, ..)) = system.origin_of(mode) else {
        return false;
    };
    let moved = reached(system, contacts);
    let carrying = grip.carrying();
    let gaps: Vec<Expr> = (carrying.contacts())
        .map(|contact| system.model().contacts[contact].gap)
        .collect();
    let held = system.model().graph.depend_on(&gaps, is_among(&moved));
    2 * held.into_iter().filter(|&is_held| is_held).count()
        == moved.iter().filter(|&&moves| moves).count()
}

fn is_among(moved: &[bool]) -> impl Fn(Symbol) -> bool {
    move |symbol| matches!(symbol, Symbol::State(index) if moved[index])
}

/// The states that impacts at these contacts can change, by themselves or through what follows from that: by the field, and by the impacts
/// and events that come otherwise then.
fn reached(system: &System, contacts: Closed) -> Vec<bool> {
    let model = system.model();
    let graph = &model.graph;
    let is_none = |by: Expr| graph.as_number(by) == Some(DoubleDouble::ZERO);
    let by_impulse = |along: &[Expr]| along.iter().map(|&by| !is_none(by)).collect();
    let by_reset = |image: &[Expr]| {
        let stays = |(index, to): (usize, &Expr)| matches!(graph.node(*to), Node::Symbol(Symbol::State(own)) if *own == index);
        image.iter().enumerate().map(|of| !stays(of)).collect()
    };
    let mut moved = vec![false; model.states.len()];
    let take = |moved: &mut Vec<bool>, by: Vec<bool>| {
        moved
            .iter_mut()
            .zip(by)
            .for_each(|(moves, by)| *moves |= by);
    };
    let hit = |moved: &mut Vec<bool>, contact: usize| {
        let of = &model.contacts[contact];
        let by = (of.reset.as_ref()).map_or_else(|| by_impulse(&of.impulse), |to| by_reset(to));
        take(moved, by);
        if let Some(friction) = &of.friction {
            take(moved, by_impulse(&friction.along));
        }
    };
    for contact in contacts.contacts() {
        hit(&mut moved, contact);
    }
    let fields = model.field();
    let gaps: Vec<Expr> = model.contacts.iter().map(|contact| contact.gap).collect();
    let surfaces = model.sections.iter().map(|section| section.surface);
    let surfaces: Vec<Expr> = surfaces.collect();
    loop {
        let before = moved.clone();
        let depend = |exprs: &[Expr]| graph.depend_on(exprs, is_among(&before));
        take(&mut moved, depend(&fields));
        for (contact, _) in depend(&gaps)
            .iter()
            .enumerate()
            .filter(|(_, meets)| **meets)
        {
            hit(&mut moved, contact);
        }
        let met = model.sections.iter().zip(depend(&surfaces));
        for (section, _) in met.filter(|(_, meets)| *meets) {
            if let Some(reset) = &section.reset {
                take(&mut moved, by_reset(reset));
            }
        }
        if moved == before {
            return moved;
        }
    }
}
