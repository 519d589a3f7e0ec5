//! What can be wrong with the specification of a diagram.

use super::spec::range::Range;
use crate::analysis::map::PhaseLost;
use crate::expressions::{ParseError, nearest};
use core::fmt;

/// Why a diagram cannot begin.
#[derive(Clone, Debug, PartialEq)]
pub enum DiagramError {
    /// There must be one or two swept parameters.
    SweepCount {
        /// How many there are.
        count: usize,
    },
    /// The map has no such parameter.
    UnknownParameter {
        /// The name given.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// The map has no such coordinate to start elsewhere.
    UnknownInitial {
        /// The name given.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// A parameter is swept twice.
    SweptTwice {
        /// Its name.
        name: String,
    },
    /// A sweep without values.
    NoValues {
        /// The swept parameter.
        name: String,
    },
    /// A sweep's ends are not finite, not in order, or the same; or not positive and spaced by ratios.
    Ends {
        /// The sweep.
        range: Range,
    },
    /// More rows than can be counted.
    TooManyRows,
    /// Nothing is observed.
    NothingObserved,
    /// An observed quantity is no expression.
    Observable {
        /// Its text.
        text: String,
        /// What is wrong with it.
        error: ParseError,
    },
    /// Two columns of the result would have the same name.
    NameTaken {
        /// The name.
        name: String,
    },
    /// A parameter that is swept is called as a column of the result is.
    SweptNameTaken {
        /// The name.
        name: String,
    },
    /// No sample is kept.
    KeepsNothing,
    /// More samples of an orbit than memory holds.
    KeepsTooMuch {
        /// How many were asked for.
        keep: u64,
        /// How many there can be.
        most: u64,
    },
    /// Samples of every zeroth return.
    EveryZeroth,
    /// A state that is carried cannot start at a swept initial value.
    CarriedInitial {
        /// The coordinate whose initial value is swept.
        name: String,
    },
    /// A coordinate whose initial value is swept cannot be drawn at random.
    SweptAndDrawn {
        /// Its name.
        name: String,
    },
    /// A carried state would lose the phase of a forcing.
    PhaseLost(PhaseLost),
    /// Chunks without values.
    EmptyChunks,
    /// Periods up to zero.
    NoPeriods,
    /// A period tolerance that is no small positive number.
    PeriodTolerance {
        /// What was asked for.
        value: f64,
    },
    /// Random starts without a start, or without bounds.
    NoStarts,
    /// The map has no such coordinate.
    UnknownCoordinate {
        /// The name given.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// Bounds that are not finite or not in order.
    Bounds {
        /// The coordinate.
        name: String,
        /// Lower bound.
        from: f64,
        /// Upper bound.
        to: f64,
    },
}

impl DiagramError {
    /// The name that is probably meant, where one is unknown.
    pub fn suggestion(&self) -> Option<String> {
        match self {
            Self::UnknownParameter { name, known }
            | Self::UnknownInitial { name, known }
            | Self::UnknownCoordinate { name, known } => {
                nearest(name, known.iter().map(String::as_str))
            }
            _ => None,
        }
    }
}

impl fmt::Display for DiagramError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SweepCount { count } => write!(
                out,
                "{count} quantities are swept: expected one, or two for a map over both"
            ),
            Self::UnknownParameter { name, known } => {
                write!(out, "there is no parameter `{name}` to sweep")?;
                list(out, known)
            }
            Self::UnknownInitial { name, known } => {
                write!(
                    out,
                    "there is no state `{name}` whose initial value could be swept"
                )?;
                list(out, known)
            }
            Self::SweptTwice { name } => write!(out, "`{name}` is swept twice"),
            Self::NoValues { name } => {
                write!(
                    out,
                    "the sweep of `{name}` has no values: expected at least one"
                )
            }
            Self::Ends { range } => {
                let Range {
                    from, to, count, ..
                } = range;
                write!(out, "the sweep of `{}` from {from} to {to} ", range.name())?;
                if !(from.is_finite() && to.is_finite()) {
                    write!(out, "has an end that is not finite")
                } else if from > to {
                    write!(
                        out,
                        "is reversed: give the smaller value first (to carry the state downwards, start with carry:down)"
                    )
                } else if from == to {
                    write!(out, "is empty: {count} values need two different ends")
                } else {
                    write!(out, "cannot be spaced by ratios: expected positive ends")
                }
            }
            Self::TooManyRows => write!(out, "the sweep has more rows than can be counted"),
            Self::NothingObserved => write!(out, "nothing is observed: name at least one quantity"),
            Self::Observable { text, error } => write!(out, "cannot observe `{text}`: {error}"),
            Self::NameTaken { name } => write!(
                out,
                "two columns of the result would be called `{name}`: give the observed quantity another name"
            ),
            Self::SweptNameTaken { name } => write!(
                out,
                "the result has a column `{name}` beside that of the parameter `{name}`: give the parameter another name in the model"
            ),
            Self::KeepsNothing => write!(out, "no sample is kept: expected at least one"),
            Self::KeepsTooMuch { keep, most } => write!(
                out,
                "{keep} samples of each orbit are more than memory holds: expected {most} at most"
            ),
            Self::EveryZeroth => write!(
                out,
                "a sample every 0 returns makes no sense: expected 1 or more"
            ),
            Self::CarriedInitial { name } => write!(
                out,
                "a carried state starts where another orbit ended, not at the swept initial value of `{name}`"
            ),
            Self::SweptAndDrawn { name } => {
                write!(out, "`{name}` cannot be both drawn at random and swept")
            }
            Self::PhaseLost(lost) => lost.fmt(out),
            Self::EmptyChunks => write!(
                out,
                "a state cannot be carried through chunks of 0 values: expected 1 or more"
            ),
            Self::NoPeriods => write!(out, "the longest period must be at least 1"),
            Self::PeriodTolerance { value } => write!(
                out,
                "a period tolerance of {value} makes no sense: expected a number above 0 and below 1"
            ),
            Self::NoStarts => write!(
                out,
                "random starts need at least one start and bounds for at least one coordinate"
            ),
            Self::UnknownCoordinate { name, known } => {
                write!(out, "there is no state `{name}` to draw at random")?;
                list(out, known)
            }
            Self::Bounds { name, from, to } => write!(
                out,
                "`{name}` cannot be drawn between {from} and {to}: expected two finite numbers, the smaller first"
            ),
        }
    }
}

fn list(out: &mut fmt::Formatter<'_>, known: &[String]) -> fmt::Result {
    match known.split_last() {
        None => write!(out, ": there are none"),
        Some((only, [])) => write!(out, ": there is `{only}`"),
        Some((last, rest)) => write!(out, ": there are `{}` and `{last}`", rest.join("`, `")),
    }
}

impl core::error::Error for DiagramError {}
