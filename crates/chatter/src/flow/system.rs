//! A model compiled for integration.

use super::error::FlowError;
use super::modes::closed::{Closed, Grip};
use super::modes::equations::ModeExprs;
use super::modes::limits::{Corner, Limits};
use super::modes::program::{Program, ProgramConstants};
use super::modes::{Flight, Mode, Modes};
use super::step::Workspace;
use super::touch::Touches;
use super::touching::Touching;
use super::variation::{Column, Direction, extend};
use crate::expressions::{
    Backend, Corners, Expr, Graph, Names, Node, Side, Sides, Singularity, Surfaces, Symbol, Tape,
};
use crate::model::{Contact, Mechanics, MechanicsError, Model, OnSides, Rubbing, Simultaneous};
use crate::numerics::{DoubleDouble, Real, Scalar};
use core::fmt;
use std::sync::Arc;

/// Numerical choices of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Relative truncation error allowed a step; rounding level of the number type where that is larger.
    pub tolerance: f64,
    /// A chatter sequence is completed by extrapolation once what is left of it is at most this share of the time that it
    /// has taken so far, and its end is certain to rounding. Without a bound the second condition alone decides, after
    /// the fewest impacts; a small share shows the sequence itself.
    pub longest_tail: f64,
    /// What runs the expansions: the results do not depend on it.
    pub backend: Backend,
}

impl Default for Settings {
    /// To rounding error, with the fewest impacts.
    fn default() -> Self {
        Self {
            tolerance: 0.0,
            longest_tail: f64::INFINITY,
            backend: Backend::default(),
        }
    }
}

/// A model compiled for integration, shared by all trajectories and threads: a program for each mode that they meet.
#[derive(Clone, Debug)]
pub struct System {
    /// Its graph continues the model's by what the columns need.
    model: Arc<Model>,
    corners: Corners,
    /// Those that only jumps change.
    counted: Vec<Corner>,
    /// Whether a gap is a function of corners: it may jump there.
    gaps_have_corners: bool,
    /// By number of a surface the contacts whose gaps have a corner there.
    kinks: Vec<Closed>,
    rubbing: Vec<Rubbing>,
    /// By number of a surface those that vanish with it, and itself: as two contacts of one body slide at one rate.
    alike: Vec<Surfaces>,
    /// Surfaces that are constant multiples of gaps: their numbers, contacts and constants.
    kept: Vec<(usize, usize, Expr)>,
    directions: Vec<Direction>,
    /// Of states and parameters.
    names: [Vec<String>; 2],
    modes: Arc<Modes>,
    dimension: usize,
    coordinates: usize,
    /// Trajectories go on where a root is taken of what is negative, as if it were nothing.
    past_roots: bool,
}

/// Number of the mode in which nothing is closed: every trajectory meets it first.
pub(crate) const FLIGHT: usize = 0;

impl System {
    /// Derives and compiles everything that the flow of a model needs.
    ///
    /// # Errors
    /// The mechanics cannot be derived, or there are too many contacts and sections.
    pub fn new(model: &Model) -> Result<Self, SystemError> {
        Self::with_columns(model, &[])
    }

