//! Why a trajectory cannot go on.

use crate::expressions::Singularity;
use crate::model::Model;
use core::fmt;
use serde::{Deserialize, Serialize};

/// What the method could not do, with the numbers. What was computed before stays valid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FlowError {
    /// The field, a gap or an impact map is not a finite number here.
    LeftDomain {
        /// Time of the last good state.
        time: f64,
        /// That state.
        state: Vec<f64>,
    },
    /// The equations stop being smooth here: a denominator, or the argument of a root or logarithm, reaches zero.
    Singular {
        /// Time of it.
        time: f64,
        /// What the expression that reaches zero is there for.
        kind: Singularity,
        /// That expression; empty where it is only part of one.
        expression: String,
    },
    /// The start lies inside the obstacle.
    Penetrates {
        /// Index of the contact.
        contact: usize,
        /// Its gap, negative.
        gap: f64,
    },
    /// A gap has jumped, at a corner or by an event, to a value that no obstacle allows.
    JumpsInside {
        /// Time of the jump.
        time: f64,
        /// Index of the contact.
        contact: usize,
        /// Its gap after it, negative.
        gap: f64,
    },
    /// Contacts that close together cannot be held together: their reactions are not determined.
    DependentContacts {
        /// Time of the event.
        time: f64,
        /// Indices of the contacts.
        contacts: Vec<usize>,
    },
    /// A contact is at rest with acceleration and jerk zero: whether it opens is decided by higher derivatives.
    UndecidedRelease {
        /// Time of the event.
        time: f64,
        /// Index of the contact.
        contact: usize,
    },
    /// A model with more contacts and sections than can be watched at once.
    TooManySurfaces {
        /// How many it has.
        count: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// A restitution outside [0, 1] at an impact.
    Restitution {
        /// Time of the impact.
        time: f64,
        /// Index of the contact.
        contact: usize,
        /// Minus the ratio of the rates after and before.
        value: f64,
    },
    /// Several motions start on a surface: the fields on both sides point away from it.
    NotUnique {
        /// Time of the event.
        time: f64,
        /// The surfaces, as formulas.
        surfaces: Vec<String>,
    },
    /// No motion goes on from a corner of surfaces, or there are more of them at once than are looked through.
    NoMode {
        /// Time of the event.
        time: f64,
        /// The surfaces, as formulas.
        surfaces: Vec<String>,
    },
    /// The motion is led back to a jump of what is looked up from both sides: such jumps are passed, not slid along.
    HeldAtLookup {
        /// Time of the event.
        time: f64,
        /// What is looked up, as a formula.
        argument: String,
    },
    /// A contact comes to rest on a kink of its gap, where it is held from both sides: that is two contacts.
    RestsOnKink {
        /// Time of it.
        time: f64,
        /// Index of the contact.
        contact: usize,
        /// What is zero on the kink, as a formula.
        surface: String,
    },
    /// The argument of a table has left its range.
    OutsideTable {
        /// Time of the event.
        time: f64,
        /// Name of the table.
        table: String,
        /// The argument.
        argument: f64,
    },
    /// Surfaces are crossed again and again without time passing.
    SwitchesWithoutEnd {
        /// Time of the event.
        time: f64,
        /// How many crossings were made.
        count: usize,
    },
    /// A contact slides such that the contact force, with the friction that it brings about, cannot hold it: there is no
    /// motion, or there are several (Painlevé).
    Jammed {
        /// Time of the event.
        time: f64,
        /// Index of the contact.
        contact: usize,
    },
    /// Impacts follow each other ever faster at a contact whose reset does not say what they come to.
    ResetsWithoutEnd {
        /// Time of the latest.
        time: f64,
        /// Index of the contact.
        contact: usize,
    },
    /// Impacts at several contacts that follow each other without time passing.
    ImpactsWithoutEnd {
        /// Time of the event.
        time: f64,
        /// How many were resolved.
        count: usize,
    },
}

impl FlowError {
    /// A word for it, the same in all output.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::LeftDomain { .. } => "left_domain",
            Self::Singular { .. } => "singular",
            Self::Penetrates { .. } => "penetrates",
            Self::JumpsInside { .. } => "jumps_inside",
            Self::DependentContacts { .. } => "dependent_contacts",
            Self::UndecidedRelease { .. } => "undecided_release",
            Self::Restitution { .. } => "restitution",
            Self::ImpactsWithoutEnd { .. } => "impacts_without_end",
            Self::TooManySurfaces { .. } => "too_many_surfaces",
            Self::NotUnique { .. } => "not_unique",
            Self::NoMode { .. } => "no_mode",
            Self::HeldAtLookup { .. } => "held_at_lookup",
            Self::RestsOnKink { .. } => "rests_on_kink",
            Self::OutsideTable { .. } => "outside_table",
            Self::SwitchesWithoutEnd { .. } => "switches_without_end",
            Self::Jammed { .. } => "jammed",
            Self::ResetsWithoutEnd { .. } => "resets_without_end",
        }
    }
}

