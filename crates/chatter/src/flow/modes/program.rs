//! What runs in one mode: the field that holds while a given set of contacts is closed, and its guards.

use super::at_contacts::{AtContacts, ImpactTape};
use super::closed::Closed;
use super::equations::ModeExprs;
use super::guard::{Guard, Transition};
use super::guarded::Guarded;
use super::limits::{Corner, Limits};
use super::looked_up::LookedUp;
use super::standing::{STANDING_TAPES, StandingTapes};
use crate::expressions::{Asked, Expr, Graph, Names, Operand, Symbol, Tape};
use crate::flow::chatter::{SequenceConstants, SequenceTapes};
use crate::flow::reset::ResetTapes;
use crate::flow::variation::Direction as Along;
use crate::model::{Mechanics, Section};
use crate::numerics::Real;
use core::sync::atomic::{AtomicU64, Ordering};

/// A formula longer than this is no help in a message.
const LONGEST_NAMED: usize = 200;

/// Everything that one mode needs.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) tape: Tape,
    /// What must not vanish, in the order of the tape's singular points.
    pub(crate) vanishing: Vec<String>,
    /// Whether a root is taken of what vanishes at the end of a side.
    pub(crate) roots_at_sides: bool,
    pub(crate) guards: Vec<Guard>,
    /// Whether nothing holds the state, no contact being closed and no surface slid along, and no impact moves a gap.
    pub(crate) is_free: bool,
    /// The contacts whose impacts may move their own gaps.
    pub(crate) moves_gap: Closed,
    /// How many of them are gaps.
    pub(crate) gaps: usize,
    /// Per contact; none where it is closed.
    pub(crate) impacts: Vec<Option<ImpactTape>>,
    /// Per contact: what its chatter sequences are completed by; none where it is closed.
    pub(crate) sequences: Vec<Option<SequenceTapes>>,
    /// Per contact: gap, rate, acceleration, jerk.
    pub(crate) locals: Vec<Tape>,
    /// Per contact: the state brought to rest on it (gap and rate zero).
    pub(crate) captures: Vec<Tape>,
    /// Gap and rate of each carrying contact, in order; then the surfaces that are slid along, and rates of sliding of
    /// contacts that stick.
    pub(crate) residuals: Tape,
    /// For each surface that is held so its gradient, zero for time.
    pub(crate) residual_gradients: Tape,
    /// For each section what its event does, if it is one.
    pub(crate) resets: Vec<Option<ResetTapes>>,
    /// What impacts at each contact and the reset of each section ask for, and the motion does not.
    pub(crate) asked_at_impacts: Vec<Asked>,
    pub(crate) asked_at_resets: Vec<Asked>,
    /// All of these; of each the surface, or argument, and its rate.
    pub(crate) asked: Vec<Corner>,
    pub(crate) asked_values: Tape,
    /// What the mode asks of each corner.
    pub(crate) standings: Vec<StandingTapes>,
    /// The field of the model's own states, at a point.
    pub(crate) field: Tape,
    /// Constants of the tapes that change at knots.
    pub(crate) looked_up: LookedUp,
}

/// The constants of a program's tapes at one parameter set.
#[derive(Clone, Debug)]
pub(crate) struct ProgramConstants<R> {
    /// A number that none have in which anything differs.
    pub edition: u64,
    pub tape: Vec<R>,
    pub impacts: Vec<Vec<R>>,
    pub sequences: Vec<SequenceConstants<R>>,
    pub locals: Vec<Vec<R>>,
    pub captures: Vec<Vec<R>>,
    pub residuals: Vec<R>,
    pub residual_gradients: Vec<R>,
    pub resets: Vec<[Vec<R>; 3]>,
    pub standings: Vec<[Vec<R>; STANDING_TAPES]>,
    pub field: Vec<R>,
    pub asked_values: Vec<R>,
}

fn next_edition() -> u64 {
    static LATEST: AtomicU64 = AtomicU64::new(0);
    LATEST.fetch_add(1, Ordering::Relaxed) + 1
}

impl Program {
    /// The guard that is the gap of a contact, and where its series stands, if that may close.
    pub(crate) fn gap_series(&self, contact: usize) -> Option<(usize, usize)> {
        let guard = (self.guards.iter()).position(|guard| guard.closing() == Some(contact))?;
        match self.guards[guard].series {
            Operand::Series(slot) => Some((guard, slot)),
            Operand::Constant(_) => None,
        }
    }

