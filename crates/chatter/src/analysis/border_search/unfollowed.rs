//! Values of the parameter at which nothing can be said of borders, since motion ends.

use crate::analysis::border::{BorderError, Lack, ParameterValue};
use crate::flow::FlowError;
use core::fmt;
use serde::{Deserialize, Serialize};

/// A parameter value at which the motion cannot be followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unfollowed {
    /// The parameter value.
    pub value: f64,
    /// Why.
    pub error: FlowError,
}

impl fmt::Display for Unfollowed {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "at {} {}", ParameterValue(self.value), self.error)
    }
}

/// Why motion ends, if that is what an error says.
pub(super) fn end_of_motion(error: &BorderError) -> Option<&FlowError> {
    match error {
        BorderError::Lacks {
            what: Lack::Motion(error),
            ..
        } => Some(error),
        _ => None,
    }
}
