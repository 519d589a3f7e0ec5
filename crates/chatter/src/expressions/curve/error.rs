//! Why knots make no curve.

use super::CurveKind;
use core::fmt;

/// One of the two lists of numbers that a curve is made from.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Axis {
    /// The arguments.
    X,
    /// The values.
    Y,
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
        })
    }
}

/// What is wrong with the knots of a curve. Places are counted from 0, in messages from 1.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CurveError {
    /// Not as many values as arguments.
    Lengths {
        /// How many arguments.
        x: usize,
        /// How many values.
        y: usize,
    },
    /// Fewer knots than a curve of this kind takes.
    TooFew {
        /// How many.
        knots: usize,
        /// The kind.
        kind: CurveKind,
    },
    /// More knots than are kept.
    TooMany {
        /// How many.
        knots: usize,
    },
    /// An infinity, or not a number.
    NotFinite {
        /// In which list.
        axis: Axis,
        /// Where in it.
        index: usize,
        /// The value.
        value: f64,
    },
    /// An argument that is no larger than the one before it.
    NotIncreasing {
        /// Its place.
        index: usize,
        /// Its value.
        value: f64,
        /// The one before it.
        before: f64,
    },
    /// The last value of a periodic curve is not its first.
    PeriodNotClosed {
        /// The first value.
        first: f64,
        /// The last.
        last: f64,
        /// The place of the last.
        index: usize,
    },
    /// Something outside of a curve that has no outside.
    OutsideOfPeriodic,
    /// Slopes at the ends of a curve that takes none.
    SlopesOfKind {
        /// Its kind.
        kind: CurveKind,
    },
    /// A slope at an end that is not finite.
    SlopeNotFinite {
        /// 0 for the first end, 1 for the last.
        end: usize,
        /// The slope.
        value: f64,
    },
    /// Knots so close, or so far from each other, that the polynomial from one to the next has no finite coefficients.
    Overflow {
        /// Place of the knot where it begins.
        index: usize,
    },
}

impl core::error::Error for CurveError {}

/// A number with few zeros before or after its digits.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        let is_plain = size == 0.0 || (1e-5..1e9).contains(&size) || !size.is_finite();
        if is_plain {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

impl fmt::Display for CurveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Lengths { x, y } => write!(f, "there are {x} values of x and {y} of y"),
            Self::TooFew { knots, kind } => {
                let least = kind.least_knots();
                write!(
                    f,
                    "a {kind} table takes {least} knots at least, not {knots}"
                )
            }
            Self::TooMany { knots } => {
                write!(
                    f,
                    "a table takes {} knots at most, not {knots}",
                    super::MOST_KNOTS
                )
            }
            Self::NotFinite { axis, index, value } => {
                write!(f, "value {} of {axis} is {value}", index + 1)
            }
            Self::NotIncreasing { value, before, .. } if value == before => {
                write!(f, "x is {} twice", Short(value))
            }
            Self::NotIncreasing { value, before, .. } => {
                let (value, before) = (Short(value), Short(before));
                write!(f, "x does not increase: {value} follows {before}")
            }
            Self::PeriodNotClosed { first, last, .. } => {
                let (first, last) = (Short(first), Short(last));
                write!(
                    f,
                    "a periodic table begins at y = {first} and ends at {last}"
                )
            }
            Self::OutsideOfPeriodic => write!(f, "a periodic table has no outside"),
            Self::SlopesOfKind { kind } => write!(f, "a {kind} table takes no slopes"),
            Self::SlopeNotFinite { end, value } => {
                write!(
                    f,
                    "the slope at the {} end is {value}",
                    ["first", "last"][end.min(1)]
                )
            }
            Self::Overflow { index } => write!(
                f,
                "from knot {} on the numbers are too large, or too close, to compute with",
                index + 1
            ),
        }
    }
}
