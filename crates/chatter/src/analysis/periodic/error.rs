//! Why there is no periodic orbit, or none was found.

use super::branch::SpecialKind;
use crate::flow::{FlowError, SystemError};
use crate::numerics::Complex;
use core::fmt;

/// What is wrong with a question about periodic orbits, or has no answer.
#[derive(Clone, Debug)]
pub enum PeriodicError {
    /// The model cannot be compiled.
    System(SystemError),
    /// No trajectory starts from the initial state.
    Start(FlowError),
    /// The trajectory that is to settle ends.
    Ended(FlowError),
    /// A period was given, but nothing in the equations depends on time.
    Autonomous,
    /// The equations depend on time in a way whose period is not known.
    NoPeriod,
    /// The equations never return to what they were, at these parameters, or the period is no positive number.
    BadPeriod {
        /// Its value.
        value: f64,
    },
    /// The period given is no multiple of that of the equations.
    OtherPeriod {
        /// What was given.
        value: f64,
        /// The period of the equations.
        own: f64,
    },
    /// The equations are not what they were after the period that was given.
    NoRepeat {
        /// What was given.
        value: f64,
    },
    /// A curve is asked for in a range that its point is not in.
    OutOfRange {
        /// The parameter at the point.
        value: f64,
        /// The range.
        range: (f64, f64),
    },
    /// A special point is not where it was told to be: it is of another model, or of other parameters.
    NotThere {
        /// Which kind.
        kind: SpecialKind,
        /// How far off the nearest solution of its equations is, against their size.
        off: f64,
    },
    /// What solves the equations of a special point is none of its kind.
    NotOfKind {
        /// Which kind.
        kind: SpecialKind,
        /// The multipliers there.
        multipliers: Vec<Complex>,
    },
    /// A function to be watched is no expression in states and parameters.
    BadMonitor {
        /// What was given.
        text: String,
    },
    /// A function to be watched has no state and no parameter in it: it vanishes nowhere, or everywhere.
    ConstantMonitor {
        /// What was given.
        text: String,
    },
    /// The trajectory comes to rest.
    Equilibrium {
        /// When.
        time: f64,
    },
    /// The trajectory dies out under a forcing, at rest where a contact is touched and nothing holds it closed or open.
    DiesOut {
        /// That contact.
        contact: String,
    },
    /// The trajectory moves on, and nothing happens that a return could be told by.
    Eventless {
        /// Since when.
        time: f64,
    },
    /// Periodic orbits lie beside each other, of one period or of different ones.
    OneOfMany {
        /// The least modulus of the multipliers: where it is one nothing dies out.
        least: f64,
    },
    /// The equations of a periodic orbit are solved by an equilibrium.
    AtRest,
    /// The trajectory has not come near to where it was.
    NotSettled {
        /// How long it was followed.
        time: f64,
        /// The nearest return, in parts of the state's size.
        nearest: f64,
    },
    /// The trajectory takes ever shorter steps, as one that grows without bound does.
    EverShorterSteps {
        /// Up to where it was followed.
        time: f64,
        /// In so many of them.
        steps: usize,
    },
    /// The trajectory has not come back to where it was but for so much, and no orbit was found beside it.
    NotRepeated {
        /// Its nearest return, in parts of the state's size.
        nearest: f64,
        /// How Newton's method ended from there.
        how: String,
    },
    /// Newton's method did not converge.
    NoConvergence {
        /// How it ended.
        how: String,
    },
    /// Motion beside the orbit that was found leaves it by more than numbers can say.
    Boundless,
    /// There are no curves in two parameters of special points of this kind.
    NoCurve {
        /// Which kind.
        kind: SpecialKind,
    },
    /// An event of a kind that derivatives do not follow.
    Unfollowed {
        /// What it is.
        what: String,
    },
    /// Contacts close at one instant, which of them goes first is a matter of how motion beside the orbit is displaced, and derivatives
    /// depend on it.
    OrderMatters {
        /// One of them.
        contact: String,
    },
    /// Surfaces at which formulas change their form are crossed at one instant, which of them goes first is a matter of how motion beside the
    /// orbit is displaced, and derivatives depend on it.
    OrderOfCorners {
        /// One of them.
        corner: String,
    },
    /// The observer broke off.
    Interrupted,
}

