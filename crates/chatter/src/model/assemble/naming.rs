//! Every name is a name, not reserved, and stands for one thing.

use super::Assembly;
use crate::model::error::{ModelError, ModelErrorKind, Role};
use crate::model::names::{TIME, is_name_of, reserved_meaning};
use crate::model::source::draft::{Draft, Entry, Name};
use std::collections::HashMap;

impl<'a> Assembly<'a> {
    pub(super) fn check_flight(&mut self, draft: &'a Draft) {
        let nothing = self.parameters.is_empty()
            && self.definitions.is_empty()
            && draft.contacts.is_empty()
            && draft.sections.is_empty()
            && draft.initial.is_empty();
        match &draft.flight {
            None if nothing => self.report(ModelErrorKind::Empty, &draft.place),
            None => self.report(ModelErrorKind::NoFlight, &draft.place),
            Some((place, Some(entries))) if entries.is_empty() => {
                self.report(ModelErrorKind::NoStates, place);
            }
            Some((_, entries)) => {
                for entry in entries
                    .iter()
                    .flatten()
                    .filter(|entry| entry.name.text == TIME)
                {
                    self.report(ModelErrorKind::TimeEquation, &entry.name.place);
                }
            }
        }
    }

    /// Every name is a name, not reserved, and stands for one thing.
    pub(super) fn check_names(&mut self, draft: &'a Draft) {
        let of = |role: Role| move |entry: &'a Entry| (role, &entry.name);
        let mut quantities: Vec<(Role, &Name)> = (self.states.iter().copied().map(of(Role::State)))
            .chain(self.parameters.iter().map(of(Role::Parameter)))
            .chain(self.definitions.iter().map(of(Role::Definition)))
            .chain(draft.tables.iter().map(|table| (Role::Table, &table.name)))
            .collect();
        quantities.sort_by_key(|(_, name)| name.place.span.start);
        let contacts = draft
            .contacts
            .iter()
            .filter_map(|contact| contact.name.as_ref());
        let contacts: Vec<(Role, &Name)> = contacts.map(|name| (Role::Contact, name)).collect();
        let sections = draft
            .sections
            .iter()
            .map(|section| (Role::Section, &section.name));
        for names in [quantities, contacts, sections.collect()] {
            let mut seen: HashMap<&str, (Role, &Name)> = HashMap::new();
            for (role, name) in names {
                self.check_name(role, name);
                let Some((first, there)) = seen.insert(&name.text, (role, name)) else {
                    continue;
                };
                let name_text = name.text.clone();
                let kind = ModelErrorKind::DuplicateName {
                    name: name_text,
                    role,
                    first,
                };
                let error = ModelError::new(kind, &name.place);
                let label = format!("first defined here as a {first}");
                self.errors.push(if there.place == name.place {
                    error
                } else {
                    error.with_related(&there.place, label)
                });
            }
        }
    }

    fn check_name(&mut self, role: Role, name: &Name) {
        let text = name.text.clone();
        let in_expressions = !matches!(role, Role::Contact | Role::Section);
        if !is_name_of(role, &text) {
            self.report(
                ModelErrorKind::InvalidName { name: text, role },
                &name.place,
            );
        } else if let Some(meaning) = reserved_meaning(&text).filter(|_| in_expressions) {
            let name_text = text;
            self.report(
                ModelErrorKind::ReservedName {
                    name: name_text,
                    role,
                    meaning,
                },
                &name.place,
            );
        }
    }
}
