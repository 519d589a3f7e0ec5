//! What holds in a mode and what ends it, as expressions.

use super::closed::{Closed, Grip};
use super::guard::GuardKind;
use super::limits::Limits;
use crate::expressions::{Expr, Graph};
use crate::flow::chatter::SequenceExprs;
use crate::model::{ContactMechanics, Direction, Mechanics, Section, Sticking};
use crate::numerics::roots::Crossing;

/// What holds while a set of contacts is closed, as expressions.
#[derive(Clone, Debug)]
pub(crate) struct ModeExprs {
    pub grip: Grip,
    /// Flight or sticking field.
    pub field: Vec<Expr>,
    /// One for each carrying contact, in order.
    pub reactions: Vec<Expr>,
    /// For each surface that is slid along, the share of the fields on both sides.
    pub shares: Vec<Expr>,
    /// The friction force of each contact that sticks.
    pub frictions: Vec<(usize, Expr)>,
    /// For each contact the state after an impact there.
    pub impacts: Vec<Vec<Expr>>,
    /// For each contact the state once its rate is taken away.
    pub rests: Vec<Vec<Expr>>,
    /// For each contact what its chatter sequences are completed by.
    pub sequences: Vec<SequenceExprs>,
}

impl ModeExprs {
    /// The mode in which these contacts are closed; none where they cannot be held together.
    pub(crate) fn new(mechanics: &mut Mechanics, grip: Grip) -> Option<Self> {
        let active: Vec<usize> = grip.carrying().contacts().collect();
        let held = if active.is_empty() && mechanics.slides.is_empty() {
            Sticking {
                field: mechanics.field.clone(),
                ..Sticking::default()
            }
        } else {
            mechanics.sticking(&active).ok()?
        };
        let contacts = mechanics.contacts.clone();
        let held_on = (&mechanics.unheld[..], &mechanics.slides[..]);
        let graph = &mut mechanics.graph;
        let rests: Vec<Vec<Expr>> = contacts
            .iter()
            .map(|contact| {
                (contact.jump.iter().enumerate())
                    .map(|(i, &jump)| {
                        let state = graph.state(i);
                        let stop = graph.mul(contact.rate, jump);
                        graph.sub(state, stop)
                    })
                    .collect()
            })
            .collect();
        let sequences = (contacts.iter().zip(&rests))
            .map(|(contact, rest)| SequenceExprs::new(graph, contact, (&held.field, rest), held_on))
            .collect();
        Some(Self {
            sequences,
            grip,
            field: held.field,
            reactions: held.reactions,
            shares: held.shares,
            frictions: held.frictions,
            impacts: contacts.into_iter().map(|c| c.after_impact).collect(),
            rests,
        })
    }
}

/// What ends a mode, in the order of its guards: of what happens at one instant resets come last, and sections after corners, which
/// say whether they are crossed. All but sections that are
/// crossed either way are positive until then.
pub(crate) fn guard_functions(
    graph: &mut Graph,
    contacts: &[ContactMechanics],
    (sections, limits): (&[Section], &Limits),
    mode: &ModeExprs,
) -> Vec<(GuardKind, Crossing, Expr)> {
    let open = (0..contacts.len()).filter(|&index| !mode.grip.closed.contains(index));
    let mut guards: Vec<(GuardKind, Crossing, Expr)> = open
        .map(|index| {
            (
                GuardKind::Gap(index),
                Crossing::Falling,
                contacts[index].gap,
            )
        })
        .collect();
    for (contact, &reaction) in mode.grip.carrying().contacts().zip(&mode.reactions) {
        let push = graph.neg(reaction);
        guards.push((GuardKind::Reaction(contact), Crossing::Falling, push));
    }
    let (resets, looks): (Vec<_>, Vec<_>) =
        (sections.iter().enumerate()).partition(|(_, section)| section.reset.is_some());
    let mut crossed = |(index, section): (usize, &Section)| {
        let (surface, crossing) = match section.direction {
            Direction::Falling => (section.surface, Crossing::Falling),
            Direction::Rising => (graph.neg(section.surface), Crossing::Falling),
            Direction::Either => (section.surface, Crossing::Either),
        };
        (GuardKind::Section(index), crossing, surface)
    };
    let limits = limits.guards();
    guards.extend(limits.map(|(kind, function)| (kind, Crossing::Falling, function)));
    guards.extend(looks.into_iter().map(&mut crossed));
    guards.extend(resets.into_iter().map(&mut crossed));
    guards
}

/// The sides that contacts keep the state on, as surfaces and sections are constant multiples of gaps: by number of the guard that
/// constant, with the sign of the side. As long as it keeps its sign nothing is crossed before the contact is met, whatever rounding says
/// of which comes first, and the impact leads away from it.
pub(super) fn kept_by_contacts(
    graph: &mut Graph,
    contacts: &[ContactMechanics],
    closed: Closed,
    listed: &[(GuardKind, Crossing, Expr)],
) -> Vec<(usize, Expr)> {
    let mut kept = Vec::new();
    for (guard, &(kind, _, function)) in listed.iter().enumerate() {
        let keeps = |contact: usize, graph: &mut Graph| {
            let factor = graph.factor_of(function, contacts[contact].gap)?;
            let is_kept = match (kind, graph.as_number(factor)) {
                (GuardKind::Section(_), _) => true,
                (_, Some(number)) => number.high() > 0.0,
                // A contact at rest says nothing of the sign of a parameter.
                (_, None) => !closed.contains(contact),
            };
            is_kept.then_some(factor)
        };
        if matches!(kind, GuardKind::Switch(_) | GuardKind::Section(_))
            && let Some(factor) = (0..contacts.len()).find_map(|contact| keeps(contact, graph))
        {
            kept.push((guard, factor));
        }
    }
    kept
}