impl fmt::Display for PeriodicError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => error.fmt(out),
            Self::Start(error) | Self::Ended(error) => error.fmt(out),
            Self::Autonomous => write!(
                out,
                "a period was given, but the equations do not depend on time: the period of an orbit is found, not given"
            ),
            Self::NoPeriod => write!(
                out,
                "the equations depend on time, and their period is not known"
            ),
            Self::BadPeriod { value } => {
                write!(out, "the period is {value}: expected a positive number")
            }
            Self::OtherPeriod { value, own } => write!(
                out,
                "the period is given as {value}, but the equations repeat after {own}"
            ),
            Self::NoRepeat { value } => write!(
                out,
                "the equations do not repeat after the period given, {value}: with equal states they differ then. What grows \
                 with time besides, as an angle that is driven, must be told relative to that"
            ),
            Self::OutOfRange {
                value,
                range: (low, high),
            } => write!(
                out,
                "the special point is at {value}, outside the range from {low} to {high} that its curve is asked for in"
            ),
            Self::NotThere { kind, off } => write!(
                out,
                "there is no {} where the point is told to be: the nearest is {off:.1e} of its size away",
                kind.name().replace('_', " ")
            ),
            Self::NotOfKind { kind, multipliers } => {
                let largest = multipliers.first().map_or(f64::NAN, |m| m.modulus());
                write!(
                    out,
                    "the point is told to be a {}, and no multiplier there says so: the largest is {largest:.6}",
                    kind.name().replace('_', " ")
                )
            }
            Self::BadMonitor { text } => {
                write!(out, "`{text}` is no expression in states and parameters")
            }
            Self::ConstantMonitor { text } => write!(
                out,
                "`{text}` is a constant: it has no zeros along a branch, or is zero everywhere"
            ),
            Self::Equilibrium { time } => write!(
                out,
                "nothing happens after time {time:.6}: the trajectory comes to rest, and an equilibrium is no periodic orbit"
            ),
            Self::DiesOut { contact } => write!(
                out,
                "the motion dies out: what is left is rest where contact `{contact}` is touched without a force, and beside that there is no one \
                 derivative"
            ),
            Self::Eventless { time } => write!(
                out,
                "nothing happens after time {time:.6}, and the motion goes on: nothing is met that a return could be told by"
            ),
            Self::OneOfMany { .. } => write!(
                out,
                "the motion is periodic, and so is all motion beside it: nothing tells one orbit from the others"
            ),
            Self::AtRest => write!(
                out,
                "no periodic orbit was found: Newton's method leads to an equilibrium, which is none"
            ),
            Self::NotSettled { time, nearest } => write!(
                out,
                "the trajectory has not settled to a periodic orbit by time {time:.6}: its nearest return is off by \
                 {nearest:.1e} of its size"
            ),
            Self::EverShorterSteps { time, steps } => write!(
                out,
                "the trajectory takes ever shorter steps, {steps} by time {time:.6}: does the motion grow without bound?"
            ),
            Self::NotRepeated { nearest, how } => write!(
                out,
                "the motion has not repeated: its nearest return is off by {nearest:.1e} of its size, and no periodic orbit was found \
                 from there: {how}"
            ),
            Self::NoConvergence { how } => {
                write!(out, "no periodic orbit was found: {how}")
            }
            Self::Boundless => write!(
                out,
                "the orbit that was found is so unstable that its multipliers exceed all numbers: the motion is chaotic"
            ),
            Self::NoCurve { kind } => {
                let told = |kind: SpecialKind| format!("`{}`", kind.name());
                let all = SpecialKind::ALL.into_iter();
                let others: Vec<String> = all.filter(|kind| kind.has_curve()).map(told).collect();
                let others = others.join(", ");
                write!(
                    out,
                    "curves in two parameters are followed of special points of the kinds {others}, and not of {}",
                    told(*kind)
                )
            }
            Self::Unfollowed { what } => write!(
                out,
                "the orbit goes through {what}, which is not followed yet"
            ),
            Self::OrderMatters { contact } => write!(
                out,
                "several contacts close at one instant, `{contact}` among them, and beside the orbit which of them goes first depends on the \
                 direction of the displacement: there is no one derivative"
            ),
            Self::OrderOfCorners { corner } => write!(
                out,
                "several surfaces are crossed at one instant, {corner} among them, and beside the orbit which of them goes first depends on the \
                 direction of the displacement: there is no one derivative"
            ),
            Self::Interrupted => write!(out, "broken off"),
        }
    }
}

impl core::error::Error for PeriodicError {}
