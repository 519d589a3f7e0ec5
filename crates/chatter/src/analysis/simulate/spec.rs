//! What is to be simulated, in a form that can be stored.

use super::place::UnknownPlace;
use super::result::Event;
use super::tolerance::{WrongTolerance, check_tolerance};
use crate::flow::{EventKind, Place};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real};
use core::fmt;
use serde::{Deserialize, Serialize};

/// How long a trajectory is followed, and what is kept of it. Model, parameters and initial state come from the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// The run ends at this time at the latest.
    pub until: DoubleDouble,
    /// The run ends with this impact at the latest.
    pub impacts: u64,
    /// What else ends the run.
    pub stops: Vec<Stop>,
    /// Relative truncation error allowed a step; rounding level where that is larger.
    pub tolerance: f64,
    /// At which times the state is kept; each gives a list of samples of its own.
    pub sampling: Vec<Sampling>,
}

impl Spec {
    /// More impacts than this are rarely meant: a trajectory that rattles for ever is to end.
    pub const IMPACT_BUDGET: u64 = 1_000_000;

    /// Up to a time, to rounding error, within the usual impact budget, without samples.
    pub fn until(time: impl Into<DoubleDouble>) -> Self {
        Self {
            until: time.into(),
            impacts: Self::IMPACT_BUDGET,
            stops: Vec::new(),
            tolerance: 0.0,
            sampling: Vec::new(),
        }
    }

    /// Checks the specification against the model and the time where the run starts, and resolves its names.
    pub(super) fn targets(&self, model: &Model, start: DoubleDouble) -> Result<Targets, SpecError> {
        if self.impacts == 0 {
            return Err(SpecError::NoImpacts);
        }
        check_tolerance(self.tolerance).map_err(SpecError::Tolerance)?;
        for sampling in &self.sampling {
            match sampling {
                Sampling::Dense { per_step: 0 } => return Err(SpecError::NoSamples),
                Sampling::Every(step)
                | Sampling::Smooth {
                    resolution: step, ..
                } if !(step.high() > 0.0 && step.high().is_finite()) => {
                    return Err(SpecError::SampleStep { value: step.high() });
                }
                Sampling::At(times) => {
                    let mut before = start;
                    for (place, &time) in times.iter().enumerate() {
                        // A start that a run knows in doubles may be a rounding beyond what was written for it.
                        let is_start = place == 0 && time.high() == start.high();
                        if time < before && !is_start || !time.high().is_finite() {
                            return Err(SpecError::SampleTime {
                                value: time.high(),
                                before: before.high(),
                            });
                        }
                        before = time;
                    }
                }
                _ => {}
            }
        }
        let mut targets = Vec::new();
        for stop in &self.stops {
            if let Stop::Event(target) = stop {
                let place = |name: &String| target.kind.place(model, name);
                targets.push(OpenTarget {
                    place: (target.at.as_ref().map(place).transpose())
                        .map_err(SpecError::UnknownPlace)?,
                    left: target.count.max(1),
                    target: target.clone(),
                });
            }
        }
        Ok(Targets(targets))
    }
}

/// What ends a run before its time is over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// A contact is closed and nothing changes any more, for ever. Never reached where equations depend on time.
    Rest,
    /// An event has happened often enough.
    Event(EventTarget),
}

/// The `count`-th event of a kind, at one contact or section or at any.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventTarget {
    /// Which kind.
    pub kind: EventKind,
    /// Name of the contact or section, if only events there count.
    pub at: Option<String>,
    /// How many are waited for; zero means one.
    pub count: u64,
}

impl fmt::Display for EventTarget {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.count > 1 {
            write!(out, "{} ", Ordinal(self.count))?;
        }
        write!(out, "{}", self.kind)?;
        match (&self.at, self.kind) {
            (Some(name), EventKind::Section) => write!(out, " `{name}`"),
            (Some(name), EventKind::Release) => write!(out, " from {name}"),
            (Some(name), _) => write!(out, " at {name}"),
            (None, _) => Ok(()),
        }
    }
}

struct Ordinal(u64);

impl fmt::Display for Ordinal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let suffix = match (self.0 % 10, self.0 % 100) {
            (1, rest) if rest != 11 => "st",
            (2, rest) if rest != 12 => "nd",
            (3, rest) if rest != 13 => "rd",
            _ => "th",
        };
        write!(out, "{}{suffix}", self.0)
    }
}

/// At which times the state is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// At equal fractions of each integration step, so many a step. Where an event ends the step there are two samples:
    /// the state before and after it.
    Dense {
        /// Samples in a step.
        per_step: u32,
    },
    /// As densely as a picture needs: many a step, but few in steps that are not much longer than `resolution`; and two at
    /// each event. Of a long run the latest half million samples at least are kept.
    Smooth {
        /// Intervals shorter than this are not seen.
        resolution: DoubleDouble,
        /// Only steps that reach into this interval of time are sampled.
        window: Option<(DoubleDouble, DoubleDouble)>,
    },
    /// At equal intervals of time from the start; an event that falls on such a time counts as not yet happened.
    Every(DoubleDouble),
    /// At these times, none before the start and none before the one in front of it; an event that falls on such a time
    /// counts as not yet happened.
    At(Vec<DoubleDouble>),
}

/// What is wrong with a specification.
#[derive(Clone, Debug, PartialEq)]
pub enum SpecError {
    /// The end does not come after the start.
    Until {
        /// Where the run starts.
        start: f64,
        /// Where it should end.
        until: f64,
    },
    /// A budget of no impacts.
    NoImpacts,
    /// A tolerance that is no small positive number or zero.
    Tolerance(WrongTolerance),
    /// Dense sampling without samples.
    NoSamples,
    /// A sampling interval that is no positive number.
    SampleStep {
        /// What was asked for.
        value: f64,
    },
    /// A time of sampling that is not finite, or lies before the start or the time in front of it.
    SampleTime {
        /// What was asked for.
        value: f64,
        /// The start, or the time in front of it.
        before: f64,
    },
    /// The model has no such contact or section.
    UnknownPlace(UnknownPlace),
}

impl fmt::Display for SpecError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Until { start, until } => write!(
                out,
                "a run from time {start} cannot end at time {until}: the end must be finite and lie after the start"
            ),
            Self::NoImpacts => write!(out, "a run must be allowed at least one impact"),
            Self::Tolerance(error) => error.fmt(out),
            Self::NoSamples => write!(out, "dense sampling needs at least one sample a step"),
            Self::SampleStep { value } => write!(
                out,
                "a sampling interval of {value} makes no sense: expected a positive number"
            ),
            Self::SampleTime { value, before } => write!(
                out,
                "no sample can be taken at time {value}: expected times in order, none below {before}"
            ),
            Self::UnknownPlace(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for SpecError {}

/// The event targets of a run, counted down.
pub(super) struct Targets(Vec<OpenTarget>);

struct OpenTarget {
    target: EventTarget,
    place: Option<usize>,
    left: u64,
}

impl Targets {
    /// The target that this event completes.
    pub(super) fn reached_by<R: Real>(&mut self, event: Option<&Event<R>>) -> Option<EventTarget> {
        let event = event?;
        let place = event.detail.place().map(Place::index);
        for open in &mut self.0 {
            if open.target.kind == event.kind && (open.place.is_none() || open.place == place) {
                open.left -= 1;
                if open.left == 0 {
                    return Some(open.target.clone());
                }
            }
        }
        None
    }
}
