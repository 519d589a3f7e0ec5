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

use super::error::FlowError;
use super::guard::GuardKind;
use super::limits::Limits;
use super::program::{ModeExprs, guard_functions};
use super::step::Workspace;
use super::system::{Settings, System};
use super::touch::stop;
use super::trajectory::Trajectory;
use super::variation::{Column, Direction as Along, with_identity};
use super::{Closed, Occurrence};
use crate::expressions::{Asked, Expansion, Expr, Graph, Side, Symbol, Tape};
use crate::model::{Direction, Model, Section};
use crate::numerics::linear::solve_consistent;
use crate::numerics::{Matrix, Real, dot, two_sum};
use serde::{Deserialize, Serialize};

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
    /// The field at a point.
    field: Tape,
    graph: Graph,
    time: Option<usize>,
}

/// The surface and map at the end of a leg, on a state followed by columns.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    graph: Graph,
    tape: Tape,
    coordinates: usize,
    columns: usize,
}

/// What must stay positive on the way.
#[derive(Clone, Debug)]
struct Watch {
    /// Stops where a guard's rate rises through zero, and at the section; none where nothing is watched.
    system: Option<System>,
    guards: Vec<GuardKind>,
    /// How many of them: the others are asked for at the end alone.
    on_the_way: usize,
    /// The section whose crossings are told, after the guards.
    section: Option<usize>,
    /// Guards that are events, whose functions may have either sign: after all others it is told where their rates fall through
    /// zero.
    events: Vec<Event>,
    graph: Graph,
    /// All guards, and their rates.
    values: Tape,
    rates: Tape,
}

/// An event among the guards.
#[derive(Clone, Copy, Debug)]
struct Event {
    guard: usize,
    /// Whether it comes about on the way up, too.
    either: bool,
}

impl Event {
    /// The side of its surface that a leg begins on.
    fn side(self, value: f64, rate: f64, duration: f64) -> f64 {
        let at_zero = value.abs() <= AT_ZERO * (rate * duration).abs();
        if at_zero { rate } else { value }
    }

    /// How far an extreme is from being an event, where it comes near to one from this side. What rises above zero may fall.
    fn margin(self, side: &mut f64, value: f64, is_least: bool) -> Option<f64> {
        let above = *side > 0.0;
        if self.either || above {
            return (above == is_least).then_some(if above { value } else { -value });
        }
        if is_least {
            return None;
        }
        if value > 0.0 {
            *side = 1.0;
        }
        (value <= 0.0).then_some(-value)
    }

    /// The same at the end of a leg.
    fn at_end(self, side: f64, value: f64) -> Option<f64> {
        match (side > 0.0, self.either) {
            (true, _) => Some(value),
            (false, true) => Some(-value),
            (false, false) => None,
        }
    }
}

/// The value of an event's function that a leg begins with is zero if it is this small against what its rate makes of it on
/// the way.
const AT_ZERO: f64 = 1e-12;

/// What is known of a leg at its end, columns of derivatives included.
#[derive(Clone, Debug)]
pub(crate) struct Landing<R> {
    /// How long it took.
    pub duration: R,
    /// The value of the guard, its rate of change in time, and its derivative along each column; zeros where the leg has none.
    pub surface: R,
    pub surface_rate: R,
    pub surface_acceleration: R,
    pub surface_slopes: Vec<R>,
    /// The derivative of the guard's rate along each column.
    pub rate_slopes: Vec<R>,
    /// The state after the event, its rate of change with the duration, and its derivative along each column.
    pub image: Vec<R>,
    pub image_rate: Vec<R>,
    pub image_slopes: Matrix<R>,
}

/// An inner least value of a guard, or its value at the end of a leg that another guard ends; a crossing of the section that is
/// watched, with the value zero.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Least {
    pub guard: GuardKind,
    /// Since the start of the leg.
    pub time: f64,
    pub value: f64,
    /// How large the guard is on the leg, about.
    pub size: f64,
    /// The state there.
    pub state: Vec<f64>,
    /// Whether this is the end of the leg.
    pub at_end: bool,
}