    /// Like [`new`](Self::new), with derivatives carried along: the state is followed by one column after the other,
    /// each as long as the model's state. Where a trajectory starts, each holds what it is the derivative of.
    ///
    /// At a graze the derivative does not exist: columns stay as they are where an impact has no rate, and grow without
    /// bound as its rate goes to zero. Impacts while another contact is closed are covered as long as that contact stays
    /// closed.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_columns(model: &Model, columns: &[Column]) -> Result<Self, SystemError> {
        let (corners, rubbing) = model.corners();
        // A closed contact that sticks has three guards, a lookup two, and two more where it has an end.
        let guards = 3 * model.contacts.len() + model.sections.len();
        let ends = (0..corners.lookups.len())
            .filter(|&index| corners.bounds(&model.graph, index).is_some());
        let count = guards + 2 * (corners.surfaces.len() + corners.lookups.len() + ends.count());
        let plain = model.contacts.len() + model.sections.len();
        let count = if corners.is_empty() { plain } else { count };
        let corner_count = corners.surfaces.len().max(corners.lookups.len());
        if count > Touching::GUARDS || corner_count > Sides::MOST {
            return Err(SystemError::Flow(FlowError::TooManySurfaces {
                count,
                limit: Touching::GUARDS,
            }));
        }
        match Mechanics::new(model) {
            // What else a form of the field may lack is found where that form is met.
            Err(error @ MechanicsError::ImpulseLeavesRate { .. }) => {
                return Err(SystemError::Model(error));
            }
            Err(error) if corners.is_empty() => return Err(SystemError::Model(error)),
            _ => {}
        }
        let mut model = model.clone();
        let coordinates = model.states.len();
        let mut graph = model.graph.clone();
        let kept = kept(&mut graph, &corners.surfaces, &model.contacts);
        let alike = alike(&mut graph, &corners.surfaces);
        let directions: Vec<Direction> = (columns.iter().enumerate())
            .map(|(index, &column)| {
                Direction::of(column, &model, &mut graph, (index + 1) * coordinates)
            })
            .collect();
        model.graph = graph;
        let gaps: Vec<Expr> = model.contacts.iter().map(|contact| contact.gap).collect();
        let own = Corners::of(&model.graph, &gaps, model.parameters.len());
        let system = Self {
            counted: counted(&model, &corners),
            gaps_have_corners: !own.is_empty(),
            kinks: kinks(&model, &corners),
            names: [
                model.states.iter().map(|s| s.name.clone()).collect(),
                model.parameters.iter().map(|p| p.name.clone()).collect(),
            ],
            model: Arc::new(model),
            corners,
            rubbing,
            alike,
            kept,
            dimension: coordinates * (1 + columns.len()),
            coordinates,
            directions,
            modes: Arc::default(),
            past_roots: false,
        };
        system.meet(Grip::NONE, Sides::default());
        Ok(system)
    }

    /// The same where trajectories go past everything: on where a root is taken of what is negative, as if it were nothing.
    #[must_use]
    pub(crate) fn past_roots(mut self) -> Self {
        self.past_roots = true;
        self
    }

    pub(crate) fn goes_past_roots(&self) -> bool {
        self.past_roots
    }

    /// Length of the state of a trajectory: the model's states, time included, and the columns.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of states of the model, time included.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// The components of column number `index` in a state of a trajectory.
    pub fn column<'s, R>(&self, state: &'s [R], index: usize) -> &'s [R] {
        &state[(index + 1) * self.coordinates..(index + 2) * self.coordinates]
    }

    fn names(&self) -> Names<'_> {
        Names {
            states: &self.names[0],
            parameters: &self.names[1],
        }
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.model.contacts.len()
    }

    /// Number of sections.
    pub fn sections(&self) -> usize {
        self.model.sections.len()
    }

    /// The number of the mode in which these contacts are closed, on these sides of the surfaces.
    pub(crate) fn meet(&self, grip: Grip, sides: Sides) -> usize {
        let flight = (grip != Grip::NONE).then(|| self.meet(Grip::NONE, sides));
        self.modes.meet((grip, sides), || match flight {
            Some(flight) => self.held(grip, sides, flight),
            None => self.flight(sides),
        })
    }

    /// The mode in which nothing is closed.
    fn flight(&self, sides: Sides) -> Mode {
        let found = Mechanics::on_sides(&self.model, &self.corners, &self.rubbing, sides);
        let Ok(on_sides) = found else {
            return Mode {
                grip: Grip::NONE,
                sides,
                surfaces: Surfaces::all(self.corners.surfaces.len()),
                program: None,
                graph: Graph::default(),
                flight: None,
            };
        };
        let mut mechanics = on_sides.mechanics.clone();
        let program = self.compile(&mut mechanics, &on_sides, Grip::NONE, sides);
        let touches = Touches::new(
            &on_sides.mechanics,
            &self.directions,
            (self.model.time, self.corners.first_slot),
        );
        Mode {
            grip: Grip::NONE,
            sides,
            surfaces: on_sides.active.surfaces,
            program,
            graph: mechanics.graph,
            flight: Some(Box::new(Flight { on_sides, touches })),
        }
    }

    /// A mode in which contacts are closed.
    fn held(&self, grip: Grip, sides: Sides, flight: usize) -> Mode {
        let flight = self.modes.get(flight).and_then(|mode| mode.flight.as_ref());
        let mut mechanics = flight.map(|flight| flight.on_sides.mechanics.clone());
        let program = (flight.zip(mechanics.as_mut()))
            .and_then(|(flight, mechanics)| self.compile(mechanics, &flight.on_sides, grip, sides));
        Mode {
            grip,
            sides,
            surfaces: flight.map_or(Surfaces::all(self.corners.surfaces.len()), |flight| {
                flight.on_sides.active.surfaces
            }),
            program,
            graph: mechanics.map_or_else(Graph::default, |mechanics| mechanics.graph),
            flight: None,
        }
    }

    fn compile(
        &self,
        mechanics: &mut Mechanics,
        on_sides: &OnSides,
        grip: Grip,
        sides: Sides,
    ) -> Option<Program> {
        let mut mode = ModeExprs::new(mechanics, grip)?;
        extend(&mut mode, mechanics, &self.directions);
        let limits = Limits::new(
            mechanics,
            (&self.corners, on_sides),
            (&self.rubbing, grip.carrying(), sides),
            &mode,
        );
        let mut program = Program::new(
            mechanics,
            (&on_sides.sections, &limits),
            &self.directions,
            self.model.time,
            &mode,
            self.names(),
        );
        if !self.corners.lookups.is_empty() {
            program.look_up_from(&mechanics.graph, self.corners.first_slot);
        }
        Some(program)
    }

    /// What a mode is, and what holds on its sides.
    pub(crate) fn origin_of(&self, mode: usize) -> Option<(Grip, Sides, &OnSides)> {
        let mode = self.modes.get(mode)?;
        let flight = self.modes.get(self.meet(Grip::NONE, mode.sides))?;
        Some((mode.grip, mode.sides, &flight.flight.as_ref()?.on_sides))
    }

    /// The program of a mode; none where its contacts cannot be held together.
    #[inline(always)]
    pub(crate) fn program(&self, mode: usize) -> Option<&Program> {
        self.modes.get(mode)?.program.as_ref()
    }

    /// The same with the graph that holds the expressions of its constants.
    pub(super) fn compiled(&self, mode: usize) -> Option<(&Graph, &Program)> {
        let mode = self.modes.get(mode)?;
        Some((&mode.graph, mode.program.as_ref()?))
    }

    /// Which constants of a tape of a mode change with any of these parameters.
    pub(crate) fn constants_depending_on(
        &self,
        mode: usize,
        tape: &Tape,
        parameters: &[usize],
    ) -> Vec<usize> {
        let Some(mode) = self.modes.get(mode) else {
            return Vec::new();
        };
        tape.constants_where(|expr| {
            let symbols = mode.graph.symbols(expr);
            parameters
                .iter()
                .any(|&p| symbols.contains(&Symbol::Parameter(p)))
        })
    }

    /// The constants of a mode's program at one parameter set.
    pub(crate) fn constants<R: Real>(
        &self,
        mode: usize,
        parameters: &[R],
    ) -> Option<ProgramConstants<R>> {
        let mode = self.modes.get(mode)?;
        let program = mode.program.as_ref()?;
        Some(program.constants(&mode.graph, parameters))
    }

    /// Of what must not vanish in a mode, what is nearest to it at a state: how near, and its formula.
    pub(crate) fn singular_at<R: Real>(
        &self,
        mode: usize,
        state: &[R],
        parameters: &[R],
    ) -> Option<(f64, Singularity, String)> {
        let mode = self.modes.get(mode)?;
        let program = mode.program.as_ref()?;
        let size = |expr: Expr| mode.graph.evaluate(expr, state, parameters).abs().to_f64();
        let known = (program.tape.singular.iter().zip(&program.vanishing))
            .filter_map(|(singular, text)| Some((size(singular.expr?), singular.kind, text)));
        let nearest = known.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((nearest.0, nearest.1, nearest.2.clone()))
    }

    /// Computes those of them anew that change at knots.
    pub(crate) fn renew_constants<R: Real>(
        &self,
        mode: usize,
        parameters: &[R],
        constants: &mut ProgramConstants<R>,
    ) {
        if let Some(mode) = self.modes.get(mode)
            && let Some(program) = &mode.program
        {
            program.renew(&mode.graph, parameters, constants);
        }
    }

    /// All contacts at one state, on the sides of a mode in which nothing is closed.
    pub(crate) fn touches(&self, flight: usize) -> Option<&Touches> {
        let flight = self.modes.get(flight)?.flight.as_ref()?;
        Some(&flight.touches)
    }

    /// Whether a section is the surface of an event that changes the state.
    pub(crate) fn is_event(&self, section: usize) -> bool {
        self.model.sections[section].reset.is_some()
    }

    /// Corners at which nothing moves the state but resets: of what counts.
    pub(crate) fn counted(&self) -> &[Corner] {
        &self.counted
    }

    /// The side of a surface that one of these contacts opens to, if it is a multiple of its gap.
    pub(crate) fn kept_on<R: Real>(
        &self,
        (surface, contacts): (usize, Closed),
        parameters: &[R],
    ) -> Option<Side> {
        let of = |&&(kept, contact, _): &&(usize, usize, Expr)| {
            kept == surface && contacts.contains(contact)
        };
        let (.., factor) = *self.kept.iter().find(of)?;
        let factor = self.model.graph.evaluate(factor, &[], parameters);
        match factor > R::ZERO {
            true => Some(Side::Above),
            false => (factor < R::ZERO).then_some(Side::Below),
        }
    }

    /// What is zero at a corner, or looked up there, as it was written. Of two, what the other is a function of comes first.
    pub(crate) fn corner_expr(&self, corner: Corner) -> Expr {
        match corner {
            Corner::Surface(index) => self.corners.surfaces[index],
            Corner::Lookup(index) => self.corners.lookups[index].argument,
        }
    }

    /// What a corner is called in words: its formula.
    pub(crate) fn corner_name(&self, corner: Corner) -> String {
        self.model.formula(self.corner_expr(corner))
    }

    /// The model that the system was compiled from.
    pub(crate) fn model(&self) -> &Model {
        &self.model
    }

    /// The model's parameters followed by those of the pieces that lookups are in.
    pub(crate) fn with_pieces<R: Real>(&self, parameters: &[R], pieces: &[i64]) -> Vec<R> {
        let mut all = parameters.to_vec();
        let graph = &self.model().graph;
        for (index, &piece) in pieces.iter().enumerate() {
            let slots = self.corners().slots_of::<R>(graph, index, piece);
            all.extend(slots.unwrap_or_default());
        }
        all
    }

    /// The corners of the model's expressions.
    #[inline(always)]
    pub(crate) fn corners(&self) -> &Corners {
        &self.corners
    }

    /// Whether a gap may jump at a corner.
    pub(crate) fn gaps_have_corners(&self) -> bool {
        self.gaps_have_corners
    }

    /// The contacts whose gaps have a corner on a surface.
    pub(crate) fn kinks_of(&self, surface: usize) -> Closed {
        self.kinks[surface]
    }

    /// Contacts with friction.
    pub(crate) fn rubbing(&self) -> &[Rubbing] {
        &self.rubbing
    }

    /// The friction of a contact, if it has any.
    pub(crate) fn rubbing_at(&self, contact: usize) -> Option<&Rubbing> {
        self.rubbing.iter().find(|rubs| rubs.contact == contact)
    }

    /// The surfaces that vanish with one, and itself: multiples of one function.
    pub(crate) fn alike(&self, surface: usize) -> Surfaces {
        self.alike.get(surface).copied().unwrap_or_default()
    }

    /// The law of simultaneous impacts.
    pub(crate) fn simultaneous(&self) -> Simultaneous {
        self.model.simultaneous
    }

    /// Scratch space for steps of this system.
    pub fn workspace<S: Scalar>(&self, settings: &Settings) -> Workspace<S> {
        let tapes = self.program(FLIGHT).into_iter().flat_map(Program::tapes);
        Workspace::new(
            tapes,
            (self.dimension, self.model.time, self.sections()),
            settings,
        )
    }
}