    /// Compiles a mode.
    pub(crate) fn new(
        mechanics: &mut Mechanics,
        (sections, limits): (&[Section], &Limits),
        directions: &[Along],
        time: Option<usize>,
        mode: &ModeExprs,
        names: Names<'_>,
    ) -> Self {
        let ModeExprs { grip, field, .. } = mode;
        let (closed, carrying) = (grip.closed, grip.carrying());
        let dimension = field.len();
        let coordinates = mechanics.field.len();
        let contacts = mechanics.contacts.clone();
        let guarded = Guarded::new(mechanics, &contacts, (sections, limits), mode);
        let graph = &mut mechanics.graph;
        let vanishing = (guarded.tape.singular.iter())
            .map(|singular| {
                let text = singular.expr.map(|expr| graph.to_text(expr, names));
                text.filter(|text| text.len() <= LONGEST_NAMED)
                    .unwrap_or_default()
            })
            .collect();
        let at_contacts = AtContacts::new(
            graph,
            mode,
            &contacts,
            (sections, limits),
            (coordinates, time),
        );
        let guards = guarded.guards(graph, |kind| {
            let acts = (
                |contact| at_contacts.alone.contains(contact),
                |contact: usize| !limits.impacts[contact].is_empty(),
            );
            let resets = |section: usize| sections[section].reset.is_some();
            Transition::new(kind, *grip, acts, resets)
        });
        let contacts_hold: Vec<Expr> = (carrying.contacts())
            .flat_map(|contact| [contacts[contact].gap, contacts[contact].rate])
            .collect();
        let others_hold = held_beside_contacts(mechanics, carrying);
        let residuals = [&contacts_hold[..], &others_hold[..]].concat();
        let graph = &mut mechanics.graph;
        let moving = contacts.iter().enumerate().filter(|(_, c)| c.moves_gap);
        let moves_gap = moving.fold(Closed::NONE, |all, (contact, _)| all.with(contact));
        let is_free = closed == Closed::NONE && residuals.is_empty() && moves_gap == Closed::NONE;
        let mut gradients = Vec::new();
        // What contacts alone hold goes back along their impulses.
        if !others_hold.is_empty() {
            for &residual in &residuals {
                gradients.extend((0..coordinates).map(|i| match Some(i) == time {
                    true => graph.number(0.0),
                    false => graph.derivative(residual, Symbol::State(i)),
                }));
            }
        }
        let residuals = Tape::new(graph, dimension, &[], &residuals);
        let residual_gradients = Tape::new(graph, dimension, &[], &gradients);
        let resets = (sections.iter())
            .map(|section| ResetTapes::new(graph, section, field, directions, coordinates))
            .collect();
        let standings = (limits.corners.iter())
            .map(|limit| {
                let motion = (&field[..], coordinates);
                StandingTapes::new(graph, limit, motion, &contacts, directions)
            })
            .collect();
        let asked: Vec<Expr> = (limits.asked.iter())
            .flat_map(|&(_, value)| [value, graph.lie_derivative(value, field)])
            .collect();
        let asked_values = Tape::new(graph, dimension, &[], &asked);
        let at_point = Tape::new(graph, dimension, &[], &field[..mechanics.field.len()]);
        let roots_at_sides = guards.iter().any(|guard| guard.ends_a_root(&guarded.tape));
        Self {
            tape: guarded.tape,
            vanishing,
            roots_at_sides,
            gaps: contacts.len() - closed.contacts().count(),
            guards,
            is_free,
            moves_gap,
            impacts: at_contacts.impacts,
            sequences: at_contacts.sequences,
            locals: at_contacts.locals,
            captures: at_contacts.captures,
            residuals,
            residual_gradients,
            resets,
            asked_at_impacts: limits.impacts.clone(),
            asked_at_resets: limits.resets.clone(),
            asked: limits.asked.iter().map(|&(corner, _)| corner).collect(),
            asked_values,
            standings,
            field: at_point,
            looked_up: LookedUp::default(),
        }
    }