/// The equations of a leg.
struct Ending {
    graph: Graph,
    field: Vec<Expr>,
    guards: Vec<(GuardKind, Expr)>,
    surface: Option<Expr>,
    map: Vec<Expr>,
    held: Vec<Held>,
    /// Of the corners that its event alone asks for what is positive where it is.
    asked: Vec<(GuardKind, Expr)>,
}

/// A function that a mode holds at zero: gap and rate of a contact that is closed, the surface that is slid along.
struct Held {
    function: Expr,
    /// What changes it by one; without it, the function's own slopes do.
    by: Option<Vec<Expr>>,
}

/// A map of states that are put onto what holds them first: forces of contact and friction keep gap and rates as they are, be they
/// zero or not, so that an orbit which never leaves a contact or a surface would be one of many.
fn onto_what_holds(
    graph: &mut Graph,
    held: &[Held],
    map: &[Expr],
    time: Option<usize>,
) -> Vec<Expr> {
    let mut place: Vec<Expr> = (0..map.len()).map(|i| graph.state(i)).collect();
    for Held { function, by } in held {
        let (direction, part) = match by {
            Some(jump) => (jump.clone(), *function),
            None => {
                let slopes: Vec<Expr> = (0..map.len())
                    .map(|i| match time {
                        Some(time) if time == i => graph.number(0.0),
                        _ => graph.derivative(*function, Symbol::State(i)),
                    })
                    .collect();
                let squares: Vec<Expr> = slopes
                    .iter()
                    .map(|&slope| graph.mul(slope, slope))
                    .collect();
                let square = graph.sum(&squares);
                (slopes, graph.div(*function, square))
            }
        };
        let moved: Vec<Expr> = (direction.iter().enumerate())
            .map(|(i, &along)| {
                let step = graph.mul(along, part);
                let state = graph.state(i);
                graph.sub(state, step)
            })
            .collect();
        let known = place.clone();
        place = (moved.iter())
            .map(|&expr| graph.substitute(expr, &|symbol| at(&known, symbol)))
            .collect();
    }
    (map.iter())
        .map(|&image| graph.substitute(image, &|symbol| at(&place, symbol)))
        .collect()
}

fn at(place: &[Expr], symbol: Symbol) -> Option<Expr> {
    match symbol {
        Symbol::State(i) => place.get(i).copied(),
        Symbol::Parameter(_) => None,
    }
}

/// Derivatives by the state, then by parameters.
fn columns(coordinates: usize, free: &[usize]) -> Vec<Column> {
    (core::iter::repeat_n(Column::State, coordinates))
        .chain(free.iter().map(|&p| Column::Parameter(p)))
        .collect()
}

