//! What diagram is wanted, in a form that can be stored.

use serde::{Deserialize, Serialize};

/// An orbit diagram of a map. Parameters that are not swept are those of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// One or two swept parameters. The first one varies fastest.
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
    /// [`usual`](Self::usual_chunk) number. Chunks are computed side by side, so this is part of the specification.
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

    /// Length of the chunks of a sweep of `count` values unless given: some 256 of them, to keep several cores busy with
    /// many orbits each, of at least 4 and at most 64 values.
    pub fn usual_chunk(count: u64) -> u64 {
        count.div_ceil(256).clamp(4, 64)
    }
}

/// Values of one parameter: equally spaced, both ends included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// The parameter's name.
    pub parameter: String,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// How many values.
    pub count: u64,
    /// How they are spaced.
    pub spacing: Spacing,
}

impl Range {
    /// Equal differences.
    pub fn linear(parameter: &str, from: f64, to: f64, count: u64) -> Self {
        Self {
            parameter: parameter.to_owned(),
            from,
            to,
            count,
            spacing: Spacing::Linear,
        }
    }

    /// Value number `index`, from 0.
    pub fn value(&self, index: u64) -> f64 {
        if index == 0 {
            return self.from;
        }
        if index + 1 >= self.count {
            return self.to;
        }
        let share = index as f64 / (self.count - 1) as f64;
        match self.spacing {
            Spacing::Linear => self.from + (self.to - self.from) * share,
            Spacing::Logarithmic => {
                let exponent = libm::log(self.to / self.from) * share;
                self.from * libm::exp(exponent)
            }
        }
    }
}

/// How values are spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spacing {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
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
    /// From where the orbit at the next lower parameter value ended; the lowest value of a chunk starts afresh, and so
    /// does a value whose neighbour's orbit ended without return, or whose orbit cannot start there.
    CarryUp,
    /// From where the orbit at the next higher parameter value ended, in the same way.
    CarryDown,
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
    /// It is, for a sample to the next: by the map's Jacobian, else by the distance of a second orbit that is brought
    /// near again after each sample.
    Largest,
}