    pub(crate) fn constants<R: Real>(
        &self,
        graph: &Graph,
        parameters: &[R],
    ) -> ProgramConstants<R> {
        let of = |tape: &Tape| tape.constants(graph, parameters);
        ProgramConstants {
            edition: next_edition(),
            tape: of(&self.tape),
            impacts: self
                .impacts
                .iter()
                .map(|impact| impact.as_ref().map_or_else(Vec::new, |i| of(&i.tape)))
                .collect(),
            sequences: (self.sequences.iter())
                .map(|sequence| match sequence {
                    Some(tapes) => tapes.constants(graph, parameters),
                    None => SequenceConstants::none(),
                })
                .collect(),
            locals: self.locals.iter().map(of).collect(),
            captures: self.captures.iter().map(of).collect(),
            residuals: of(&self.residuals),
            residual_gradients: of(&self.residual_gradients),
            resets: (self.resets.iter())
                .map(|reset| match reset {
                    Some(reset) => [&reset.after, &reset.crossing, &reset.surface].map(of),
                    None => Default::default(),
                })
                .collect(),
            standings: (self.standings.iter())
                .map(|standing| standing.all().map(of))
                .collect(),
            field: of(&self.field),
            asked_values: of(&self.asked_values),
        }
    }

    /// Takes note of the constants that depend on a parameter from this number on.
    pub(crate) fn look_up_from(&mut self, graph: &Graph, first_slot: usize) {
        self.looked_up = LookedUp::new(graph, self.tapes(), first_slot);
    }

    /// Computes the constants that change at knots anew.
    pub(crate) fn renew<R: Real>(
        &self,
        graph: &Graph,
        parameters: &[R],
        constants: &mut ProgramConstants<R>,
    ) {
        constants.edition = next_edition();
        let parts = constants.of_tapes(self);
        self.looked_up.renew(graph, parameters, parts);
    }

    /// Every tape, for sizing scratch space; in the order of [`ProgramConstants::of_tapes`].
    pub(crate) fn tapes(&self) -> impl Iterator<Item = &Tape> {
        [
            &self.tape,
            &self.residuals,
            &self.residual_gradients,
            &self.field,
            &self.asked_values,
        ]
        .into_iter()
        .chain(self.standings.iter().flat_map(StandingTapes::all))
        .chain((self.resets.iter().flatten()).flat_map(|r| [&r.after, &r.crossing, &r.surface]))
        .chain(&self.locals)
        .chain(&self.captures)
        .chain(self.impacts.iter().flatten().map(|impact| &impact.tape))
        .chain(
            self.sequences
                .iter()
                .flatten()
                .flat_map(SequenceTapes::tapes),
        )
    }
}

impl<R> ProgramConstants<R> {
    /// The constants of each tape of their program, in order.
    fn of_tapes<'a>(
        &'a mut self,
        program: &'a Program,
    ) -> impl Iterator<Item = &'a mut Vec<R>> + 'a {
        let resets = self.resets.iter_mut().zip(&program.resets);
        let impacts = self.impacts.iter_mut().zip(&program.impacts);
        let sequences = self.sequences.iter_mut().zip(&program.sequences);
        [
            &mut self.tape,
            &mut self.residuals,
            &mut self.residual_gradients,
            &mut self.field,
            &mut self.asked_values,
        ]
        .into_iter()
        .chain(self.standings.iter_mut().flatten())
        .chain(
            resets
                .filter(|(_, tapes)| tapes.is_some())
                .flat_map(|(own, _)| own),
        )
        .chain(&mut self.locals)
        .chain(&mut self.captures)
        .chain(
            impacts
                .filter(|(_, tape)| tape.is_some())
                .map(|(own, _)| own),
        )
        .chain(
            sequences
                .filter(|(_, tapes)| tapes.is_some())
                .flat_map(|(own, _)| own.of_tapes()),
        )
    }
}

/// Surfaces that are slid along, and rates of sliding of contacts that stick; several contacts may stick by one rate.
fn held_beside_contacts(mechanics: &Mechanics, carrying: Closed) -> Vec<Expr> {
    let slides = mechanics.slides.iter();
    let sticks = mechanics.sticks.iter();
    let all = (slides.flat_map(|slide| [Some(slide.surface), slide.rate]))
        .flatten()
        .chain(
            sticks
                .filter(|stick| carrying.contains(stick.contact))
                .map(|stick| stick.rate),
        );
    let mut held = Vec::new();
    for function in all {
        if !held.contains(&function) {
            held.push(function);
        }
    }
    held
}
