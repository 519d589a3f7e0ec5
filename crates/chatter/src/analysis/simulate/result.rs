//! What came of a simulation.

use super::samples::Samples;
use super::spec::{EventKind, EventTarget};
use crate::expressions::Side;
use crate::flow::{Closed, FlowError, Held};
use crate::numerics::Real;

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
    /// What.
    pub detail: EventDetail<R>,
}

impl<R> Event<R> {
    /// The kind of event.
    pub const fn kind(&self) -> EventKind {
        self.detail.kind()
    }
}

/// What belongs to an event of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventDetail<R> {
    /// A collision.
    Impact {
        /// Where.
        contact: usize,
        /// Gap rate before, negative.
        rate_before: R,
        /// Gap rate after.
        rate_after: R,
        /// Whether it was without rebound, so that the contact is closed from here on.
        closes: bool,
    },
    /// An infinite sequence of impacts came to its end: the contact is closed from here on.
    Accumulation {
        /// Where.
        contact: usize,
        /// How many impacts of the sequence were integrated one by one.
        impacts: u64,
        /// Estimated local error of its time: of the completion, and of rounding (or the tolerance) in the impacts before
        /// it, but not of the state that the sequence began from. [`Verification`](super::Verification) finds all of it.
        error: f64,
    },
    /// The contact force vanished and the contact opens.
    Release {
        /// Where.
        contact: usize,
    },
    /// A contact was touched with a rate that cannot be told from zero.
    Graze {
        /// Where.
        contact: usize,
        /// Gap rate there.
        rate: R,
    },
    /// A section was crossed in its direction.
    Section {
        /// Which.
        section: usize,
    },
    /// Binary collisions at one instant that have no last one converged.
    Cascade {
        /// The contact of the latest of them.
        contact: usize,
        /// How many were carried out one by one, those told as impacts among them.
        impacts: u64,
        /// Estimated error of the rates after it, as a part of the greatest rate before.
        error: f64,
    },
    /// The form of the equations changed at a corner, or an event changed the state.
    Corner {
        /// What happened.
        kind: EventKind,
        /// The surface; for sticking and slipping the contact; for a reset its section.
        place: usize,
        /// The side that the trajectory is on now, where it is on one.
        side: Option<Side>,
    },
    /// Two contacts close at one instant, and what follows depends on which of them collides first.
    Ambiguity {
        /// The contact that collides first, closing fastest.
        contact: usize,
        /// The contact that could as well.
        other: usize,
    },
}

impl<R> EventDetail<R> {
    /// The kind of event.
    pub const fn kind(&self) -> EventKind {
        match self {
            Self::Impact { .. } => EventKind::Impact,
            Self::Accumulation { .. } => EventKind::Accumulation,
            Self::Release { .. } => EventKind::Release,
            Self::Graze { .. } => EventKind::Graze,
            Self::Section { .. } => EventKind::Section,
            Self::Cascade { .. } => EventKind::Cascade,
            Self::Ambiguity { .. } => EventKind::Ambiguity,
            Self::Corner { kind, .. } => *kind,
        }
    }
}

impl<R: Real> EventDetail<R> {
    /// Number of the contact or section.
    pub fn place(&self) -> usize {
        match *self {
            Self::Section { section } => section,
            Self::Corner { place, .. } => place,
            Self::Impact { contact, .. }
            | Self::Accumulation { contact, .. }
            | Self::Release { contact }
            | Self::Graze { contact, .. }
            | Self::Cascade { contact, .. }
            | Self::Ambiguity { contact, .. } => contact,
        }
    }

    /// With numbers rounded to doubles.
    pub fn to_f64(&self) -> EventDetail<f64> {
        match *self {
            Self::Impact {
                contact,
                rate_before,
                rate_after,
                closes,
            } => EventDetail::Impact {
                contact,
                rate_before: rate_before.to_f64(),
                rate_after: rate_after.to_f64(),
                closes,
            },
            Self::Accumulation {
                contact,
                impacts,
                error,
            } => EventDetail::Accumulation {
                contact,
                impacts,
                error,
            },
            Self::Release { contact } => EventDetail::Release { contact },
            Self::Graze { contact, rate } => EventDetail::Graze {
                contact,
                rate: rate.to_f64(),
            },
            Self::Section { section } => EventDetail::Section { section },
            Self::Cascade {
                contact,
                impacts,
                error,
            } => EventDetail::Cascade {
                contact,
                impacts,
                error,
            },
            Self::Ambiguity { contact, other } => EventDetail::Ambiguity { contact, other },
            Self::Corner { kind, place, side } => EventDetail::Corner { kind, place, side },
        }
    }
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
