//! Why there is no answer, as failures.

use crate::refusal::Refusal;
use chatter::analysis::border::{BorderError, Lack};

/// A question that does not fit the model is wrong input; one without answer is an answer of its own kind.
pub fn refused(error: BorderError) -> Refusal {
    match error {
        BorderError::NoBorder { .. } => Refusal::Unfinished {
            message: error.to_string(),
            help: Some("look elsewhere with another --near, or over a --range".to_owned()),
        },
        BorderError::Lacks {
            what: Lack::Motion(_),
            ..
        } => Refusal::Unfinished {
            message: error.to_string(),
            help: None,
        },
        error => Refusal::input(error),
    }
}
