//! What looks wrong about a model that can be simulated all the same.

use crate::model::mechanics::MechanicsError;
use core::fmt;

/// Something the author of a model may not have meant.
#[derive(Clone, PartialEq, Debug)]
pub enum Warning {
    /// There are no contacts, so no impacts.
    NoContact,
    /// L_W v is zero everywhere: no impulse can turn the rate.
    ImpulseLeavesRate {
        /// Name of the contact.
        contact: String,
    },
    /// Nothing can be derived.
    NotDerived {
        /// Why.
        error: MechanicsError,
    },
    /// The gaps of two contacts are the same, or proportional.
    LikeContacts {
        /// Their names.
        contacts: [String; 2],
    },
    /// L_W v is zero at the initial state.
    NoImpactAtStart {
        /// Name of the contact.
        contact: String,
    },
    /// L_W h is not zero: an impulse shifts the gap itself.
    ImpulseMovesGap {
        /// Name of the contact.
        contact: String,
        /// L_W h.
        change: String,
    },
    /// The rate does not change in proportion to the impulse, so (M1) reaches -r v only to first order.
    RateNotAffine {
        /// Name of the contact.
        contact: String,
    },
    /// The restitution is outside [0, 1] at the initial state and the given parameters.
    Restitution {
        /// Name of the contact.
        contact: String,
        /// Its value.
        value: f64,
    },
    /// The initial state is beyond the contact.
    NegativeGap {
        /// Name of the contact.
        contact: String,
        /// The gap there.
        gap: f64,
    },
    /// The initial state is on the contact and moves into it.
    StartsWithImpact {
        /// Name of the contact.
        contact: String,
        /// The rate there.
        rate: f64,
    },
    /// Something is not finite at the initial state.
    NotFinite {
        /// What it is.
        what: String,
        /// Its value.
        value: f64,
    },
    /// The surface of a section is a constant, which nothing crosses.
    SectionWithoutState {
        /// Name of the section.
        section: String,
    },
    /// No equation uses this parameter.
    UnusedParameter {
        /// Its name.
        name: String,
    },
    /// No equation uses this definition.
    UnusedDefinition {
        /// Its name.
        name: String,
    },
    /// No equation uses this state, not even its own.
    UnusedState {
        /// Its name.
        name: String,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoContact => write!(f, "the model has no [[contact]], so no impacts"),
            Self::ImpulseLeavesRate { contact } => write!(
                f,
                "contact `{contact}`: the impulse does not change the rate of the gap, so no impact can happen; \
                 does it act on the right state?"
            ),
            Self::NotDerived { error } => error.fmt(f),
            Self::LikeContacts {
                contacts: [first, second],
            } => write!(
                f,
                "contacts `{first}` and `{second}` have the same gap, so they close together and their forces are not \
                 determined; is one of them left over?"
            ),
            Self::NoImpactAtStart { contact } => write!(
                f,
                "contact `{contact}`: at the initial state the impulse does not change the rate of the gap"
            ),
            Self::ImpulseMovesGap { contact, change } => write!(
                f,
                "contact `{contact}`: the impulse shifts the gap itself, by {change} per unit; \
                 an impact is to change velocities, not positions"
            ),
            Self::RateNotAffine { contact } => write!(
                f,
                "contact `{contact}`: the rate is not affine along the impulse, so that an impact turns v into -r v \
                 only to first order"
            ),
            Self::Restitution { contact, value } => write!(
                f,
                "contact `{contact}`: restitution is {value} at the start, outside 0 <= r <= 1"
            ),
            Self::NegativeGap { contact, gap } => {
                write!(
                    f,
                    "contact `{contact}`: the gap is {gap} at the start, below zero"
                )
            }
            Self::StartsWithImpact { contact, rate } => write!(
                f,
                "contact `{contact}`: the start is in contact with rate {rate}, so it begins with an impact"
            ),
            Self::NotFinite { what, value } => write!(f, "{what} is {value} at the start"),
            Self::SectionWithoutState { section } => write!(
                f,
                "section `{section}`: the surface does not depend on the state, so nothing crosses it"
            ),
            Self::UnusedParameter { name } => write!(f, "no equation uses parameter `{name}`"),
            Self::UnusedDefinition { name } => write!(f, "no equation uses definition `{name}`"),
            Self::UnusedState { name } => {
                write!(
                    f,
                    "no equation uses state `{name}`: it is only carried along"
                )
            }
        }
    }
}
