//! The smooth flow of one mode by itself, up to a time and past whatever would end it there, with its derivatives.
//!
//! A leg of a periodic orbit flies for a given time tau from a state x, be it through a wall; that it ends on the surface g = 0 of
//! its event is an equation of whoever solves for the orbit, not a decision of the flow. So it stays regular where the
//! event grazes (docs/periodic.md):
//!
//! ```text
//! e = phi_tau(x, p)      g(e, p) = 0      image R(e, p): the state after the event
//! ```
//!
//! What else ends the mode is watched apart: the least value of each of its guards on the way.

mod edge;
mod equations;
mod stretch;
mod watch;

use super::Occurrence;
use super::error::FlowError;
use super::modes::guard::GuardKind;
use super::step::Workspace;
use super::system::{Settings, System};
use super::trajectory::Trajectory;
use super::variation::{columns, with_identity};
use crate::expressions::{Expansion, Expr, Graph, Tape};
use crate::numerics::{Real, two_sum};
use edge::{Edge, Known};
use equations::{Ending, at, bare, onto_what_holds};
use serde::{Deserialize, Serialize};
use watch::Watch;

pub(crate) use edge::Landing;
pub(crate) use equations::Due;
pub(crate) use stretch::{
    Astray, Follower, Stretch, StretchKind, ends_piece, is_corner, onto_gaps,
};
pub(crate) use watch::Least;

/// What the event at the end of a leg does to the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) enum Jump {
    /// Nothing.
    None,
    /// An impact at this contact.
    Impact(usize),
    /// An impact at this contact whose friction stops the sliding.
    Stop(usize),
    /// The event of this section.
    Reset(usize),
}

impl Jump {
    /// The contact that is hit.
    pub(crate) fn impact(self) -> Option<usize> {
        match self {
            Self::Impact(contact) | Self::Stop(contact) => Some(contact),
            Self::None | Self::Reset(_) => None,
        }
    }
}

/// A mode, what ends it, and what happens there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) struct LegKind {
    /// Number of the mode in the system.
    pub mode: usize,
    /// The guard that vanishes at the end; none where a time says the end.
    pub ends_at: Option<GuardKind>,
    pub jump: Jump,
}

/// A leg compiled for derivatives by the state it starts from, and by some parameters.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    pub(super) kind: LegKind,
    flow: System,
    edge: Edge,
    watch: Watch,
    /// Guards that its event leaves as they are.
    keeps: Vec<GuardKind>,
    /// Guards that its field leaves as they are.
    still: Vec<GuardKind>,
    /// The field at a point.
    field: Tape,
    graph: Graph,
    time: Option<usize>,
}

impl System {
    /// Compiles a leg on which crossings of a section are told, too; `self` carries no columns. None where the mode holds no
    /// motion.
    pub(crate) fn leg(&self, kind: LegKind, free: &[usize], section: Option<usize>) -> Option<Leg> {
        let Ending {
            mut graph,
            field,
            guards,
            surface,
            map,
            held,
            asked,
        } = self.ending(kind)?;
        let graph = &mut graph;
        let coordinates = field.len();
        let stays =
            |graph: &mut Graph, of: Expr| graph.substitute(of, &|symbol| at(&map, symbol)) == of;
        let mut keeps: Vec<GuardKind> = (guards.iter())
            .filter(|&&(_, of)| stays(graph, of))
            .map(|&(guard, _)| guard)
            .collect();
        if let (Some(guard), Some(surface)) = (kind.ends_at, surface)
            && !keeps.contains(&guard)
            && stays(graph, surface)
        {
            keeps.push(guard);
        }
        let zero = graph.number(0.0);
        let still = (guards.iter())
            .filter(|&&(_, of)| graph.lie_derivative(of, &field) == zero)
            .map(|&(guard, _)| guard)
            .collect();
        let map = onto_what_holds(graph, &held, &map, self.model().time);
        let columns = columns(coordinates, free);
        let section = section.filter(|&section| kind.ends_at != Some(GuardKind::Section(section)));
        let watch = Watch::new(self, graph, &field, [guards, asked], section);
        let edge = Edge::new(self.model(), graph, (&field, surface, &map), free);
        let smooth = bare(self.model(), graph, &field, Vec::new());
        let flow = System::with_columns(&smooth, &columns).ok()?.past_roots();
        Some(Leg {
            kind,
            flow,
            edge,
            watch,
            keeps,
            still,
            field: Tape::new(graph, coordinates, &[], &field),
            graph: graph.clone(),
            time: self.model().time,
        })
    }
}

/// A trajectory and the parameters that it is at.
type Placed<R> = Option<(Vec<R>, Trajectory<R>)>;

/// Scratch space of a leg, and where it was flown last.
#[derive(Clone, Debug)]
pub(crate) struct Flyer<R: Real> {
    work: Workspace<R>,
    watching: Option<Workspace<R>>,
    expansion: Expansion<R>,
    at_edge: Known<R>,
    at_watch: Known<R>,
    at_watch_start: Known<R>,
    /// At these parameters.
    trajectory: Placed<R>,
    watcher: Placed<R>,
}

/// Steps without an end: the leg grows beyond all bounds.
const MOST_STEPS: usize = 100_000;

