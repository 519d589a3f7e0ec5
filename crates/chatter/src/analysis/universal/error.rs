//! What a caller of the universal map can get wrong.

use crate::numerics::Real;
use core::fmt;

/// Why a universal function, its map or its atlas cannot be had.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UniversalError {
    /// The restitution is not in the open interval (0, 1).
    Restitution {
        /// What was given.
        value: f64,
    },
    /// The slope K of the map is zero or not finite.
    Slope {
        /// What was given.
        value: f64,
    },
    /// The offset mu of the map is not finite.
    Offset {
        /// What was given.
        value: f64,
    },
}

impl UniversalError {
    /// Refuses a slope K that is zero or not finite.
    pub(super) fn check_slope<R: Real>(slope: R) -> Result<(), Self> {
        let value = slope.to_f64();
        if !value.is_finite() || value == 0.0 {
            return Err(Self::Slope { value });
        }
        Ok(())
    }
}

impl fmt::Display for UniversalError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Restitution { value } => write!(
                out,
                "the universal map needs a restitution between 0 and 1, both excluded; got {value}"
            ),
            Self::Slope { value } => write!(
                out,
                "the slope of the universal map must be finite and not zero; got {value}"
            ),
            Self::Offset { value } => {
                write!(
                    out,
                    "the offset of the universal map must be finite; got {value}"
                )
            }
        }
    }
}

impl std::error::Error for UniversalError {}
