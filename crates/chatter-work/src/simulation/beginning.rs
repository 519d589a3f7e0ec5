//! Whether trajectories of a model begin.

use super::sentence;
use chatter::analysis::simulate::{SimulateError, Spec, simulate};
use chatter::flow::{FlowError, SystemError};
use chatter::model::Model;
use core::ops::ControlFlow;

/// Why no trajectory begins; none where one does, or where a warning of the check says so already.
pub fn why_none_begins(model: &Model) -> Option<String> {
    let parameters = model.parameter_values::<f64>(&[]);
    let start = model
        .time
        .map_or(0.0, |time| model.initial_state(&parameters)[time]);
    // Until any later time: what matters is whether there is a first step.
    let later = start + 1.0_f64.max(start.abs());
    let begun = simulate::<f64>(model, &Spec::until(later), &mut |_| ControlFlow::Break(()));
    match begun {
        Ok(_) => None,
        // A warning names these with the contact.
        Err(SimulateError::Start(FlowError::Penetrates { .. } | FlowError::Restitution { .. })) => {
            None
        }
        Err(SimulateError::System(SystemError::Model(_))) => None,
        Err(SimulateError::Start(error)) => Some(sentence(&error, model)),
        Err(error) => Some(error.to_string()),
    }
}
