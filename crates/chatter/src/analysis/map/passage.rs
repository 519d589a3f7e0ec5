//! What happens between two points of an orbit.

use crate::flow::FlowError;
use core::fmt;

/// What happened on the way from a point to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Passage {
    /// Impacts on the way; for chatter sequences that were completed by a limit, those integrated one by one.
    pub impacts: u64,
    /// Infinite impact sequences on the way that ended in contact, be it for an instant, those of several contacts at once among them.
    pub accumulations: u64,
    /// Time from point to point; zero for a map without time.
    pub return_time: f64,
    /// Length of the latest flight that was completed on the way; NaN if there was none, or for a map without flights.
    pub flight_time: f64,
    /// How often on the way several impacts came at one instant and their order decided what came of them: beside such an orbit
    /// are others that leave it at once, and it has no derivative.
    pub ambiguities: u64,
    /// Whether something on the way may take points that differ to one and the same, so that a displacement much smaller than it
    /// was is nothing but rounding. Asked of tangent maps alone.
    pub forgets: bool,
}

impl Passage {
    /// Names of the quantities of a passage in expressions, in the order of [`values`](Self::values).
    pub const NAMES: [&'static str; 4] = ["impacts", "accumulations", "return_time", "flight_time"];

    /// Its quantities.
    pub fn values(&self) -> [f64; 4] {
        [
            self.impacts as f64,
            self.accumulations as f64,
            self.return_time,
            self.flight_time,
        ]
    }

    /// This passage followed by another: sums, and what holds at the end.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            impacts: self.impacts + next.impacts,
            accumulations: self.accumulations + next.accumulations,
            return_time: self.return_time + next.return_time,
            flight_time: if next.flight_time.is_nan() {
                self.flight_time
            } else {
                next.flight_time
            },
            ambiguities: self.ambiguities + next.ambiguities,
            forgets: self.forgets | next.forgets,
        }
    }
}

/// Why there is no next point.
#[derive(Clone, Debug, PartialEq)]
pub enum NoReturn {
    /// Not within the time allowed.
    Time {
        /// The time allowed.
        limit: f64,
    },
    /// Not within the impacts allowed.
    Impacts {
        /// The impacts allowed.
        limit: u64,
    },
    /// The time from look to look is no positive number at these parameters.
    Period {
        /// What it is.
        value: f64,
    },
    /// The next point is not finite.
    LeftDomain,
    /// The trajectory cannot go on.
    Failed(FlowError),
}

impl fmt::Display for NoReturn {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time { limit } => write!(out, "no return within a time of {limit}"),
            Self::Impacts { limit } => write!(out, "no return within {limit} impacts"),
            Self::Period { value } => write!(
                out,
                "the period is {value}: expected a positive finite number"
            ),
            Self::LeftDomain => write!(out, "the next point is not a finite number"),
            Self::Failed(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for NoReturn {}