impl System {
    fn ending(&self, kind: LegKind) -> Option<Ending> {
        let (grip, sides, on_sides) = self.origin_of(kind.mode)?;
        let mut mechanics = on_sides.mechanics.clone();
        let exprs = ModeExprs::new(&mut mechanics, grip)?;
        let limits = Limits::new(
            &mut mechanics,
            (self.corners(), on_sides),
            (self.rubbing(), grip.carrying(), sides),
            &exprs,
        );
        let contacts = mechanics.contacts.clone();
        let stop = match kind.jump {
            Jump::Stop(contact) => Some(stop(&mut mechanics, contact)?.stop),
            _ => None,
        };
        let mut graph = mechanics.graph;
        let sections = &on_sides.sections;
        let guards = guard_functions(&mut graph, &contacts, (sections, &limits), &exprs);
        let mut map: Vec<Expr> = match kind.jump {
            Jump::None => (0..exprs.field.len()).map(|i| graph.state(i)).collect(),
            Jump::Impact(contact) | Jump::Stop(contact) => {
                contacts.get(contact)?.after_impact.clone()
            }
            Jump::Reset(section) => sections.get(section)?.reset.clone()?,
        };
        if let Some(stop) = stop {
            let hit = map.clone();
            for (after, added) in map.iter_mut().zip(stop) {
                let added = graph.substitute(added, &|symbol| at(&hit, symbol));
                *after = graph.add(*after, added);
            }
        }
        let slid_along = (on_sides.followed.surfaces.members())
            .filter(|&index| sides.get(index) == Side::Sliding)
            .map(|index| Held {
                function: on_sides.surfaces[index],
                by: None,
            });
        let in_contact = (grip.carrying().contacts())
            .filter_map(|index| contacts.get(index))
            .flat_map(|contact| {
                [(contact.gap, None), (contact.rate, Some(&contact.jump))].map(|(function, by)| {
                    let by = by.cloned();
                    Held { function, by }
                })
            });
        let held = in_contact.chain(slid_along).collect();
        let asked = match kind.jump {
            Jump::None => Asked::default(),
            Jump::Impact(contact) | Jump::Stop(contact) => limits.impacts[contact],
            Jump::Reset(section) => limits.resets[section],
        };
        let asked = on_sides.guards_of(&mut graph, (self.corners(), sides), asked);
        // What is a corner for the event alone may be where it comes.
        let all = guards.iter().map(|&(guard, _, of)| (guard, of));
        let surface = match kind.ends_at {
            Some(wanted) => {
                let mut all = all.chain(asked.iter().copied());
                Some(all.find(|(guard, _)| *guard == wanted)?.1)
            }
            None => None,
        };
        Some(Ending {
            graph,
            field: exprs.field,
            guards: guards.into_iter().map(|(guard, _, f)| (guard, f)).collect(),
            surface,
            map,
            held,
            asked,
        })
    }

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
        let map = onto_what_holds(graph, &held, &map, self.model().time);
        let columns = columns(coordinates, free);
        let section = section.filter(|&section| kind.ends_at != Some(GuardKind::Section(section)));
        let crossed = section.and_then(|section| {
            let of = |(guard, _): &&(GuardKind, Expr)| *guard == GuardKind::Section(section);
            Some((section, guards.iter().find(of)?.1))
        });
        let mut watched: Vec<(GuardKind, Expr)> = (guards.into_iter())
            .filter(|(guard, _)| match guard {
                GuardKind::Section(index) => self.is_event(*index),
                _ => true,
            })
            .collect();
        let on_the_way = watched.len();
        watched.extend(asked);
        let rates: Vec<Expr> = (watched.iter())
            .map(|&(_, function)| graph.lie_derivative(function, &field))
            .collect();
        let at_point = Tape::new(graph, coordinates, &[], &field);
        let events: Vec<Event> = (watched.iter().enumerate())
            .filter_map(|(guard, (kind, _))| match kind {
                GuardKind::Section(index) => Some(Event {
                    guard,
                    either: self.model().sections[*index].direction == Direction::Either,
                }),
                _ => None,
            })
            .collect();
        let functions: Vec<Expr> = watched.iter().map(|&(_, function)| function).collect();
        let values = Tape::new(graph, coordinates, &[], &functions);
        let at_start = Tape::new(graph, coordinates, &[], &rates);
        let edge = Edge::new(self.model(), graph, (&field, surface, &map), free);
        let bare = |graph: &Graph, sections: Vec<Section>| Model {
            graph: graph.clone(),
            states: (self.model().states.iter().zip(&field))
                .map(|(state, &derivative)| crate::model::State {
                    derivative,
                    ..state.clone()
                })
                .collect(),
            contacts: Vec::new(),
            sections,
            ..self.model().clone()
        };
        let flow = System::with_columns(&bare(graph, Vec::new()), &columns).ok()?;
        let flow = flow.past_roots();
        let surface = |surface: Expr, direction: Direction| Section {
            name: String::new(),
            surface,
            direction,
            reset: None,
        };
        let turning = rates[..on_the_way].iter();
        let turning = turning.map(|&rate| surface(rate, Direction::Rising));
        // A guard falls where its section is crossed.
        let crossing = crossed.map(|(section, function)| {
            let direction = match self.model().sections[section].direction {
                Direction::Either => Direction::Either,
                Direction::Rising | Direction::Falling => Direction::Falling,
            };
            surface(function, direction)
        });
        let falling = events
            .iter()
            .map(|event| surface(rates[event.guard], Direction::Falling));
        let turning: Vec<Section> = turning.chain(crossing).chain(falling).collect();
        let watching = (!turning.is_empty())
            .then(|| System::new(&bare(graph, turning)).ok())
            .flatten()
            .map(System::past_roots);
        Some(Leg {
            kind,
            flow,
            edge,
            watch: Watch {
                system: watching,
                guards: watched.iter().map(|&(guard, _)| guard).collect(),
                on_the_way,
                section: crossed.map(|(section, _)| section),
                events,
                graph: graph.clone(),
                values,
                rates: at_start,
            },
            keeps,
            field: at_point,
            graph: graph.clone(),
            time: self.model().time,
        })
    }
}

