//! Periodic orbits and their branches: as documents, tables and figures.

mod arcs;
mod branch_document;
mod curves;
mod find;
mod job;
mod log;
mod merged;
mod orbit_document;
mod over;
mod picture;
mod produce;
mod refused;
mod request;
mod restored;
mod same_model;
mod several;
mod table;
mod wanted;

pub use arcs::{Arc, arcs};
pub use branch_document::{curves_document, document as branch_document};
pub use find::{Found, find_branches, find_curve, find_orbits};
pub use job::{Job, Plane, Ready, Sought};
pub use log::{Begun, Log};
pub use merged::merge;
pub use orbit_document::{document as orbit_document, events_of};
pub use over::{Beneath, beneath};
pub use picture::{Vertical, first_that_changes, picture, plane};
pub use produce::{Beginning, Produced, produce, produce_share};
pub use refused::refused;
pub use request::{free_parameter, specification};
pub use restored::{Asked, Chosen, Restored, holds_branches, restore};
pub use several::Shared;
pub use table::write;
pub use wanted::{Branches, Curve, Orbits, Reach, beside, search};

use crate::Refusal;
use crate::numbers::Digits;
use chatter::analysis::periodic::{Branch, PeriodicError, SpecialKind};
use chatter::flow::{FlowError, GuardKind};
use chatter::model::Model;

/// What was asked about.
pub struct Subject<'a> {
    /// The model, with everything set into it.
    pub model: &'a Model,
    /// The model as the user named it.
    pub source: &'a str,
    /// The text of the model's file.
    pub text: &'a str,
    /// Functions that are watched, as the user wrote them.
    pub monitors: &'a [String],
    /// Positions of the free parameters.
    pub free: Vec<usize>,
    /// How many digits the user wants.
    pub digits: Digits,
}

/// Columns that tables and documents of branches have beside parameters and states.
const COLUMNS: [&str; 8] = [
    "branch",
    "period",
    "impacts",
    "stable",
    "neutral",
    "multipliers",
    "residual",
    "error",
];

impl Subject<'_> {
    /// The functions that are watched, by their place, that have a column of their own: one that is a state or a free parameter has
    /// that of it.
    pub(crate) fn watched(&self) -> impl Iterator<Item = (usize, &str)> {
        let texts = self.monitors.iter().map(String::as_str).enumerate();
        texts.filter(|(_, text)| {
            let is_state = self.model.states.iter().any(|state| state.name == *text);
            !is_state && !self.names().contains(text) && !COLUMNS.contains(text)
        })
    }

    /// Name and place of a guard: a contact, a surface or an event.
    pub fn place(&self, guard: GuardKind) -> String {
        match guard {
            GuardKind::Gap(contact) | GuardKind::Reaction(contact) | GuardKind::Jam(contact) => {
                self.model.contacts[contact].name.clone()
            }
            GuardKind::Section(section) => self.model.sections[section].name.clone(),
            GuardKind::Switch(surface) | GuardKind::Leave(surface, _) => (self.model.surfaces)
                .get(surface)
                .cloned()
                .unwrap_or_else(|| format!("surface {surface}")),
            GuardKind::Piece(lookup, _) | GuardKind::Outside(lookup, _) => {
                format!("table {lookup}")
            }
            GuardKind::Root(index) => self.model.radicand(index),
        }
    }

    /// Names of the free parameters.
    pub fn names(&self) -> Vec<&str> {
        let parameters = &self.model.parameters;
        (self.free.iter())
            .map(|&index| parameters[index].name.as_str())
            .collect()
    }
}

/// Refuses states and free parameters that are called as a column beside theirs is.
fn check_names(model: &Model, free: &[usize]) -> Result<(), Refusal> {
    let mut parameters = free.iter().map(|&index| &model.parameters[index].name);
    let mut states = model.states.iter().map(|state| &state.name);
    let taken = |kind: &str, name: &str| {
        Refusal::input(format!(
            "points of a branch have a column `{name}` beside that of the {kind} `{name}`"
        ))
        .help(format!("give the {kind} another name in the model"))
    };
    let is_taken = |name: &&String| COLUMNS.contains(&name.as_str());
    match (parameters.find(is_taken), states.find(is_taken)) {
        (Some(name), _) => Err(taken("parameter", name)),
        (None, Some(name)) => Err(taken("state", name)),
        (None, None) => Ok(()),
    }
}

/// How many special points of each kind branches have, in the order of first mention.
pub fn tally(branches: &[Branch]) -> Vec<(SpecialKind, usize)> {
    let mut counts: Vec<(SpecialKind, usize)> = Vec::new();
    for special in branches.iter().flat_map(|branch| &branch.special) {
        match counts.iter_mut().find(|(kind, _)| *kind == special.kind) {
            Some((_, count)) => *count += 1,
            None => counts.push((special.kind, 1)),
        }
    }
    counts
}

/// Whether a question makes no sense, rather than having no answer.
fn is_wrong(error: &PeriodicError) -> bool {
    matches!(
        error,
        PeriodicError::System(_)
            | PeriodicError::Start(_)
            | PeriodicError::Ended(FlowError::Restitution { .. })
            | PeriodicError::Autonomous
            | PeriodicError::NoPeriod
            | PeriodicError::BadMonitor { .. }
            | PeriodicError::ConstantMonitor { .. }
            | PeriodicError::BadPeriod { .. }
            | PeriodicError::OtherPeriod { .. }
            | PeriodicError::NoRepeat { .. }
            | PeriodicError::OutOfRange { .. }
            | PeriodicError::NotThere { .. }
            | PeriodicError::NotOfKind { .. }
    )
}
