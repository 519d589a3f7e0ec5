//! What came of a simulation.

use super::samples::Samples;
use super::spec::EventTarget;
use crate::flow::{Closed, EventKind, FlowError, Held, Occurrence};

/// A trajectory as a list of what happened. Contacts and sections are indices into the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation<R> {
    /// Why it ended.
    pub outcome: Outcome,
    /// Time where it began.
    pub start_time: R,
    /// State where it began.
    pub start_state: Vec<R>,
    /// What held the state there beside contact forces.
    pub start_held: Held,
    /// Time where it ended.
    pub time: R,
    /// State where it ended.
    pub state: Vec<R>,
    /// Contacts that were closed where it ended.
    pub closed: Closed,
    /// What held the state there beside contact forces.
    pub held: Held,
    /// How often what happened.
    pub counts: Counts,
    /// What happened, in order, unless a [`Sink`](super::Sink) has taken it.
    pub events: Vec<Event<R>>,
    /// Phases of persistent contact, in order of their start, unless a sink has taken them.
    pub contact_phases: Vec<ContactPhase<R>>,
    /// The state at the times asked for, one list for each sampling of the specification.
    pub samples: Vec<Samples<R>>,
}

/// Why a simulation ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The time asked for was reached.
    Horizon,
    /// As many impacts as allowed have happened.
    ImpactBudget,
    /// An event that was waited for has happened.
    Event(EventTarget),
    /// A contact is closed and nothing changes any more; the simulation ended when that began.
    Rest,
    /// The observer broke off.
    Interrupted,
    /// The trajectory cannot go on.
    Failed(FlowError),
}

impl Outcome {
    /// A word for it, the same in all output.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Horizon => "horizon",
            Self::ImpactBudget => "impact_budget",
            Self::Event(_) => "event",
            Self::Rest => "rest",
            Self::Interrupted => "interrupted",
            Self::Failed(error) => error.name(),
        }
    }
}

/// How often what happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counts {
    /// Stretches of free motion with no contact closed, those that were extrapolated at accumulations left out.
    pub flights: u64,
    /// Impacts, those that were extrapolated at accumulations left out.
    pub impacts: u64,
    /// Complete chatter sequences.
    pub accumulations: u64,
    /// Releases.
    pub releases: u64,
    /// Touches without impact.
    pub grazes: u64,
    /// Sections crossed.
    pub sections: u64,
    /// Simultaneous impacts whose order changes what follows, and is not said by the equations.
    pub ambiguities: u64,
    /// Corners of the equations passed: surfaces crossed, slid along and left, sticking and slipping, and events.
    pub switches: u64,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event<R> {
    /// When.
    pub time: R,
    /// The state just after it.
    pub state: Vec<R>,
    /// The kind of it.
    pub kind: EventKind,
    /// What.
    pub detail: Occurrence<R>,
}

/// A stretch of persistent contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPhase<R> {
    /// Which contact.
    pub contact: usize,
    /// When it closed.
    pub start: R,
    /// When it opened; none where the simulation ended before.
    pub end: Option<R>,
}
