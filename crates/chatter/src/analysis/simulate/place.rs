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
    /// What has that name, if another kind of event happens there.
    pub instead: Option<EventKind>,
}

impl EventKind {
    /// The index of the contact or section of this name where such events happen.
    pub(crate) fn place(self, model: &Model, name: &str) -> Result<usize, UnknownPlace> {
        let sections = || model.sections.iter().enumerate();
        let known: Vec<(usize, &str)> = match self {
            // One that changes the state is an event, and no crossing.
            Self::Section | Self::Reset => sections()
                .filter(|(_, section)| section.reset.is_some() == (self == Self::Reset))
                .map(|(index, section)| (index, &*section.name))
                .collect(),
            Self::Switch | Self::Slide | Self::Leave => {
                let names = model.surfaces.iter().map(String::as_str);
                names.enumerate().collect()
            }
            _ => (model.contacts.iter().map(|contact| &*contact.name))
                .enumerate()
                .collect(),
        };
        let place = known.iter().find(|(_, known)| *known == name);
        place.map(|(index, _)| *index).ok_or_else(|| {
            let other = match self {
                Self::Section => Some(Self::Reset),
                Self::Reset => Some(Self::Section),
                _ => None,
            };
            UnknownPlace {
                kind: self,
                name: name.to_owned(),
                known: (known.iter().map(|(_, known)| (*known).to_owned())).collect(),
                instead: other.filter(|_| model.section(name).is_some()),
            }
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
        match self.instead {
            Some(EventKind::Reset) => {
                return write!(out, ": that is an event, which is told as a `reset`");
            }
            Some(_) => return write!(out, ": that is a section, which changes nothing"),
            None => {}
        }
        match self.known.split_last() {
            None => write!(out, ": it has no {what}s"),
            Some((only, [])) => write!(out, ": it has `{only}`"),
            Some((last, rest)) => write!(out, ": it has `{}` and `{last}`", rest.join("`, `")),
        }
    }
}

impl core::error::Error for UnknownPlace {}
