//! What can keep a border orbit from being found.

use super::normal_form::leading_order::ReleaseSection;
use crate::expressions::nearest;
use crate::flow::{FlowError, SystemError};
use crate::numerics::Real;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Why there is no border orbit, or none that the theory covers.
#[derive(Clone, Debug)]
pub enum BorderError {
    /// The model has nothing of this kind and name.
    Unknown {
        /// What was asked for.
        kind: Named,
        /// Its name.
        name: String,
        /// The nearest name that there is.
        nearest: Option<String>,
    },
    /// A border orbit has a contact that ends.
    NoContact,
    /// A release point is where gap, rate and acceleration vanish: that takes three states, time included.
    States {
        /// How many the model has.
        count: usize,
    },
    /// What the force looks up changes from piece to piece, as tables and whole parts do: border orbits take corners alone.
    LooksUp,
    /// At a parameter value there is no border orbit that the theory covers.
    Lacks {
        /// The parameter value.
        at: f64,
        /// What is missing there.
        what: Lack,
    },
    /// The parameter values to search are no interval.
    Range {
        /// Lower end asked for.
        low: f64,
        /// Upper end asked for.
        high: f64,
    },
    /// A section is not crossed between release and the first impact.
    NotCrossed {
        /// Its name, or what defines it.
        section: String,
    },
    /// There is no border near the value asked for.
    NoBorder {
        /// Lower end of what was searched.
        low: f64,
        /// Upper end of what was searched.
        high: f64,
        /// Where complete chatter ends without a border.
        breaks: Vec<Break>,
    },
    /// The model cannot be compiled.
    System(SystemError),
}

/// What border orbits need.
#[derive(Clone, Debug, PartialEq)]
pub enum Lack {
    /// A state with gap, rate and acceleration zero and positive jerk.
    Release,
    /// A chatter sequence that follows release.
    Chatter,
    /// A period of time, if it enters the equations, and of angles.
    Period,
    /// That no other orbit nearby returns to where it was released: else something is conserved, and border orbits come in families.
    Alone,
    /// A restitution at release in the open interval (0, 1), other than this one.
    Restitution(f64),
    /// A release point away from the corners of the force, on the sides where contacts rest along the model's own motion: it is on, or
    /// beyond, the one of this function.
    Smooth(String),
    /// A trajectory that goes on.
    Motion(FlowError),
}

impl Lack {
    /// That this is missing at a parameter value.
    pub(crate) fn at(self, at: impl Real) -> BorderError {
        BorderError::Lacks {
            at: at.to_f64(),
            what: self,
        }
    }
}

/// What of a model has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// A parameter.
    Parameter,
    /// A state.
    State,
    /// A section.
    Section,
}

impl BorderError {
    /// There is nothing of this name among those known.
    pub(crate) fn unknown<'a>(
        kind: Named,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::Unknown {
            kind,
            name: name.to_owned(),
            nearest: nearest(name, known),
        }
    }
}

/// A parameter value where the verdict complete or incomplete changes without a border orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Break {
    /// The parameter value.
    pub value: f64,
    /// What happens there.
    pub cause: BreakCause,
}

/// Why the verdict changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BreakCause {
    /// An impact before or within the sequence is a graze: on one side it does not happen. The first impact has number 0.
    Graze {
        /// Number of the impact.
        impact: usize,
        /// Its rate before the impact, negative and small.
        rate: f64,
    },
    /// A chatter sequence ends at a release point, but not at the one where the orbit began.
    Elsewhere,
    /// The first chatter sequence has so many impacts on one side and ends in flight. On the other side it has fewer: too
    /// few for a chatter sequence, and a later one is the first.
    Short {
        /// Impacts in the shortest sequence that counts.
        impacts: usize,
    },
    /// On one side there is no release point, or no chatter follows it within the long flights allowed.
    NoChatter,
    /// On one side the motion after release cannot be followed: it leaves the domain of the equations, or these do not determine it.
    Unfollowed,
    /// The sequence jumps for another reason, or depends on the parameter too steeply for a border to be resolved.
    Jump,
}

/// A parameter value to read: ten digits, and no row of zeros.
pub(crate) struct ParameterValue(pub f64);