/// Why a model cannot be compiled.
#[derive(Clone, Debug)]
pub enum SystemError {
    /// The model's mechanics cannot be derived.
    Model(MechanicsError),
    /// The flow does not support it.
    Flow(FlowError),
}

impl fmt::Display for SystemError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(error) => error.fmt(out),
            Self::Flow(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for SystemError {}

/// The corners of functions of states that neither the flow nor contacts change.
fn counted(model: &Model, corners: &Corners) -> Vec<Corner> {
    let graph = &model.graph;
    let stands = |expr: Expr| graph.as_number(expr) == Some(DoubleDouble::ZERO);
    let is_counter = |index: usize| {
        let held = model
            .contacts
            .iter()
            .filter(|contact| contact.reset.is_none());
        let mut forces = held.flat_map(|contact| {
            let along = contact
                .friction
                .as_ref()
                .map(|friction| friction.along[index]);
            along.into_iter().chain([contact.impulse[index]])
        });
        stands(model.states[index].derivative) && forces.all(stands)
    };
    let counts = |expr: Expr| {
        let states: Vec<usize> = (graph.reachable(&[expr]).into_iter())
            .filter_map(|node| match graph.node(node) {
                &Node::Symbol(Symbol::State(index)) => Some(index),
                _ => None,
            })
            .collect();
        !states.is_empty() && states.into_iter().all(is_counter)
    };
    let surfaces = corners.surfaces.iter().enumerate();
    let surfaces = surfaces.map(|(index, &expr)| (Corner::Surface(index), expr));
    let lookups = corners.lookups.iter().enumerate();
    let lookups = lookups.map(|(index, lookup)| (Corner::Lookup(index), lookup.argument));
    (surfaces.chain(lookups))
        .filter(|&(_, expr)| counts(expr))
        .map(|(corner, _)| corner)
        .collect()
}

/// Surfaces that are constant multiples of gaps.
fn kept(graph: &mut Graph, surfaces: &[Expr], contacts: &[Contact]) -> Vec<(usize, usize, Expr)> {
    let mut kept = Vec::new();
    for (surface, &function) in surfaces.iter().enumerate() {
        for (contact, of) in contacts.iter().enumerate() {
            let factor = graph.factor_of(function, of.gap);
            kept.extend(factor.map(|factor| (surface, contact, factor)));
        }
    }
    kept
}

/// By number of a surface those that are constant multiples of it.
fn alike(graph: &mut Graph, surfaces: &[Expr]) -> Vec<Surfaces> {
    let mut is_multiple =
        |one: Expr, other: Expr| one == other || graph.factor_of(one, other).is_some();
    (surfaces.iter())
        .map(|&one| {
            (surfaces.iter().enumerate())
                .filter(|&(_, &other)| is_multiple(one, other))
                .fold(Surfaces::default(), |all, (index, _)| all.with(index))
        })
        .collect()
}

/// By number of a surface the contacts whose gaps have a corner there.
fn kinks(model: &Model, corners: &Corners) -> Vec<Closed> {
    let mut kinks = vec![Closed::NONE; corners.surfaces.len()];
    for (contact, of) in model.contacts.iter().enumerate() {
        for surface in Corners::of(&model.graph, &[of.gap], 0).surfaces {
            if let Some(index) = corners.surface(surface) {
                kinks[index] = kinks[index].with(contact);
            }
        }
    }
    kinks
}
