//! The tolerance of an integration, checked.

use core::fmt;

/// A tolerance that is no small positive number or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongTolerance {
    /// What was asked for.
    pub value: f64,
}

/// A relative truncation error allowed a step has to be from 0 to below 1.
pub(crate) fn check_tolerance(value: f64) -> Result<(), WrongTolerance> {
    if (0.0..1.0).contains(&value) {
        Ok(())
    } else {
        Err(WrongTolerance { value })
    }
}

impl fmt::Display for WrongTolerance {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "a tolerance of {} makes no sense: expected a number from 0 (rounding error) to below 1",
            self.value
        )
    }
}

impl core::error::Error for WrongTolerance {}
