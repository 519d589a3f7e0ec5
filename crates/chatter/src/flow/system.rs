//! A model compiled for integration.

use super::error::FlowError;
use super::program::{Closed, Phase, Program, ProgramConstants};
use super::step::Workspace;
use super::touching::Touching;
use super::variation::{Column, Direction, extend};
use crate::expressions::{Graph, Symbol, Tape};
use crate::model::{Mechanics, MechanicsError, Model};
use crate::numerics::{Real, Scalar};
use core::fmt;

/// Closed sets are enumerated, 2^n of them.
const MAX_CONTACTS: usize = 6;

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

/// Programs of a model for every set of closed contacts, shared by all trajectories and threads.
#[derive(Clone, Debug)]
pub struct System {
    graph: Graph,
    programs: Vec<Option<Program>>,
    dimension: usize,
    coordinates: usize,
    contacts: usize,
    sections: usize,
}

impl System {
    /// Derives and compiles everything that the flow of a model needs.
    ///
    /// # Errors
    /// The mechanics cannot be derived, or there are too many contacts.
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
        if contacts > MAX_CONTACTS {
            return Err(SystemError::Flow(FlowError::TooManyContacts {
                count: contacts,
                limit: MAX_CONTACTS,
            }));
        }
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
        let mut programs = Vec::new();
        for bits in 0..1_u32 << contacts {
            let phase = Phase::new(&mut mechanics, Closed(bits)).map(|mut phase| {
                extend(&mut phase, &mut mechanics, &directions);
                phase
            });
            programs
                .push(phase.map(|phase| {
                    Program::new(&mut mechanics, &model.sections, model.time, &phase)
                }));
        }
        Ok(Self {
            graph: mechanics.graph,
            programs,
            dimension: coordinates * (1 + columns.len()),
            coordinates,
            contacts,
            sections: model.sections.len(),
        })
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

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Number of sections.
    pub fn sections(&self) -> usize {
        self.sections
    }

    /// The program of a phase; none where these contacts cannot be held together.
    pub(crate) fn program(&self, closed: Closed) -> Option<&Program> {
        self.programs[closed.0 as usize].as_ref()
    }

    /// All programs, by the bits of their closed sets.
    pub(crate) fn programs(&self) -> impl Iterator<Item = Option<&Program>> {
        self.programs.iter().map(Option::as_ref)
    }

    /// Which constants of a tape change with any of these parameters.
    pub(crate) fn constants_depending_on(&self, tape: &Tape, parameters: &[usize]) -> Vec<usize> {
        tape.constants_where(|expr| {
            let symbols = self.graph.symbols(expr);
            parameters
                .iter()
                .any(|&p| symbols.contains(&Symbol::Parameter(p)))
        })
    }

    pub(crate) fn constants<R: Real>(&self, parameters: &[R]) -> Vec<Option<ProgramConstants<R>>> {
        self.programs
            .iter()
            .map(|program| {
                program
                    .as_ref()
                    .map(|p| p.constants(&self.graph, parameters))
            })
            .collect()
    }

    /// Scratch space for steps of this system.
    pub fn workspace<S: Scalar>(&self, settings: &Settings) -> Workspace<S> {
        let tapes = self.programs.iter().flatten().flat_map(Program::tapes);
        Workspace::new(tapes, (self.dimension, self.sections), settings)
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