impl fmt::Display for ParameterValue {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded: f64 = format!("{:.9e}", self.0).parse().unwrap_or(self.0);
        if rounded == 0.0 || (1e-5..1e10).contains(&rounded.abs()) {
            write!(out, "{rounded}")
        } else {
            write!(out, "{rounded:e}")
        }
    }
}

impl fmt::Display for Break {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "at {} ", ParameterValue(self.value))?;
        match self.cause {
            BreakCause::Graze { impact, rate } => {
                match impact {
                    0 => write!(out, "the first impact")?,
                    _ => write!(out, "impact {} after release", impact + 1)?,
                }
                write!(out, " is a graze (rate {rate:.1e})")
            }
            BreakCause::Elsewhere => {
                out.write_str("chatter that begins at one release point ends at another")
            }
            BreakCause::Short { impacts } => write!(
                out,
                "a first sequence of {impacts} impacts, which ends in flight, loses one of them and is no more taken \
                 for chatter"
            ),
            BreakCause::NoChatter => out.write_str(
                "the long flights before chatter become too many, or there is no release",
            ),
            BreakCause::Unfollowed => {
                out.write_str("the motion after release can no longer be followed to its chatter")
            }
            BreakCause::Jump => out.write_str("the impact sequence jumps"),
        }
    }
}

impl fmt::Display for Lack {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
                Self::Release => out.write_str(
                    "no release point was found: no state with gap, rate and acceleration zero and positive jerk",
                ),
                Self::Chatter => out.write_str("no chatter follows the release point"),
                Self::Period => out.write_str(
                    "the equations have no period in time, or in an angle that they depend on; a border orbit is periodic",
                ),
                Self::Alone => out.write_str(
                    "orbits return to wherever they are released: something is conserved, and border orbits come in \
                     families; fix what is conserved, such as the amplitude of a forcing that two states make, by \
                     writing it as a function of time",
                ),
                Self::Restitution(value) => write!(
                    out,
                    "the restitution at release is {value}; a border orbit needs one between 0 and 1, both excluded"
                ),
                Self::Smooth(corner) => write!(
                    out,
                    "the corner `{corner}` of the force is at the release point, or is passed before it; a border orbit needs \
                     equations that are smooth there"
                ),
                Self::Motion(error) => error.fmt(out),
            }
    }
}

/// More places than this are not listed in a message.
const BREAKS_TOLD: usize = 3;

impl fmt::Display for BorderError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown {
                kind,
                name,
                nearest,
            } => {
                let kind = match kind {
                    Named::Parameter => "parameter",
                    Named::State => "state",
                    Named::Section => "section",
                };
                write!(out, "the model has no {kind} `{name}`")?;
                (nearest.iter()).try_for_each(|name| write!(out, "; did you mean `{name}`?"))
            }
            Self::NoContact => write!(out, "border orbits need a contact; this model has none"),
            Self::States { count } => write!(
                out,
                "border orbits need a point where gap, rate and acceleration vanish, which takes three states, time \
                 included; this model has {count}"
            ),
            Self::LooksUp => out.write_str(
                "border orbits are not looked for where the force depends on a table or a whole part; `continue` follows orbits \
                 to their chatter borders there",
            ),
            Self::Lacks { at, what } => {
                write!(out, "with the parameter at {} {what}", ParameterValue(*at))
            }
            Self::Range { low, high } => write!(
                out,
                "no parameter values between {} and {}: the range must go from a smaller to a larger finite number",
                ParameterValue(*low),
                ParameterValue(*high)
            ),
            Self::NotCrossed { section } => write!(
                out,
                "the section {section} is not crossed between release and the first impact"
            ),
            Self::NoBorder { low, high, breaks } => {
                let (low, high) = (ParameterValue(*low), ParameterValue(*high));
                write!(out, "there is no border between {low} and {high}")?;
                (breaks.iter().take(BREAKS_TOLD)).try_for_each(|at| write!(out, "; {at}"))?;
                match breaks.len().saturating_sub(BREAKS_TOLD) {
                    0 => Ok(()),
                    more => write!(out, "; and {more} more such places"),
                }
            }
            Self::System(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for BorderError {}

impl From<ReleaseSection> for BorderError {
    fn from(ReleaseSection { state, level }: ReleaseSection) -> Self {
        let section = format!("{state} = {level}");
        Self::NotCrossed { section }
    }
}

impl From<SystemError> for BorderError {
    fn from(error: SystemError) -> Self {
        Self::System(error)
    }
}
