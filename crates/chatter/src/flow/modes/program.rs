//! What runs in one mode: the field that holds while a given set of contacts is closed, and its guards.

use super::closed::Closed;
use super::equations::{ModeExprs, guard_functions, kept_by_contacts};
use super::guard::{Guard, GuardKind, Transition};
use super::limits::{Corner, Limits};
use super::looked_up::LookedUp;
use super::standing::{STANDING_ORDERS, STANDING_TAPES, StandingTapes};
use crate::expressions::{Asked, Expr, Graph, Names, Node, Operand, Symbol, Tape};
use crate::flow::chatter::{SequenceConstants, SequenceTapes};
use crate::flow::reset::ResetTapes;
use crate::flow::variation::Direction as Along;
use crate::model::{Mechanics, Section};
use crate::numerics::Real;
use crate::numerics::roots::Crossing;
use core::sync::atomic::{AtomicU64, Ordering};

/// What an impact at one contact does, as a tape of order zero on the state before it.
#[derive(Clone, Debug)]
pub struct ImpactTape {
    pub(crate) tape: Tape,
    /// Components that change; their new values are the outputs after the scalars.
    pub(crate) changed: Vec<usize>,
}

/// A formula longer than this is no help in a message.
const LONGEST_NAMED: usize = 200;

/// Outputs of an impact tape before the changed components: rate before and after, acceleration and jerk after, the
/// restitution here and that of an impact of vanishing rate.
pub(crate) const IMPACT_SCALARS: usize = 6;

