//! Contacts and sections by their names: where events of a kind happen.

use crate::expressions::nearest;
use crate::flow::EventKind;
use crate::model::Model;
use core::fmt;

/// A model has no contact or section of this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownPlace {
    /// The kind of event that was to happen there.
    pub kind: EventKind,
    /// The name given.
    pub name: String,
    /// The names there are.
    pub known: Vec<String>,
}

impl EventKind {
    /// The index of the contact or section of this name where such events happen.
    pub(crate) fn place(self, model: &Model, name: &str) -> Result<usize, UnknownPlace> {
        let known: Vec<&str> = match self {
            Self::Section | Self::Reset => model.sections.iter().map(|s| &*s.name).collect(),
            Self::Switch | Self::Slide | Self::Leave => {
                model.surfaces.iter().map(String::as_str).collect()
            }
            _ => model.contacts.iter().map(|c| &*c.name).collect(),
        };
        let place = known.iter().position(|known| *known == name);
        place.ok_or_else(|| UnknownPlace {
            kind: self,
            name: name.to_owned(),
            known: known.into_iter().map(str::to_owned).collect(),
        })
    }
}

impl UnknownPlace {
    /// The name that is probably meant.
    pub fn suggestion(&self) -> Option<String> {
        nearest(&self.name, self.known.iter().map(String::as_str))
    }
}

impl fmt::Display for UnknownPlace {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            EventKind::Section => "section",
            EventKind::Reset => "event",
            EventKind::Switch | EventKind::Slide | EventKind::Leave => "surface",
            _ => "contact",
        };
        write!(out, "the model has no {what} `{}`", self.name)?;
        match self.known.split_last() {
            None => write!(out, ": it has no {what}s"),
            Some((only, [])) => write!(out, ": it has `{only}`"),
            Some((last, rest)) => write!(out, ": it has `{}` and `{last}`", rest.join("`, `")),
        }
    }
}

impl core::error::Error for UnknownPlace {}
