//! What the coordinates of points are, and what carrying a point to other parameters has to keep.

use core::fmt;

/// What a coordinate is.
#[derive(Clone, Debug, PartialEq)]
pub enum CoordinateKind {
    /// A number.
    Plain,
    /// A number of which only the remainder after whole periods matters.
    Phase {
        /// The period.
        period: f64,
    },
    /// A number of which nothing depends on how large it is: how far something has come, or the angle of one of two wheels
    /// of which only the difference matters.
    Idle {
        /// Coordinates of which only the difference from so many times this one matters.
        others: Vec<(usize, f64)>,
    },
}

/// The end of an orbit that goes on at other parameters.
#[derive(Clone, Copy, Debug)]
pub struct Carry<'a> {
    /// The point at which the orbit started.
    pub origin: &'a [f64],
    /// The point at which it ended, on the image of the map.
    pub end: &'a [f64],
    /// The parameters of the orbit.
    pub before: &'a [f64],
    /// The parameters at which it goes on.
    pub after: &'a [f64],
}

/// Why points cannot be carried from parameter to parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PhaseLost {
    /// The coordinate that tells the phase.
    pub coordinate: String,
    /// The parameters of which its period or periods are functions.
    pub parameters: Vec<String>,
}

impl fmt::Display for PhaseLost {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            coordinate,
            parameters,
        } = self;
        write!(
            out,
            "a state cannot be carried from one value of `{}` to the next: the phases of what depends on `{coordinate}` \
             change with it, and no one value of `{coordinate}` has them all as they were",
            parameters.join("`, `")
        )
    }
}

impl core::error::Error for PhaseLost {}
