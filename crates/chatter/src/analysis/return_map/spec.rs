//! Where a flow is looked at, in a form that can be stored.

use crate::analysis::simulate::{EventKind, UnknownPlace, WrongTolerance};
use crate::expressions::ParseError;
use crate::flow::SystemError;
use core::fmt;
use serde::{Deserialize, Serialize};

/// What makes a map of a flow. Model, parameters and initial state come from the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReturnSpec {
    /// Where the flow is looked at.
    pub sampling: Sampling,
    /// A return may take this much time; if it takes longer there is none.
    pub longest_return: f64,
    /// A return may take this many impacts; if it takes more there is none.
    pub most_impacts: u64,
    /// Relative truncation error allowed a step; rounding level where that is larger.
    pub tolerance: f64,
}

impl ReturnSpec {
    /// Ample where the unit of time is that of the motion, and over within a fraction of a second.
    pub const LONGEST_RETURN: f64 = 1e4;
    /// Ample for any return with incomplete chatter.
    pub const MOST_IMPACTS: u64 = 100_000;

    /// To rounding error and with the usual patience.
    pub fn new(sampling: Sampling) -> Self {
        Self {
            sampling,
            longest_return: Self::LONGEST_RETURN,
            most_impacts: Self::MOST_IMPACTS,
            tolerance: 0.0,
        }
    }

    /// To rounding error, at the crossings of a section in its direction.
    pub fn section(name: &str) -> Self {
        Self::new(Sampling::Event {
            kind: EventKind::Section,
            at: Some(name.to_owned()),
        })
    }
}

/// At which instants a flow is looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// At events of a kind, just after them.
    Event {
        /// Which kind.
        kind: EventKind,
        /// Name of the contact or section, if only events there count.
        at: Option<String>,
    },
    /// At times that are multiples of a period from the start.
    Stroboscopic {
        /// The period, an expression in parameters.
        period: String,
    },
}

/// Why a model has no such return map.
#[derive(Clone, Debug)]
pub enum ReturnMapError {
    /// The model cannot be compiled.
    System(SystemError),
    /// The model has no such contact or section.
    UnknownPlace(UnknownPlace),
    /// The stroboscopic period is no expression.
    Period {
        /// Its text.
        text: String,
        /// What is wrong with it.
        error: ParseError,
    },
    /// The stroboscopic period is no positive number, or depends on the state.
    PeriodValue {
        /// Its text.
        text: String,
        /// Its value at the model's parameters; NaN where it depends on the state.
        value: f64,
    },
    /// The time a return may take is no positive number.
    LongestReturn {
        /// What was asked for.
        value: f64,
    },
    /// A return is allowed no impact.
    NoImpacts,
    /// A tolerance that is no small positive number or zero.
    Tolerance(WrongTolerance),
}

impl fmt::Display for ReturnMapError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => error.fmt(out),
            Self::UnknownPlace(error) => error.fmt(out),
            Self::Period { text, error } => write!(out, "the period `{text}`: {error}"),
            Self::PeriodValue { text, value } if value.is_nan() => write!(
                out,
                "the period `{text}` has no value: expected an expression in parameters"
            ),
            Self::PeriodValue { text, value } => write!(
                out,
                "the period `{text}` is {value}: expected a positive number"
            ),
            Self::LongestReturn { value } => write!(
                out,
                "a return cannot be allowed a time of {value}: expected a positive number"
            ),
            Self::NoImpacts => write!(out, "a return must be allowed at least one impact"),
            Self::Tolerance(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for ReturnMapError {}
