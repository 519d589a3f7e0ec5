//! Why a trajectory cannot go on, with the names of the model.

use crate::numbers::Digits;
use crate::numbers::full;
use chatter::flow::FlowError;
use chatter::model::Model;

/// One sentence, without a full stop.
pub fn sentence(error: &FlowError, model: &Model) -> String {
    let name = |contact: usize| match model.contacts.get(contact) {
        Some(contact) => format!("contact `{}`", contact.name),
        None => format!("contact {}", contact + 1),
    };
    let number = |value: f64| full(value, Digits::DOUBLE);
    match error {
        FlowError::LeftDomain { time, state } => {
            let values = model.states.iter().zip(state).enumerate();
            let values: Vec<String> = values
                .filter(|&(index, _)| Some(index) != model.time)
                .map(|(_, (state, &value))| format!("{} = {}", state.name, number(value)))
                .collect();
            format!(
                "the equations leave their domain at time {}: they have no finite value past {}",
                number(*time),
                values.join(", ")
            )
        }
        FlowError::Singular {
            time,
            kind,
            expression,
        } => {
            format!("at time {} {}", number(*time), kind.sentence(expression))
        }
        FlowError::Penetrates { contact, gap } => format!(
            "the start lies beyond {}: its gap is {} there, and must not be negative",
            name(*contact),
            number(*gap)
        ),
        FlowError::JumpsInside { time, contact, gap } => format!(
            "at time {} the gap of {} jumps to {}, and must not be negative",
            number(*time),
            name(*contact),
            number(*gap)
        ),
        FlowError::DependentContacts { time, contacts } => {
            let names: Vec<String> = contacts.iter().map(|&contact| name(contact)).collect();
            format!(
                "at time {} {} are closed together, but their impulses do not determine the contact forces",
                number(*time),
                names.join(" and ")
            )
        }
        FlowError::UndecidedRelease { time, contact } => format!(
            "at time {} {} is at rest with zero acceleration and jerk: the equations do not decide whether it opens",
            number(*time),
            name(*contact)
        ),
        FlowError::Restitution {
            time,
            contact,
            value,
        } => match model.contacts.get(*contact) {
            Some(contact) if contact.reset.is_some() => format!(
                "at time {} the reset of contact `{}` returns {} times its rate, outside 0 <= r <= 1: only an [[event]] may \
                 do so",
                number(*time),
                contact.name,
                number(*value)
            ),
            _ => format!(
                "at time {} {} has restitution {}, outside 0 <= r <= 1",
                number(*time),
                name(*contact),
                number(*value)
            ),
        },
        FlowError::Jammed { time, contact } => format!(
            "at time {} friction jams {}: the contact force cannot hold it, so that there is no motion or there are \
             several (Painlevé)",
            number(*time),
            name(*contact)
        ),
        FlowError::ResetsWithoutEnd { time, contact } => format!(
            "at time {} impacts follow each other ever faster at {}, and its `reset` changes the state however small their \
             rates are: it does not say what they come to",
            number(*time),
            name(*contact)
        ),
        FlowError::RestsOnKink {
            time,
            contact,
            surface,
        } => format!(
            "at time {} {} comes to rest on a kink of its gap, {surface} = 0, where it is held from both sides: write it as two \
             contacts, each with the gap of one side",
            number(*time),
            name(*contact)
        ),
        FlowError::TooManySurfaces { .. }
        | FlowError::ImpactsWithoutEnd { .. }
        | FlowError::NotUnique { .. }
        | FlowError::NoMode { .. }
        | FlowError::HeldAtLookup { .. }
        | FlowError::OutsideTable { .. }
        | FlowError::SwitchesWithoutEnd { .. } => error.to_string(),
    }
}