impl FlowError {
    /// The same with the names that a model gives its contacts.
    pub fn named<'a>(&'a self, model: &'a Model) -> impl fmt::Display + 'a {
        Named { error: self, model }
    }

    fn write(&self, out: &mut fmt::Formatter<'_>, name: &dyn Fn(usize) -> String) -> fmt::Result {
        match self {
            Self::LeftDomain { time, state } => write!(
                out,
                "the equations leave their domain after time {time}: they have no finite value past the state {state:?}"
            ),
            Self::Singular {
                time,
                kind,
                expression,
            } => {
                write!(out, "at time {time} {}", kind.sentence(expression))
            }
            Self::Penetrates { contact, gap } => write!(
                out,
                "the initial state lies inside {}: its gap is {gap:.1e}, and a gap must not be negative",
                name(*contact)
            ),
            Self::JumpsInside { time, contact, gap } => write!(
                out,
                "at time {time} the gap of {} jumps to {gap:.1e}: a gap must not be negative",
                name(*contact)
            ),
            Self::DependentContacts { time, contacts } => write!(
                out,
                "at time {time} {} close together, but their constraint forces are not independent",
                contacts
                    .iter()
                    .map(|&contact| name(contact))
                    .collect::<Vec<_>>()
                    .join(" and ")
            ),
            Self::UndecidedRelease { time, contact } => write!(
                out,
                "at time {time} {} is at rest with zero acceleration and jerk: the equations do not decide \
                 whether it opens",
                name(*contact)
            ),
            Self::TooManySurfaces { count, limit } => write!(
                out,
                "the model has {count} contacts, sections and corners; at most {limit} are supported"
            ),
            Self::Restitution {
                time,
                contact,
                value,
            } => write!(
                out,
                "at time {time} {} has restitution {value}, outside [0, 1]",
                name(*contact)
            ),
            Self::NotUnique { time, surfaces } => write!(
                out,
                "at time {time} several motions leave the surface {}: the fields on its sides point away from it",
                surfaces.join(", ")
            ),
            Self::NoMode { time, surfaces } => write!(
                out,
                "at time {time} the equations do not say how the motion goes on from {}",
                surfaces.join(", ")
            ),
            Self::HeldAtLookup { time, argument } => write!(
                out,
                "at time {time} the motion is held at a jump of `floor`, `mod` or a table, whose argument is {argument}: such jumps are \
                 only passed; written with `if` or `step` they are slid along"
            ),
            Self::RestsOnKink {
                time,
                contact,
                surface,
            } => write!(
                out,
                "at time {time} {} comes to rest on a kink of its gap, {surface} = 0, where it is held from both sides: \
                 write it as two contacts, each with the gap of one side",
                name(*contact)
            ),
            Self::OutsideTable {
                time,
                table,
                argument,
            } => write!(
                out,
                "at time {time} the argument of table `{table}` leaves its range at {argument}; `outside = \"hold\"` \
                 would go on with the value at its end"
            ),
            Self::SwitchesWithoutEnd { time, count: 1 } => write!(
                out,
                "at time {time} an event follows itself in less time than can be told, sooner each time: there is no end of such events"
            ),
            Self::SwitchesWithoutEnd { time, count } => write!(
                out,
                "at time {time} surfaces are crossed {count} times without time passing"
            ),
            Self::Jammed { time, contact } => write!(
                out,
                "at time {time} friction jams {}: the contact force cannot hold it, so that there is no motion \
                 or there are several (Painlevé)",
                name(*contact)
            ),
            Self::ResetsWithoutEnd { time, contact } => write!(
                out,
                "at time {time} impacts follow each other ever faster at {}, and its `reset` changes the state however \
                 small their rates are: it does not say what they come to",
                name(*contact)
            ),
            Self::ImpactsWithoutEnd { time, count } => write!(
                out,
                "at time {time} {count} impacts at several contacts follow each other without time passing"
            ),
        }
    }
}

impl fmt::Display for FlowError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(out, &numbered)
    }
}

fn numbered(contact: usize) -> String {
    format!("contact {}", contact + 1)
}

struct Named<'a> {
    error: &'a FlowError,
    model: &'a Model,
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let contacts = &self.model.contacts;
        self.error
            .write(out, &|contact| match contacts.get(contact) {
                Some(known) => format!("contact `{}`", known.name),
                None => numbered(contact),
            })
    }
}

impl std::error::Error for FlowError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_have_the_names_of_the_model() {
        let error = FlowError::Penetrates {
            contact: 0,
            gap: -2.571737941372e-22,
        };
        let told = "its gap is -2.6e-22, and a gap must not be negative";
        let numbered = format!("the initial state lies inside contact 1: {told}");
        assert_eq!(error.to_string(), numbered);
        let text = "[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.5\n[initial]\ny = 1\nv = 0\n";
        let model = Model::from_toml(text, "ball").unwrap();
        let named = format!("the initial state lies inside contact `floor`: {told}");
        assert_eq!(error.named(&model).to_string(), named);
    }
}
