//! What diagram is wanted, in a form that can be stored.

pub(super) mod check;
pub(super) mod observable;
pub(super) mod random;
pub(super) mod range;

use self::range::Range;
use serde::{Deserialize, Serialize};

/// An orbit diagram of a map. Parameters that are not swept are those of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// One or two swept parameters or initial values. The first one varies fastest.
    pub sweeps: Vec<Range>,
    /// What is sampled at the points of an orbit.
    pub observe: Vec<Observed>,
    /// So many samples are passed over before any is kept.
    pub transient: u64,
    /// So many samples are kept and classified.
    pub keep: u64,
    /// Every so many returns of the map there is a sample.
    pub every: u64,
    /// Where orbits start.
    pub start: Start,
    /// How many neighbouring parameter values a carried state is carried through before it starts afresh; none for the
    /// whole range. Chunks are computed side by side, so this is part of the specification. Where an orbit starts afresh
    /// it forgets which attractor it was on: over less than the whole range hysteresis is cut to pieces.
    pub chunk: Option<u64>,
    /// Periods are looked for up to this one.
    pub longest_period: u64,
    /// Samples a period apart may differ by this much, relative to the largest sample of the orbit.
    pub period_tolerance: f64,
    /// Whether samples are kept in the result.
    pub record: Record,
    /// Whether the largest Lyapunov exponent is computed.
    pub exponent: Exponent,
}

impl Spec {
    /// Found in any diagram that is looked at; longer ones are rare and need many more samples.
    pub const LONGEST_PERIOD: u64 = 64;
    /// Below what transients of a few hundred returns leave, except near a bifurcation; well above rounding error.
    pub const PERIOD_TOLERANCE: f64 = 1e-8;

    /// A diagram over one parameter, with a fresh start for each value.
    pub fn new(sweep: Range, observe: &str, transient: u64, keep: u64) -> Self {
        Self {
            sweeps: vec![sweep],
            observe: vec![Observed::plain(observe)],
            transient,
            keep,
            every: 1,
            start: Start::Fresh,
            chunk: None,
            longest_period: Self::LONGEST_PERIOD,
            period_tolerance: Self::PERIOD_TOLERANCE,
            record: Record::Samples,
            exponent: Exponent::Skip,
        }
    }

    /// A length of [chunks](Self::chunk) for speed, where attractors do not coexist: some 256 chunks, to keep several
    /// cores busy with many orbits each, of at least 4 and at most 64 values.
    pub fn quick_chunk(count: u64) -> u64 {
        count.div_ceil(256).clamp(4, 64)
    }
}

/// A quantity to be sampled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observed {
    /// What it is called in the result.
    pub name: String,
    /// An expression of coordinates, parameters and what happened since the sample before
    /// ([`Passage::NAMES`](crate::analysis::map::Passage::NAMES)).
    pub expression: String,
}

impl Observed {
    /// An expression that is its own name.
    pub fn plain(expression: &str) -> Self {
        Self {
            name: expression.to_owned(),
            expression: expression.to_owned(),
        }
    }
}

/// Where the orbits of a diagram start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// From the map's own initial point, at each parameter value.
    Fresh,
    /// From where the orbit at the next lower parameter value ended; the lowest value (of each chunk) starts afresh, and
    /// so does a value whose neighbour's orbit ended without return, or whose orbit cannot start there.
    CarryUp,
    /// From where the orbit at the next higher parameter value ended, in the same way.
    CarryDown,
    /// Both: two rows a value, the first carried upwards, the second downwards.
    CarryBoth,
    /// From several points drawn at random, the same on every machine: a row for each.
    Random {
        /// How many orbits each parameter value has.
        count: u64,
        /// Another seed, other points.
        seed: u64,
        /// Between which bounds a coordinate is drawn; others start at their initial values. Points from which no orbit
        /// can start are drawn again.
        bounds: Vec<Bounds>,
    },
}

/// Bounds of a coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// The coordinate's name.
    pub coordinate: String,
    /// Least value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
}

/// What is kept of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// Its samples and what they were classified as.
    Samples,
    /// What it was classified as.
    Classes,
}

/// Whether the largest Lyapunov exponent of an orbit is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Exponent {
    /// It is not.
    Skip,
    /// It is, for a sample to the next, by the derivative of the map: minus infinity where orbits forget what they differed by.
    Largest,
}