impl Edge {
    fn new(
        model: &Model,
        graph: &mut Graph,
        (field, surface, map): (&[Expr], Option<Expr>, &[Expr]),
        free: &[usize],
    ) -> Self {
        let coordinates = field.len();
        let columns = coordinates + free.len();
        let zero = graph.number(0.0);
        let surface = surface.unwrap_or(zero);
        let rate = graph.lie_derivative(surface, field);
        let acceleration = graph.lie_derivative(rate, field);
        let mut outputs = vec![surface, rate, acceleration];
        outputs.extend(map);
        for &image in map {
            outputs.push(graph.lie_derivative(image, field));
        }
        for index in 0..columns {
            let rates = match index.checked_sub(coordinates) {
                Some(place) => model.parameter_rates(graph, free[place]),
                None => Vec::new(),
            };
            let along = Along::new((index + 1) * coordinates, rates);
            outputs.extend(along.along(graph, coordinates, &[surface, rate]));
            outputs.extend(along.along(graph, coordinates, map));
        }
        let tape = Tape::new(graph, coordinates * (1 + columns), &[], &outputs);
        Self {
            graph: graph.clone(),
            tape,
            coordinates,
            columns,
        }
    }

    fn landing<R: Real>(
        &self,
        (expansion, known): (&mut Expansion<R>, &mut Known<R>),
        parameters: &[R],
        duration: R,
        end: &[R],
    ) -> Landing<R> {
        let constants = known.constants(&self.tape, &self.graph, parameters);
        let n = self.coordinates;
        let mut values = vec![R::ZERO; self.tape.outputs.len()];
        let low = vec![R::ZERO; end.len()];
        expansion.evaluate_past_roots(&self.tape, constants, (end, &low), &mut values);
        let mut image_slopes = Matrix::zeros(n, self.columns);
        let mut surface_slopes = Vec::with_capacity(self.columns);
        let mut rate_slopes = Vec::with_capacity(self.columns);
        for (column, slopes) in values[3 + 2 * n..].chunks(2 + n).enumerate() {
            surface_slopes.push(slopes[0]);
            rate_slopes.push(slopes[1]);
            for (i, &slope) in slopes[2..].iter().enumerate() {
                image_slopes[(i, column)] = slope;
            }
        }
        Landing {
            duration,
            surface: values[0],
            surface_rate: values[1],
            surface_acceleration: values[2],
            surface_slopes,
            rate_slopes,
            image: values[3..3 + n].to_vec(),
            image_rate: values[3 + n..3 + 2 * n].to_vec(),
            image_slopes,
        }
    }
}

/// The constants of a tape at the parameters that it was evaluated at last.
#[derive(Clone, Debug)]
struct Known<R> {
    parameters: Vec<R>,
    constants: Vec<R>,
}

impl<R: Real> Known<R> {
    fn new() -> Self {
        Self {
            parameters: Vec::new(),
            constants: Vec::new(),
        }
    }

