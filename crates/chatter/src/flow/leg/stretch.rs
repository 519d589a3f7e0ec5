//! Stretches of the flow with whatever happens on them.

use super::edge::{Edge, Known, Landing};
use super::equations::Ending;
use super::{LegKind, MOST_STEPS};
use crate::expressions::{Expansion, Expr, Side, Sides, Symbol};
use crate::flow::error::FlowError;
use crate::flow::modes::guard::GuardKind;
use crate::flow::step::Workspace;
use crate::flow::system::{Settings, System};
use crate::flow::trajectory::Trajectory;
use crate::flow::variation::{columns, with_identity};
use crate::flow::{Closed, Grip, Occurrence};
use crate::model::Model;
use crate::numerics::linear::solve_consistent;
use crate::numerics::{Real, dot, two_sum};
use serde::{Deserialize, Serialize};

/// A stretch of the flow with whatever happens on it, from a state up to an event: for what has no fixed number of events, such
/// as complete chatter.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    system: System,
    edge: Edge,
    /// The guard that ends it, and how many chatter sequences come to their end before.
    ends_at: Option<GuardKind>,
    accumulations: usize,
    passes: Option<usize>,
    joint: bool,
    /// What is closed, and on which sides it is, where it ends.
    ends_in: (Grip, Sides),
    /// Contacts that are closed where it starts, those that the state lies on besides, and the gaps of all these.
    closed: Closed,
    on: Closed,
    gaps: Vec<Expr>,
    time: Option<usize>,
}

/// What a stretch starts from and ends at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StretchKind {
    /// Contacts that are closed at the start.
    pub closed: Closed,
    /// Contacts that were struck or held just before, and that are open.
    pub on: Closed,
    /// Chatter sequences that end on the way.
    pub accumulations: usize,
    /// Impacts on the way, where none do.
    pub impacts: usize,
    /// The mode that it ends in, and how.
    pub last: LegKind,
    /// How often what ends it comes on the way, if that is known: once more before chatter is complete, and it is another motion. Impacts, of
    /// which chatter has no fixed number, are not counted.
    #[serde(default)]
    pub passes: Option<usize>,
    /// Whether the chatter is one of several contacts, and so is over where all of them rest, however often some of them do on the way.
    #[serde(default)]
    pub joint: bool,
}

impl StretchKind {
    /// The same up to another event, however often that comes on the way.
    pub(crate) fn up_to(self, last: LegKind) -> Self {
        Self {
            last,
            passes: None,
            ..self
        }
    }
}

impl System {
    /// Compiles a stretch; `self` carries no columns.
    pub(crate) fn stretch(&self, kind: StretchKind, free: &[usize]) -> Option<Stretch> {
        let Ending {
            mut graph,
            field,
            surface,
            map,
            ..
        } = self.ending(kind.last)?;
        let coordinates = field.len();
        let columns = columns(coordinates, free);
        let (grip, sides, _) = self.origin_of(kind.last.mode)?;
        Some(Stretch {
            ends_in: (grip, sides),
            system: System::with_columns(self.model(), &columns).ok()?,
            edge: Edge::new(self.model(), &mut graph, (&field, surface, &map), free),
            ends_at: kind.last.ends_at,
            accumulations: kind.accumulations,
            passes: kind.passes,
            joint: kind.joint,
            closed: kind.closed,
            on: kind.on,
            gaps: Closed(kind.closed.0 | kind.on.0)
                .contacts()
                .map(|contact| self.model().contacts[contact].gap)
                .collect(),
            time: self.model().time,
        })
    }
}

/// Scratch space of a stretch.
#[derive(Clone, Debug)]
pub(crate) struct Follower<R: Real> {
    work: Workspace<R>,
    expansion: Expansion<R>,
    at_edge: Known<R>,
}

/// Why a stretch has no end like the one it was compiled for.
#[derive(Clone, Debug)]
pub(crate) enum Astray {
    /// Something else ended it.
    Otherwise,
    /// It came to no end, and crossed a surface: chatter whose flights do so elsewhere than at their tops is followed impact by impact with derivatives.
    Crosses,
    /// It cannot be followed.
    Failed(FlowError),
}

impl From<FlowError> for Astray {
    fn from(error: FlowError) -> Self {
        Self::Failed(error)
    }
}

/// The knot that a stretch begins at is passed in this part of its longest time, if it is not behind already.
const AT_START: f64 = 1e-6;

/// A stretch has no more events than this.
const MOST_EVENTS: usize = 20_000;

