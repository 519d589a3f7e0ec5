//! Why there is no answer, as failures.

use crate::failure::Failure;
use chatter::analysis::border::BorderError;

/// A question that does not fit the model is wrong input; one without answer is an answer of its own kind.
pub fn refused(error: BorderError) -> Failure {
    match error {
        BorderError::NoBorder { .. } => Failure::Unfinished {
            message: error.to_string(),
            help: Some("look elsewhere with another --near, or over a --range".to_owned()),
        },
        BorderError::NotConverged { .. } | BorderError::Flow { .. } => Failure::Unfinished {
            message: error.to_string(),
            help: None,
        },
        error => Failure::input(error),
    }
}