    fn constants(&mut self, tape: &Tape, graph: &Graph, parameters: &[R]) -> &[R] {
        if self.parameters != parameters || self.constants.is_empty() {
            self.parameters = parameters.to_vec();
            self.constants = tape.constants(graph, parameters);
        }
        &self.constants
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

    /// The inner least values of all guards on the way, in order of time, and the values at the end of those that do not
    /// end the leg; also those of any that is negative where it begins, and of what ends what is held, as though they were at its
    /// end. Guards that the leg begins on are zero there: what is left of them is rounding.
    ///
    /// # Errors
    /// As for [`fly`](Self::fly).
    pub(crate) fn least(
        &self,
        flyer: &mut Flyer<f64>,
        parameters: &[f64],
        (x, duration): (&[f64], f64),
        begins_on: &dyn Fn(GuardKind) -> bool,
    ) -> Result<Vec<Least>, FlowError> {
        let (Some(system), Some(work)) = (&self.watch.system, &mut flyer.watching) else {
            return Ok(Vec::new());
        };
        let clock = self.time.map_or(0.0, |index| x[index]);
        place(system, (&mut flyer.watcher, work), parameters, clock, x)?;
        let Some((_, trajectory)) = &mut flyer.watcher else {
            return Err(left_domain(clock, x));
        };
        trajectory.set_horizon_parts(two_sum(clock, duration));
        let constants = (flyer.at_watch)
            .constants(&self.watch.values, &self.watch.graph, parameters)
            .to_vec();
        let Watch { guards, events, .. } = &self.watch;
        let count = guards.len();
        let (mut began, mut rates) = (vec![0.0; count], vec![0.0; count]);
        let low = vec![0.0; x.len()];
        let mut found = Vec::new();
        let expansion = &mut flyer.expansion;
        expansion.evaluate_past_roots(&self.watch.values, &constants, (x, &low), &mut began);
        for (value, guard) in began.iter_mut().zip(guards) {
            if begins_on(*guard) {
                *value = 0.0;
            }
        }
        let of_rates =
            (flyer.at_watch_start).constants(&self.watch.rates, &self.watch.graph, parameters);
        expansion.evaluate_past_roots(&self.watch.rates, of_rates, (x, &low), &mut rates);
        let mut sides: Vec<f64> = (events.iter())
            .map(|event| event.side(began[event.guard], rates[event.guard], duration))
            .collect();
        let mut sizes: Vec<f64> = (began.iter().zip(&rates))
            .map(|(value, rate)| value.abs().max((rate * duration).abs()))
            .collect();
        let mut values = vec![0.0; count];
        let on_the_way = self.watch.on_the_way;
        let first_fall = on_the_way + usize::from(self.watch.section.is_some());
        for _ in 0..MOST_STEPS {
            let told = trajectory.advance_to_horizon(system, work)?;
            let Some(told) = told else { continue };
            let state = trajectory.state();
            let time = trajectory.time() - clock;
            let here = (state, &low[..]);
            expansion.evaluate_past_roots(&self.watch.values, &constants, here, &mut values);
            for (size, value) in sizes.iter_mut().zip(&values) {
                *size = size.max(value.abs());
            }
            let least = |guard: usize, value: f64, at_end: bool| Least {
                guard: guards[guard],
                time,
                value,
                size: sizes[guard],
                state: state.to_vec(),
                at_end,
            };
            let event = |guard: usize| events.iter().position(|event| event.guard == guard);
            match told {
                Occurrence::Section { section }
                    if section == on_the_way && section < first_fall =>
                {
                    found.extend(self.watch.section.map(|section| Least {
                        guard: GuardKind::Section(section),
                        time,
                        value: 0.0,
                        size: 0.0,
                        state: state.to_vec(),
                        at_end: false,
                    }));
                }
                Occurrence::Section { section } => {
                    let fall = section.checked_sub(first_fall);
                    let guard = fall.map_or(section, |place| events[place].guard);
                    let value = match event(guard) {
                        Some(place) => {
                            let side = &mut sides[place];
                            events[place].margin(side, values[guard], fall.is_none())
                        }
                        None => Some(values[guard]),
                    };
                    found.extend(value.map(|value| least(guard, value, false)));
                }
                Occurrence::Horizon => {
                    let ends_it = |guard: usize| Some(guards[guard]) == self.kind.ends_at;
                    let others = (0..count).filter(|&guard| !ends_it(guard));
                    let at_end = |guard: usize| match event(guard) {
                        Some(place) => events[place].at_end(sides[place], values[guard]),
                        None => Some(values[guard]),
                    };
                    found.extend(
                        others.filter_map(|guard| {
                            at_end(guard).map(|value| least(guard, value, true))
                        }),
                    );
                    let begins_beyond = |&guard: &usize| {
                        let by = match ends_it(guard) {
                            true => sizes[guard],
                            false => (values[guard] - began[guard]).abs(),
                        };
                        let holds = ends_it(guard) && !matches!(guards[guard], GuardKind::Gap(_));
                        event(guard).is_none() && (holds || began[guard] < -JUST_OPENED * by)
                    };
                    found.extend((0..on_the_way).filter(begins_beyond).map(|guard| Least {
                        time: 0.0,
                        state: x.to_vec(),
                        ..least(guard, began[guard], true)
                    }));
                    return Ok(found);
                }
                _ => {}
            }
        }
        Err(left_domain(clock, x))
    }
}

/// The guard of what a leg begins with is known to this part of what it changes by on the leg.
const JUST_OPENED: f64 = 1e-9;

/// A stretch of the flow with whatever happens on it, from a state up to an event: for what has no fixed number of events, such
/// as complete chatter.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    system: System,
    edge: Edge,
    /// The guard that ends it, and how many chatter sequences come to their end before.
    ends_at: Option<GuardKind>,
    accumulations: usize,
    /// Contacts that are closed where it starts, and the gaps to start on.
    closed: Closed,
    gaps: Vec<Expr>,
    time: Option<usize>,
}