impl Stretch {
    pub(crate) fn follower<R: Real>(&self, settings: &Settings) -> Follower<R> {
        Follower {
            work: self.system.workspace(settings),
            expansion: Expansion::new(&[&self.edge.tape]),
            at_edge: Known::new(),
        }
    }

    /// Follows the flow from a state until the stretch ends, at the latest after `longest`; for so long where a time says
    /// the end. Where what comes before it ends at a knot, that guard is told: the state may lie short of it by rounding, or by what the
    /// solution of the orbit's equations has yet to close.
    pub(crate) fn follow<R: Real>(
        &self,
        follower: &mut Follower<R>,
        parameters: &[R],
        (x, after): (&[R], Option<GuardKind>),
        longest: R,
    ) -> Result<Landing<R>, Astray> {
        let system = &self.system;
        let all = parameters;
        // A trajectory finds the pieces of lookups by itself.
        let parameters = &all[..system.model().parameters.len()];
        let x = self.onto_contact(parameters, x);
        let start = with_identity(&x, self.edge.columns);
        let clock = self.time.map_or(R::ZERO, |index| x[index]);
        let work = &mut follower.work;
        let on = (&*start, Closed(self.closed.0 | self.on.0));
        let mut trajectory = Trajectory::start_on(system, work, parameters, clock, on)?;
        if self.closed != Closed::NONE {
            // Started anywhere, to have the parameters; now with these contacts closed.
            trajectory.restart_beside(system, work, self.closed, clock, &start)?;
            for contact in self.on.contacts() {
                trajectory.leave(system, GuardKind::Gap(contact));
            }
        }
        trajectory.set_horizon_parts(two_sum(clock, longest));
        let (mut accumulations, mut passes) = (0, 0);
        let mut astray = Astray::Otherwise;
        let mut hit: Option<R> = None;
        // When a corner has ended the way to it, and where.
        let mut corner: Option<(R, Vec<R>)> = None;
        for _ in 0..MOST_EVENTS {
            let mut told = None;
            let mut pieces = trajectory.pieces().to_vec();
            let mut mode = trajectory.mode;
            for _ in 0..MOST_STEPS {
                mode = trajectory.mode;
                pieces.clear();
                pieces.extend_from_slice(trajectory.pieces());
                let next = trajectory.advance_to_horizon(system, work);
                // At a border a flight may come to nothing whose way back takes for ever: no derivative is left.
                let columns = &trajectory.state()[x.len()..];
                if next.is_err() && columns.iter().any(|x| !x.is_finite()) {
                    return Err(astray);
                }
                told = next?;
                if told.is_some() || trajectory.ended_by().is_some() {
                    break;
                }
            }
            match told {
                Some(Occurrence::Horizon) => {
                    let is_over = match self.joint {
                        true => self.rests_in(trajectory.mode),
                        false => accumulations == self.accumulations,
                    };
                    if self.ends_at.is_some() || !is_over {
                        return Err(astray);
                    }
                    let end = trajectory.state();
                    return Ok((self.edge).landing(
                        (&mut follower.expansion, &mut follower.at_edge),
                        all,
                        longest,
                        end,
                    ));
                }
                Some(Occurrence::Accumulation { .. } | Occurrence::Cascade { .. }) => {
                    accumulations += 1
                }
                Some(Occurrence::Impact { .. }) => hit = Some(trajectory.time()),
                // Friction turns with the gap rate, at tops and at impacts.
                Some(Occurrence::Switch { .. })
                    if accumulations < self.accumulations
                        && hit.is_some_and(|hit| hit != trajectory.time())
                        && !trajectory.is_past_top() =>
                {
                    astray = Astray::Crosses;
                }
                _ => {}
            }
            // Sliding that turns in flight is nothing that happens.
            let by = trajectory.ended_by();
            let by = by.filter(|&guard| !system.is_idle(mode, guard));
            let now = trajectory.time();
            let at_start = (now - clock).to_f64() <= AT_START * longest.to_f64();
            if at_start && passes == 0 && by.is_some() && by == after.filter(is_knot) {
                continue;
            }
            if by.is_some() {
                let dense = work.dense();
                let end = || (0..start.len()).map(|i| dense.state(i, R::ONE)).collect();
                let other = by.filter(|by| is_corner(by) && self.ends_at != Some(*by));
                corner = other.map(|_| (now, end()));
            }
            let at_corner = corner.as_ref().filter(|(time, _)| *time == now);
            let comes_too = at_corner.is_some()
                && match (self.ends_at, told) {
                    (Some(GuardKind::Switch(own)), Some(Occurrence::Switch { surface, .. })) => {
                        own == surface
                    }
                    (Some(GuardKind::Piece(lookup, side)), _) => {
                        by.is_some() && ends_piece((&pieces, trajectory.pieces()), lookup, side)
                    }
                    _ => false,
                };
            // Of corners of one instant any may be the one that ends the way to it.
            if !comes_too && (by.is_none() || by != self.ends_at) {
                continue;
            }
            // Chatter that is rounding may not be there in longer numbers: what rests where it ends is at its end.
            let is_last = match self.passes {
                Some(wanted) if self.joint => passes == wanted && self.rests_in(mode),
                None if self.joint => self.rests_in(mode),
                Some(wanted) if accumulations < self.accumulations => {
                    passes == wanted && self.rests_in(mode)
                }
                Some(wanted) => passes >= wanted,
                None => accumulations >= self.accumulations,
            };
            if is_last {
                let dense = work.dense();
                let end: Vec<R> = match at_corner {
                    Some((_, end)) => end.clone(),
                    None => (0..start.len()).map(|i| dense.state(i, R::ONE)).collect(),
                };
                return Ok((self.edge).landing(
                    (&mut follower.expansion, &mut follower.at_edge),
                    all,
                    now - clock,
                    &end,
                ));
            }
            passes += 1;
            if self.passes.is_some_and(|wanted| passes > wanted) {
                return Err(astray);
            }
        }
        Err(astray)
    }

