//! A model compiled for integration.

use super::error::FlowError;
use super::modes::{Mode, Modes};
use super::program::{Closed, Phase, Program, ProgramConstants};
use super::step::Workspace;
use super::touch::Touches;
use super::touching::Touching;
use super::variation::{Column, Direction, extend};
use crate::expressions::{Names, Symbol, Tape};
use crate::model::{Mechanics, MechanicsError, Model, Section, Simultaneous};
use crate::numerics::{Real, Scalar};
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
}

impl Default for Settings {
    /// To rounding error, with the fewest impacts.
    fn default() -> Self {
        Self {
            tolerance: 0.0,
            longest_tail: f64::INFINITY,
        }
    }
}

/// A model compiled for integration, shared by all trajectories and threads: a program for each mode that they meet.
#[derive(Clone, Debug)]
pub struct System {
    mechanics: Mechanics,
    surfaces: Vec<Section>,
    time: Option<usize>,
    directions: Vec<Direction>,
    /// Of states and parameters.
    names: [Vec<String>; 2],
    modes: Arc<Modes>,
    touches: Touches,
    simultaneous: Simultaneous,
    dimension: usize,
    coordinates: usize,
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
        let contacts = model.contacts.len();
        if contacts + model.sections.len() > Touching::GUARDS {
            return Err(SystemError::Flow(FlowError::TooManySurfaces {
                count: contacts + model.sections.len(),
                limit: Touching::GUARDS,
            }));
        }
        let mut mechanics = Mechanics::new(model).map_err(SystemError::Model)?;
        let coordinates = model.states.len();
        let directions: Vec<Direction> = (columns.iter().enumerate())
            .map(|(index, column)| {
                let parameters = match *column {
                    Column::State => Vec::new(),
                    Column::Parameter(p) => model.parameter_rates(&mut mechanics.graph, p),
                };
                Direction::new((index + 1) * coordinates, parameters)
            })
            .collect();
        let system = Self {
            touches: Touches::new(&mechanics, &directions, model.time),
            simultaneous: model.simultaneous,
            mechanics,
            surfaces: model.sections.clone(),
            time: model.time,
            dimension: coordinates * (1 + columns.len()),
            coordinates,
            directions,
            names: [
                model.states.iter().map(|s| s.name.clone()).collect(),
                model.parameters.iter().map(|p| p.name.clone()).collect(),
            ],
            modes: Arc::default(),
        };
        system.meet(Closed::NONE);
        Ok(system)
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
        self.mechanics.contacts.len()
    }

    /// Number of sections.
    pub fn sections(&self) -> usize {
        self.surfaces.len()
    }

    /// The number of the mode in which these contacts are closed.
    pub(crate) fn meet(&self, closed: Closed) -> usize {
        self.modes.meet(closed, || {
            let mut mechanics = self.mechanics.clone();
            let phase = Phase::new(&mut mechanics, closed);
            let program = phase.map(|mut phase| {
                extend(&mut phase, &mut mechanics, &self.directions);
                Program::new(
                    &mut mechanics,
                    &self.surfaces,
                    self.time,
                    &phase,
                    self.names(),
                )
            });
            Mode {
                closed,
                program,
                graph: mechanics.graph,
            }
        })
    }

    /// The program of a mode; none where its contacts cannot be held together.
    #[inline]
    pub(crate) fn program(&self, mode: usize) -> Option<&Program> {
        self.modes.get(mode)?.program.as_ref()
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

    /// All contacts at one state.
    pub(crate) fn touches(&self) -> &Touches {
        &self.touches
    }

    /// The law of simultaneous impacts.
    pub(crate) fn simultaneous(&self) -> Simultaneous {
        self.simultaneous
    }

    /// Scratch space for steps of this system.
    pub fn workspace<S: Scalar>(&self, settings: &Settings) -> Workspace<S> {
        let tapes = self.program(FLIGHT).into_iter().flat_map(Program::tapes);
        Workspace::new(tapes, (self.dimension, self.sections()), settings)
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