/// What a stretch starts from and ends at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StretchKind {
    /// Contacts that are closed at the start.
    pub closed: Closed,
    /// Contacts at which there were impacts just before, and that are open.
    pub on: Closed,
    /// Chatter sequences that end on the way.
    pub accumulations: usize,
    /// Impacts on the way, where none do.
    pub impacts: usize,
    /// The mode that it ends in, and how.
    pub last: LegKind,
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
        Some(Stretch {
            system: System::with_columns(self.model(), &columns).ok()?,
            edge: Edge::new(self.model(), &mut graph, (&field, surface, &map), free),
            ends_at: kind.last.ends_at,
            accumulations: kind.accumulations,
            closed: kind.closed,
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
    /// Its flights cross a surface: with derivatives such chatter is followed impact by impact, and so has no end.
    Crosses,
    /// It cannot be followed.
    Failed(FlowError),
}

impl From<FlowError> for Astray {
    fn from(error: FlowError) -> Self {
        Self::Failed(error)
    }
}

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
    /// the end.
    pub(crate) fn follow<R: Real>(
        &self,
        follower: &mut Follower<R>,
        parameters: &[R],
        x: &[R],
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
        let mut trajectory = if self.closed == Closed::NONE {
            Trajectory::start(system, work, parameters, clock, &start)?
        } else {
            // Started anywhere, to have the parameters; then with these contacts closed.
            let mut trajectory = Trajectory::start(system, work, parameters, clock, &start)?;
            trajectory.restart_beside(system, work, self.closed, clock, &start)?;
            trajectory
        };
        trajectory.set_horizon_parts(two_sum(clock, longest));
        let mut accumulations = 0;
        let mut astray = Astray::Otherwise;
        for _ in 0..MOST_EVENTS {
            let mut told = None;
            for _ in 0..MOST_STEPS {
                told = trajectory.advance_to_horizon(system, work)?;
                if told.is_some() || trajectory.ended_by().is_some() {
                    break;
                }
            }
            match told {
                Some(Occurrence::Horizon) => {
                    if self.ends_at.is_some() {
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
                Some(Occurrence::Switch { .. }) if accumulations < self.accumulations => {
                    astray = Astray::Crosses;
                }
                _ => {}
            }
            let Some(guard) = trajectory.ended_by() else {
                continue;
            };
            if Some(guard) == self.ends_at && accumulations >= self.accumulations {
                let duration = trajectory.time() - clock;
                let dense = work.dense();
                let end: Vec<R> = (0..start.len()).map(|i| dense.state(i, R::ONE)).collect();
                return Ok((self.edge).landing(
                    (&mut follower.expansion, &mut follower.at_edge),
                    all,
                    duration,
                    &end,
                ));
            }
        }
        Err(astray)
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