    /// Whether this is the mode that it ends in.
    fn rests_in(&self, mode: usize) -> bool {
        let origin = self.system.origin_of(mode);
        origin.is_some_and(|(grip, sides, _)| (grip, sides) == self.ends_in)
    }

    /// Takes a state that impacts have just left, or that contacts hold, to where their gaps are zero: off it by what the solution
    /// of the orbit's equations has yet to close.
    pub(crate) fn onto_contact<R: Real>(&self, parameters: &[R], x: &[R]) -> Vec<R> {
        let mut x = x.to_vec();
        let gaps = (&*self.gaps, CORRECTIONS);
        onto_gaps(self.system.model(), gaps, parameters, &mut x);
        x
    }
}

/// Whether it is a corner that ends a step.
pub(crate) fn is_corner(guard: &GuardKind) -> bool {
    matches!(guard, GuardKind::Switch(_) | GuardKind::Piece(..))
}

/// Whether a knot of a lookup ends a step.
fn is_knot(guard: &GuardKind) -> bool {
    matches!(guard, GuardKind::Piece(..))
}

/// Whether a lookup has come to the end of a piece, to this side, between these two.
pub(crate) fn ends_piece((before, after): (&[i64], &[i64]), lookup: usize, side: Side) -> bool {
    let by = match side {
        Side::Above => 1,
        Side::Below => -1,
        Side::Sliding => return false,
    };
    let pieces = before.get(lookup).zip(after.get(lookup));
    pieces.is_some_and(|(before, after)| after - before == by)
}

/// A gap that is nearly zero is after so many.
const CORRECTIONS: usize = 3;

/// Takes a state to where gaps are zero at the same time, by the least displacement: by so many steps of Newton's method.
pub(crate) fn onto_gaps<R: Real>(
    model: &Model,
    (gaps, steps): (&[Expr], usize),
    parameters: &[R],
    x: &mut [R],
) {
    let graph = &mut model.graph.clone();
    let slopes: Vec<Vec<Expr>> = (gaps.iter())
        .map(|&gap| {
            (0..model.states.len())
                .map(|i| graph.derivative(gap, Symbol::State(i)))
                .collect()
        })
        .collect();
    for _ in 0..steps {
        let values: Vec<R> = (gaps.iter())
            .map(|&gap| graph.evaluate(gap, x, parameters))
            .collect();
        let slope = |(i, &slope): (usize, &Expr)| match model.time {
            Some(time) if time == i => R::ZERO,
            _ => graph.evaluate(slope, x, parameters),
        };
        let gradients: Vec<Vec<R>> = (slopes.iter())
            .map(|of_gap| of_gap.iter().enumerate().map(slope).collect())
            .collect();
        let squares: Vec<Vec<R>> = (gradients.iter())
            .map(|a| gradients.iter().map(|b| dot(a, b)).collect())
            .collect();
        if values.iter().all(|value| *value == R::ZERO) {
            break;
        }
        let Some(parts) = solve_consistent(&squares, &values) else {
            break;
        };
        for (gradient, &part) in gradients.iter().zip(&parts) {
            for (x, &slope) in x.iter_mut().zip(gradient) {
                *x -= part * slope;
            }
        }
    }
}