impl Leg {
    pub(crate) fn flyer<R: Real>(&self, settings: &Settings) -> Flyer<R> {
        Flyer {
            work: self.flow.workspace(settings),
            watching: (self.watch.system.as_ref()).map(|system| system.workspace(settings)),
            expansion: Expansion::new(&[
                &self.edge.tape,
                &self.field,
                &self.watch.values,
                &self.watch.rates,
            ]),
            at_edge: Known::new(),
            at_watch: Known::new(),
            at_watch_start: Known::new(),
            trajectory: None,
            watcher: None,
        }
    }

    /// Whether its event leaves the function of a guard as it is, and so the state on its surface.
    pub(crate) fn keeps(&self, guard: GuardKind) -> bool {
        self.keeps.contains(&guard)
    }

    /// Whether there is a guard that its field leaves as it is.
    pub(crate) fn stands_on_any(&self) -> bool {
        !self.still.is_empty()
    }

    /// Whether a state on the surface of a guard stays on it all the way, be it held there or not.
    pub(crate) fn stays_on(&self, guard: GuardKind) -> bool {
        self.still.contains(&guard)
    }

    /// The field at a state.
    pub(crate) fn field<R: Real>(&self, flyer: &mut Flyer<R>, parameters: &[R], x: &[R]) -> Vec<R> {
        let constants = self.field.constants(&self.graph, parameters);
        let mut values = vec![R::ZERO; x.len()];
        let low = vec![R::ZERO; x.len()];
        (flyer.expansion).evaluate_past_roots(&self.field, &constants, (x, &low), &mut values);
        values
    }

    /// Flies for so long, past everything. `parameters` are the model's, then those of the pieces of lookups.
    ///
    /// # Errors
    /// The equations leave their domain.
    pub(crate) fn fly<R: Real>(
        &self,
        flyer: &mut Flyer<R>,
        parameters: &[R],
        x: &[R],
        duration: R,
    ) -> Result<Landing<R>, FlowError> {
        let start = with_identity(x, self.edge.columns);
        let clock = self.time.map_or(R::ZERO, |index| x[index]);
        let system = &self.flow;
        place(
            system,
            (&mut flyer.trajectory, &mut flyer.work),
            parameters,
            clock,
            &start,
        )?;
        let Some((_, trajectory)) = &mut flyer.trajectory else {
            return Err(left_domain(clock, x));
        };
        trajectory.set_horizon_parts(two_sum(clock, duration));
        for _ in 0..MOST_STEPS {
            if let Some(Occurrence::Horizon) =
                trajectory.advance_to_horizon(system, &mut flyer.work)?
            {
                let end = trajectory.state();
                if !end.iter().all(|x| x.is_finite()) {
                    break;
                }
                let edge = &self.edge;
                let scratch = (&mut flyer.expansion, &mut flyer.at_edge);
                return Ok(edge.landing(scratch, parameters, duration, end));
            }
        }
        Err(left_domain(clock, x))
    }

    /// The same for a time that is next to nothing, of either sign.
    ///
    /// # Errors
    /// The equations leave their domain.
    pub(crate) fn fly_a_moment<R: Real>(
        &self,
        flyer: &mut Flyer<R>,
        parameters: &[R],
        x: &[R],
        duration: R,
    ) -> Result<Landing<R>, FlowError> {
        let start = with_identity(x, self.edge.columns);
        let clock = self.time.map_or(R::ZERO, |index| x[index]);
        let system = &self.flow;
        let kept = (&mut flyer.trajectory, &mut flyer.work);
        place(system, kept, parameters, clock, &start)?;
        let Some((_, trajectory)) = &flyer.trajectory else {
            return Err(left_domain(clock, x));
        };
        let end = trajectory.a_moment_later(system, &mut flyer.work, duration)?;
        if !end.iter().all(|x| x.is_finite()) {
            return Err(left_domain(clock, x));
        }
        let scratch = (&mut flyer.expansion, &mut flyer.at_edge);
        Ok(self.edge.landing(scratch, parameters, duration, &end))
    }

    /// The event at its end without a flight before it: at the instant of another event, at a surface that is met already.
    pub(crate) fn at_once<R: Real>(
        &self,
        flyer: &mut Flyer<R>,
        parameters: &[R],
        x: &[R],
    ) -> Landing<R> {
        let end = with_identity(x, self.edge.columns);
        let scratch = (&mut flyer.expansion, &mut flyer.at_edge);
        let landing = self.edge.landing(scratch, parameters, R::ZERO, &end);
        // The columns are those of the event before, its time taken with them: this one has none of its own.
        Landing {
            image_rate: vec![R::ZERO; x.len()],
            ..landing
        }
    }
}

/// Puts a trajectory at a state, anew where the parameters have changed.
fn place<R: Real>(
    system: &System,
    (kept, work): (&mut Placed<R>, &mut Workspace<R>),
    parameters: &[R],
    clock: R,
    state: &[R],
) -> Result<(), FlowError> {
    match kept {
        Some((at, trajectory)) if at == parameters => {
            trajectory.restart(system, work, clock, state)
        }
        _ => {
            let trajectory = Trajectory::start(system, work, parameters, clock, state)?;
            *kept = Some((parameters.to_vec(), trajectory));
            Ok(())
        }
    }
}

fn left_domain<R: Real>(time: R, state: &[R]) -> FlowError {
    FlowError::LeftDomain {
        time: time.to_f64(),
        state: state.iter().map(|x| x.to_f64()).collect(),
    }
}