/// Gap, rate, acceleration and jerk of a contact at a state, in a program's field.
pub(crate) const LOCAL_SCALARS: usize = 4;

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
        let graph = &mut mechanics.graph;
        let listed = guard_functions(graph, &contacts, (sections, limits), mode);
        // A motion that is held on a section crosses it where it leaves, if to the other side: what rounding leaves beside it says nothing.
        let is_look = |&(kind, ..): &(GuardKind, Crossing, Expr)| match kind {
            GuardKind::Section(section) => sections[section].reset.is_none(),
            _ => false,
        };
        let looks: Vec<usize> = (0..listed.len()).filter(|&k| is_look(&listed[k])).collect();
        let surfaces: Vec<Expr> = looks.iter().map(|&guard| listed[guard].2).collect();
        let closed_contacts: Vec<usize> = closed.contacts().collect();
        let mut rests = mechanics
            .held_at_zero(&closed_contacts, &surfaces)
            .into_iter();
        let mut held: Vec<usize> = { looks }
            .into_iter()
            .filter(|_| rests.next() == Some(true))
            .collect();
        let graph = &mut mechanics.graph;
        let functions: Vec<Expr> = listed.iter().map(|&(.., function)| function).collect();
        let positive: Vec<Expr> = (listed.iter())
            .filter(|(kind, ..)| matches!(kind, GuardKind::Switch(_)))
            .map(|&(.., function)| function)
            .collect();
        // Roots of multiples of what ends a side vanish where it ends.
        let rewritten = graph.with_powers_of(&[&field[..], &functions[..]].concat(), &positive);
        let (rates, functions) = rewritten.split_at(dimension);
        let mut tape = Tape::new(graph, dimension, rates, functions);
        // Roots say where motion has a series: what they are taken of stays a guard.
        let mut kept = kept_by_contacts(graph, &contacts, closed, &listed);
        kept.retain(|&(guard, _)| !tape.takes_root_of(tape.outputs[guard]));
        let mut functions = functions.to_vec();
        held.retain(|guard| kept.iter().all(|(other, _)| other != guard));
        if !kept.is_empty() || !held.is_empty() {
            for &(guard, sign) in &kept {
                functions[guard] = sign;
            }
            for &guard in &held {
                functions[guard] = graph.number(0.0);
            }
            tape = Tape::new(graph, dimension, rates, &functions);
        }
        for (guard, (kind, ..)) in listed.iter().enumerate() {
            // What is constant here may be another constant beyond a corner; and which sign a parameter has is asked as of all else.
            let is_asked = matches!(kind, GuardKind::Section(_)) && !held.contains(&guard);
            if is_asked || kept.iter().any(|&(k, _)| k == guard) {
                tape.as_series(guard);
            }
        }
        let vanishing = (tape.singular.iter())
            .map(|singular| {
                let text = singular.expr.map(|expr| graph.to_text(expr, names));
                text.filter(|text| text.len() <= LONGEST_NAMED)
                    .unwrap_or_default()
            })
            .collect();
        let mut impacts = Vec::new();
        let mut sequences = Vec::new();
        let mut locals = Vec::new();
        let mut captures = Vec::new();
        // Contacts whose impulse leaves the rates of all closed ones as they are.
        let mut alone = Closed::NONE;
        for (index, contact) in contacts.iter().enumerate() {
            let rate = graph.lie_derivative(contact.gap, field);
            let acceleration = graph.lie_derivative(rate, field);
            let jerk = graph.lie_derivative(acceleration, field);
            locals.push(Tape::new(
                graph,
                dimension,
                &[],
                &[contact.gap, rate, acceleration, jerk],
            ));
            let onto_surface = surface_correction(graph, contact.gap, dimension, time);
            let at_rest: Vec<Expr> = (mode.rests[index].iter().zip(&onto_surface))
                .map(|(&rest, &correction)| graph.add(rest, correction))
                .collect();
            captures.push(Tape::new(graph, dimension, &[], &at_rest));
            if closed.contains(index) {
                impacts.push(None);
                sequences.push(None);
                continue;
            }
            let sequence = SequenceTapes::new(graph, dimension, &mode.sequences[index]);
            sequences.push(Some(sequence));
            let after = &mode.impacts[index];
            let at_after = |graph: &mut Graph, expr| {
                graph.substitute(expr, &|symbol| match symbol {
                    Symbol::State(i) => Some(after[i]),
                    Symbol::Parameter(_) => None,
                })
            };
            let rate_after = at_after(graph, rate);
            let acceleration_after = at_after(graph, acceleration);
            let jerk_after = at_after(graph, jerk);
            let restitution_at_rest =
                graph.substitute(contact.restitution, &|symbol| match symbol {
                    Symbol::State(i) => Some(at_rest[i]),
                    Symbol::Parameter(_) => None,
                });
            let mut outputs = vec![
                contact.rate,
                rate_after,
                acceleration_after,
                jerk_after,
                contact.restitution,
                restitution_at_rest,
            ];
            let mut changed = Vec::new();
            for i in 0..dimension {
                let value = graph.add(after[i], onto_surface[i]);
                if value != graph.state(i) {
                    changed.push(i);
                    outputs.push(value);
                }
            }
            // Where an impact may change the side of a surface, or jump across that of an event, columns of derivatives go by
            // the event.
            let has_columns = dimension > coordinates;
            let corners = limits.corners.iter();
            let held =
                corners.flat_map(|limit| [Some(limit.surface), limit.rate.map(|[rate, ..]| rate)]);
            let keeps_sides = held.flatten().all(|held| {
                let change = graph.lie_derivative(held, &contact.jump);
                graph
                    .as_number(change)
                    .is_some_and(|value| value.high() == 0.0)
            });
            let mut resets = sections.iter().filter(|section| section.reset.is_some());
            let keeps_sides = keeps_sides
                && resets.all(|section| at_after(graph, section.surface) == section.surface);
            let is_alone = (keeps_sides || !has_columns)
                && closed.contacts().all(|other| {
                    let change = graph.lie_derivative(contacts[other].rate, &contact.jump);
                    graph
                        .as_number(change)
                        .is_some_and(|value| value.high() == 0.0)
                });
            if is_alone {
                alone = alone.with(index);
            }
            impacts.push(Some(ImpactTape {
                tape: Tape::new(graph, dimension, &[], &outputs),
                changed,
            }));
        }
        let guards: Vec<Guard> = (listed.into_iter().zip(&tape.outputs))
            .map(|((kind, crossing, function), &series)| Guard {
                kind,
                transition: Transition::new(
                    kind,
                    *grip,
                    (
                        |contact| alone.contains(contact),
                        |contact| !limits.impacts[contact].is_empty(),
                    ),
                    |section| sections[section].reset.is_some(),
                ),
                crossing,
                series,
                is_affine: is_affine(graph, function, dimension),
                side: if positive.contains(&function) {
                    1.0
                } else if positive.contains(&graph.neg(function)) {
                    -1.0
                } else {
                    0.0
                },
                is_expanded: match kind {
                    GuardKind::Gap(_) => !is_state(graph, function),
                    _ => !is_affine(graph, function, dimension),
                },
            })
            .collect();
        let mut residuals: Vec<Expr> = (carrying.contacts())
            .flat_map(|contact| [contacts[contact].gap, contacts[contact].rate])
            .collect();
        let sticks = mechanics.sticks.iter();
        let slides = mechanics.slides.iter();
        let all: Vec<Expr> = (slides.flat_map(|slide| [Some(slide.surface), slide.rate]))
            .flatten()
            .chain(
                sticks
                    .filter(|stick| carrying.contains(stick.contact))
                    .map(|stick| stick.rate),
            )
            .collect();
        // Several contacts may stick by one rate.
        let mut held: Vec<Expr> = Vec::with_capacity(all.len());
        for function in all {
            if !held.contains(&function) {
                held.push(function);
            }
        }
        residuals.extend(&held);
        let moving = contacts.iter().enumerate().filter(|(_, c)| c.moves_gap);
        let moves_gap = moving.fold(Closed::NONE, |all, (contact, _)| all.with(contact));
        let is_free = closed == Closed::NONE && residuals.is_empty() && moves_gap == Closed::NONE;
        let mut gradients = Vec::new();
        // What contacts alone hold goes back along their impulses.
        for &held in residuals.iter().filter(|_| !held.is_empty()) {
            gradients.extend((0..coordinates).map(|i| {
                if Some(i) == time {
                    graph.number(0.0)
                } else {
                    graph.derivative(held, Symbol::State(i))
                }
            }));
        }
        let residuals = Tape::new(graph, dimension, &[], &residuals);
        let residual_gradients = Tape::new(graph, dimension, &[], &gradients);
        let resets = (sections.iter())
            .map(|section| ResetTapes::new(graph, section, field, directions, coordinates))
            .collect();
        let standings = (limits.corners.iter())
            .map(|limit| {
                let mut outputs = vec![limit.surface];
                for &(_, guard) in &limit.guards {
                    let mut value = guard;
                    for _ in 0..STANDING_ORDERS {
                        outputs.push(value);
                        value = if limit.is_kept {
                            graph.number(0.0)
                        } else {
                            graph.lie_derivative(value, field)
                        };
                    }
                }
                outputs.extend(limit.rate.into_iter().flatten());
                let slopes: Vec<Expr> = (directions.iter())
                    .flat_map(|along| along.along(graph, coordinates, &[limit.surface]))
                    .collect();
                let lifts: Vec<Expr> = (contacts.iter())
                    .map(|contact| graph.lie_derivative(limit.surface, &contact.jump))
                    .collect();
                let components = (limit.vector.iter())
                    .flat_map(|v| v.components.clone())
                    .collect::<Vec<_>>();
                let mut holding = Vec::new();
                if let Some(vector) = &limit.vector {
                    holding.extend(&vector.shares);
                    for &share in &vector.shares {
                        holding.push(graph.lie_derivative(share, field));
                    }
                    holding.extend(&vector.changes);
                    holding.extend(vector.directions.iter().flatten());
                }
                StandingTapes {
                    corner: limit.corner,
                    values: Tape::new(graph, dimension, &[], &outputs),
                    guards: limit.guards.iter().map(|&(kind, _)| kind).collect(),
                    is_kept: limit.is_kept,
                    slopes: Tape::new(graph, dimension, &[], &slopes),
                    lifts: Tape::new(graph, dimension, &[], &lifts),
                    components: Tape::new(graph, dimension, &[], &components),
                    holding: Tape::new(graph, dimension, &[], &holding),
                }
            })
            .collect();
        let asked: Vec<Expr> = (limits.asked.iter())
            .flat_map(|&(_, value)| [value, graph.lie_derivative(value, field)])
            .collect();
        let asked_values = Tape::new(graph, dimension, &[], &asked);
        let at_point = Tape::new(graph, dimension, &[], &field[..mechanics.field.len()]);
        let roots_at_sides = guards.iter().any(|guard| guard.ends_a_root(&tape));
        Self {
            tape,
            vanishing,
            roots_at_sides,
            gaps: contacts.len() - closed.contacts().count(),
            guards,
            is_free,
            moves_gap,
            impacts,
            sequences,
            locals,
            captures,
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

fn is_state(graph: &Graph, function: Expr) -> bool {
    matches!(graph.node(function), Node::Symbol(Symbol::State(_)))
}

/// Whether a function is a combination of states with coefficients that no state changes: resolved wherever they are.
fn is_affine(graph: &mut Graph, function: Expr, dimension: usize) -> bool {
    let states: Vec<Symbol> = (0..dimension).map(Symbol::State).collect();
    let slopes = graph.gradient(function, &states);
    let mut parts = graph.reachable(&slopes).into_iter();
    parts.all(|part| !is_state(graph, part))
}

/// What to add to a state within rounding of the contact surface so that it lies on it: otherwise the gap would drift
/// by a rounding error an impact.
///
/// Along one coordinate where the gap is linear in it (positions, in mechanics), else along the gradient; never in time.
fn surface_correction(
    graph: &mut Graph,
    gap: Expr,
    dimension: usize,
    time: Option<usize>,
) -> Vec<Expr> {
    let gradient: Vec<Expr> = (0..dimension)
        .map(|i| graph.derivative(gap, Symbol::State(i)))
        .collect();
    let mut correction = vec![graph.number(0.0); dimension];
    let linear = gradient.iter().position(|&slope| {
        graph
            .as_number(slope)
            .is_some_and(|value| value.high() != 0.0)
    });
    if let Some(i) = linear.filter(|&i| Some(i) != time) {
        let ratio = graph.div(gap, gradient[i]);
        correction[i] = graph.neg(ratio);
        return correction;
    }
    let spatial: Vec<usize> = (0..dimension).filter(|&i| Some(i) != time).collect();
    let two = graph.number(2.0);
    let squares: Vec<Expr> = spatial
        .iter()
        .map(|&i| graph.power(gradient[i], two))
        .collect();
    let norm = graph.sum(&squares);
    for i in spatial {
        let along = graph.mul(gap, gradient[i]);
        let share = graph.div(along, norm);
        correction[i] = graph.neg(share);
    }
    correction
}
