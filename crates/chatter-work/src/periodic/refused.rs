//! Why there is no periodic orbit, as refusals.

use super::is_wrong;
use crate::refusal::Refusal;
use crate::simulation::sentence;
use chatter::analysis::periodic::PeriodicError;
use chatter::model::Model;

/// A question that does not fit the model is wrong input; one without answer is an answer of its own kind.
pub fn refused(error: &PeriodicError, model: &Model) -> Refusal {
    let message = match error {
        PeriodicError::Start(error) | PeriodicError::Ended(error) => sentence(error, model),
        error => error.to_string(),
    };
    let help = match error {
        PeriodicError::NoPeriod => Some("give it with --period, such as --period '2*pi/omega'".to_owned()),
        PeriodicError::Autonomous => Some("leave out --period".to_owned()),
        PeriodicError::NotSettled { .. } | PeriodicError::Boundless => Some(
            "the motion may be chaotic or quasi-periodic, and no short orbit was found beside it: --all looks from many starts".to_owned(),
        ),
        PeriodicError::OutOfRange { .. } => {
            Some("give --sweep a range with the point in it, or begin at another point with --from".to_owned())
        }
        PeriodicError::OneOfMany => {
            Some("energy may be conserved: add damping or forcing, or follow the motion with simulate".to_owned())
        }
        PeriodicError::Eventless { .. } => {
            Some("give the model a [section.NAME] that the motion crosses".to_owned())
        }
        PeriodicError::Equilibrium { .. } | PeriodicError::AtRest => Some("start elsewhere with --initial, or choose other parameters".to_owned()),
        _ => None,
    };
    match error {
        PeriodicError::Interrupted => Refusal::Interrupted,
        error if is_wrong(error) => Refusal::Input { message, help },
        _ => Refusal::Unfinished { message, help },
    }
}
