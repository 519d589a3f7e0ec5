//! Why there is no periodic orbit, as refusals.

use super::is_wrong;
use crate::refusal::Refusal;
use crate::simulation::sentence;
use chatter::analysis::periodic::PeriodicError;
use chatter::model::{Model, State};
use chatter::numerics::Real;

/// Where energy is conserved no multiplier is smaller.
const CONSERVED: f64 = 0.999;

/// What may be done where some displacements of a periodic motion die out, and others neither die out nor grow.
fn one_of_many_that_die_out(model: &Model) -> String {
    let rate = |state: &State| model.graph.as_number(state.derivative);
    let is_reset = model.sections.iter().any(|section| section.reset.is_some())
        || model.contacts.iter().any(|contact| contact.reset.is_some());
    let stands = |state: &&State| !is_reset && rate(state).is_some_and(|rate| rate.to_f64() == 0.0);
    let standing: Vec<String> = (model.states.iter().filter(stands))
        .map(|state| format!("`{}`", state.name))
        .collect();
    match &standing[..] {
        [] => "some of what is displaced dies out and some stays as it is: the energy of an undamped part may be conserved, or the parameters \
               be those of a fold or of a branch point, beside which there are orbits"
            .to_owned(),
        _ => format!(
            "{} stands still, and the rest follows: make it a parameter",
            standing.join(", ")
        ),
    }
}

/// Why, in words.
pub(super) fn why(error: &PeriodicError, model: &Model) -> String {
    match error {
        PeriodicError::Start(error) | PeriodicError::Ended(error) => sentence(error, model),
        error => error.to_string(),
    }
}

/// A question that does not fit the model is wrong input; one without answer is an answer of its own kind.
pub fn refused(error: &PeriodicError, model: &Model) -> Refusal {
    let message = why(error, model);
    let help = match error {
        PeriodicError::NoPeriod => Some("give it with --period, such as --period '2*pi/omega'".to_owned()),
        PeriodicError::Autonomous => Some("leave out --period".to_owned()),
        PeriodicError::NotSettled { .. } | PeriodicError::Boundless => Some(
            "the motion may be chaotic or quasi-periodic, and no short orbit was found beside it: --all looks from many starts".to_owned(),
        ),
        PeriodicError::NotRepeated { .. } => Some(
            "the motion may be quasi-periodic, or chaotic: `chatter exponents` tells; --all looks for orbits from many starts".to_owned(),
        ),
        PeriodicError::OutOfRange { .. } => {
            Some("give --sweep a range with the point in it, or begin at another point with --from".to_owned())
        }
        PeriodicError::OneOfMany { least } if *least >= CONSERVED => {
            Some("energy may be conserved: add damping or forcing, or follow the motion with simulate".to_owned())
        }
        PeriodicError::OneOfMany { .. } => Some(one_of_many_that_die_out(model)),
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
