//! The result for one orbit.

use crate::analysis::map::NoReturn;
use crate::flow::FlowError;
use core::fmt;

/// What became of one orbit. It says itself where it belongs.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its place in the diagram.
    pub row: u64,
    /// How its orbit started.
    pub start: Started,
    /// What the orbit settled to.
    pub outcome: Outcome,
    /// Samples after which the orbit repeats; zero where no period was found.
    pub period: u64,
    /// Mean number of impacts from sample to sample, over the period where there is one. Infinite where infinite impact
    /// sequences are among them; NaN where no sample was kept.
    pub impacts_per_return: f64,
    /// Largest Lyapunov exponent: mean growth, as a logarithm, of a small distance from sample to sample.
    /// Minus infinity where orbits become one, as by coming to rest on the way. NaN where it was not asked for or not found, and where the order of impacts at one
    /// instant decides on the orbit's way, so that it has no derivative.
    pub exponent: f64,
    /// The samples kept, one after the other, each with all observed quantities.
    pub samples: Vec<f64>,
    /// The point at which the orbit started.
    pub origin: Vec<f64>,
    /// Whole points of what the orbit settled to, where rows are compared: those of a period, or the latest of those that
    /// do not repeat; none where it settled to nothing.
    pub orbit: Vec<f64>,
    /// What sizes the coordinates of these points have on the way, which rounding errors are compared with; none where there are no
    /// points.
    pub sizes: Vec<f64>,
    /// The last point, where the next row of the piece goes on from it.
    pub end: Vec<f64>,
}

/// How an orbit started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Started {
    /// From the map's initial point.
    Fresh,
    /// From where its neighbour ended.
    Carried,
    /// From a point drawn at random.
    Random,
}

impl Started {
    /// All of them, by code.
    const ALL: [Self; 3] = [Self::Fresh, Self::Carried, Self::Random];

    /// A word for it, the same in all output.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fresh => "fresh",
            Self::Carried => "carried",
            Self::Random => "random",
        }
    }
}

/// What an orbit settled to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Outcome {
    /// It repeats itself.
    Periodic,
    /// It does not, and neighbouring points move apart.
    Chaotic,
    /// It does not, and moves like a rotation by angles without a common measure: neighbours stay neighbours, and averages
    /// converge as they do for nothing else.
    Quasiperiodic,
    /// No period was found, and neither of these is evident: it is still approaching something, or its period is longer
    /// than was looked for, or too few samples were kept.
    Unsettled,
    /// Infinite impact sequences that end in contact are part of what it settled to, whether that repeats or not.
    CompleteChatter,
    /// The equations have no finite value where it went.
    LeftDomain,
    /// It did not return in the time and impacts allowed, or there is no time from look to look.
    NoReturn,
    /// No orbit can start there.
    NoStart,
    /// The mechanics do not determine what follows.
    Undetermined,
    /// An observed quantity has no finite value at a sample.
    NotFinite,
}

impl Outcome {
    /// All of them, by code.
    pub const ALL: [Self; 10] = [
        Self::Periodic,
        Self::Chaotic,
        Self::Quasiperiodic,
        Self::Unsettled,
        Self::CompleteChatter,
        Self::LeftDomain,
        Self::NoReturn,
        Self::NoStart,
        Self::Undetermined,
        Self::NotFinite,
    ];

    /// A word for it, the same in all output.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::Chaotic => "chaotic",
            Self::Quasiperiodic => "quasiperiodic",
            Self::Unsettled => "unsettled",
            Self::CompleteChatter => "complete_chatter",
            Self::LeftDomain => "left_domain",
            Self::NoReturn => "no_return",
            Self::NoStart => "no_start",
            Self::Undetermined => "undetermined",
            Self::NotFinite => "not_finite",
        }
    }
}

impl From<&NoReturn> for Outcome {
    fn from(reason: &NoReturn) -> Self {
        match reason {
            NoReturn::Time { .. } | NoReturn::Impacts { .. } | NoReturn::Period { .. } => {
                Self::NoReturn
            }
            NoReturn::LeftDomain => Self::LeftDomain,
            NoReturn::Failed(error) => error.into(),
        }
    }
}

