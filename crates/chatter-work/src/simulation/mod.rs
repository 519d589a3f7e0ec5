//! A simulation: followed, and told as a JSON document, as a table, as a picture.

mod beginning;
pub mod columns;
pub mod document;
pub mod event_table;
mod expectation;
mod follow;
pub mod picture;
mod record;
mod request;
mod sample;
mod sentence;
pub mod table;
pub mod verification;

pub use beginning::why_none_begins;
pub use columns::rates;
pub use expectation::{Expectation, limiting};
pub use follow::{Followed, Rows, follow};
pub use record::{Noted, Record};
pub use request::{Request, start_time};
pub use sample::SampleOption;
pub use sentence::sentence;

use crate::data_files::DataFiles;
use crate::numbers::Digits;
use chatter::analysis::simulate::Spec;
use chatter::expressions::Side;
use chatter::flow::{Closed, Held, Occurrence, Place};
use chatter::model::Model;
use chatter::numerics::Real;

/// What a simulation was about.
pub struct Subject<'a> {
    /// The model, with everything set into it.
    pub model: &'a Model,
    /// What was asked for.
    pub spec: &'a Spec,
    /// The model as the user named it.
    pub source: &'a str,
    /// The text of the model's file.
    pub text: &'a str,
    /// The files that its tables stand in.
    pub data_files: &'a DataFiles,
    /// How many digits the user wants.
    pub digits: Digits,
    /// Whether the user said when to end.
    pub time_was_given: bool,
}

impl Subject<'_> {
    /// Positions of the states proper: time is told apart.
    pub fn states(&self) -> impl Iterator<Item = usize> {
        (0..self.model.states.len()).filter(|&index| Some(index) != self.model.time)
    }

    /// Name of a state.
    pub fn state_name(&self, index: usize) -> &str {
        &self.model.states[index].name
    }

    /// Names of closed contacts.
    pub fn contact_names(&self, closed: Closed) -> Vec<&str> {
        let contacts = closed.contacts();
        contacts
            .map(|contact| self.model.contacts[contact].name.as_str())
            .collect()
    }

    /// Formulas of surfaces that are slid along.
    pub fn slid(&self, held: &Held) -> Vec<&str> {
        let surfaces = held.surfaces.iter();
        surfaces
            .map(|&surface| self.model.surfaces[surface].as_str())
            .collect()
    }

    /// Names of contacts that stick.
    pub fn stuck(&self, held: &Held) -> Vec<&str> {
        let contacts = held.contacts.iter();
        contacts
            .map(|&contact| self.model.contacts[contact].name.as_str())
            .collect()
    }

    /// Name of the contact, section or surface of an event.
    pub fn place<R: Real>(&self, detail: &Occurrence<R>) -> &str {
        match detail.place() {
            Some(Place::Contact(index)) => &self.model.contacts[index].name,
            Some(Place::Surface(index)) => &self.model.surfaces[index],
            Some(Place::Section(index)) => &self.model.sections[index].name,
            None => "",
        }
    }
}

/// A side of a surface in words.
pub fn side_name(side: Side) -> &'static str {
    match side {
        Side::Above => "above",
        Side::Below => "below",
        Side::Sliding => "on it",
    }
}