impl From<&FlowError> for Outcome {
    fn from(error: &FlowError) -> Self {
        match error {
            FlowError::LeftDomain { .. } | FlowError::Singular { .. } => Self::LeftDomain,
            FlowError::Penetrates { .. } => Self::NoStart,
            _ => Self::Undetermined,
        }
    }
}

impl Row {
    /// The number of the form of [`to_bytes`](Self::to_bytes): another form has another number.
    pub const FORMAT: u32 = 3;

    /// The row as bytes, to be stored.
    pub fn to_bytes(&self) -> Vec<u8> {
        let lists = [
            &self.origin,
            &self.orbit,
            &self.sizes,
            &self.end,
            &self.samples,
        ];
        let numbers: usize = lists.iter().map(|list| list.len()).sum();
        let mut bytes = Vec::with_capacity(72 + 8 * numbers);
        bytes.extend(self.row.to_le_bytes());
        bytes.push(self.start as u8);
        bytes.push(self.outcome as u8);
        bytes.extend(self.period.to_le_bytes());
        bytes.extend(self.impacts_per_return.to_bits().to_le_bytes());
        bytes.extend(self.exponent.to_bits().to_le_bytes());
        for numbers in lists {
            bytes.extend((numbers.len() as u64).to_le_bytes());
            bytes.extend(numbers.iter().flat_map(|x| x.to_bits().to_le_bytes()));
        }
        bytes
    }

    /// A row from its bytes.
    ///
    /// # Errors
    /// They are not those of a row.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RowError> {
        let mut rest = bytes;
        let row = Self {
            row: word(&mut rest)?,
            start: *Started::ALL.get(byte(&mut rest)?).ok_or(RowError)?,
            outcome: *Outcome::ALL.get(byte(&mut rest)?).ok_or(RowError)?,
            period: word(&mut rest)?,
            impacts_per_return: f64::from_bits(word(&mut rest)?),
            exponent: f64::from_bits(word(&mut rest)?),
            origin: numbers(&mut rest)?,
            orbit: numbers(&mut rest)?,
            sizes: numbers(&mut rest)?,
            end: numbers(&mut rest)?,
            samples: numbers(&mut rest)?,
        };
        if rest.is_empty() {
            Ok(row)
        } else {
            Err(RowError)
        }
    }
}

fn byte(rest: &mut &[u8]) -> Result<usize, RowError> {
    let (&first, tail) = rest.split_first().ok_or(RowError)?;
    *rest = tail;
    Ok(first.into())
}

fn word(rest: &mut &[u8]) -> Result<u64, RowError> {
    let (first, tail) = rest.split_first_chunk::<8>().ok_or(RowError)?;
    *rest = tail;
    Ok(u64::from_le_bytes(*first))
}

fn numbers(rest: &mut &[u8]) -> Result<Vec<f64>, RowError> {
    let count = word(rest)?;
    if count > (rest.len() / 8) as u64 {
        return Err(RowError);
    }
    let number = |_| Ok(f64::from_bits(word(rest)?));
    (0..count).map(number).collect()
}

/// Bytes that are not those of a [`Row`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowError;

impl fmt::Display for RowError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "these bytes are not those of a row of a diagram")
    }
}

impl core::error::Error for RowError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_storage() {
        for (code, outcome) in Outcome::ALL.into_iter().enumerate() {
            let row = Row {
                row: 17,
                start: Started::ALL[code % 3],
                outcome,
                period: 3,
                impacts_per_return: f64::INFINITY,
                exponent: -0.5,
                samples: vec![1.0, -0.0, 1e-300],
                origin: vec![2.0, 3.0],
                orbit: vec![0.5; code],
                sizes: vec![1.5; code % 2],
                end: vec![0.25],
            };
            let bytes = row.to_bytes();
            assert_eq!(Row::from_bytes(&bytes).as_ref(), Ok(&row));
            for cut in 0..bytes.len() {
                assert_eq!(Row::from_bytes(&bytes[..cut]), Err(RowError));
            }
        }
    }
}
