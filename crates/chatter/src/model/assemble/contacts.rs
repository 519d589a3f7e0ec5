//! Contacts and sections.

use super::Assembly;
use crate::expressions::Expr;
use crate::model::draft::{ContactDraft, Draft, Entry, ImpulseDraft, SectionDraft};
use crate::model::error::ModelErrorKind;
use crate::model::model::{Contact, Section};
use crate::model::names::TIME;
use crate::model::scope::Scope;

impl Assembly<'_> {
    pub(super) fn contact(
        &mut self,
        scope: &Scope,
        contact: &ContactDraft,
        index: usize,
        draft: &Draft,
    ) -> Contact {
        let table = match &contact.name {
            Some(name) => format!("[[contact]] `{}`", name.text),
            None => "[[contact]]".to_owned(),
        };
        let name = match &contact.name {
            Some(name) => name.text.clone(),
            None if draft.contacts.len() == 1 => "contact".to_owned(),
            None => format!("contact{}", index + 1),
        };
        let present = [
            ("gap", contact.gap.is_some()),
            ("impulse", contact.impulse.is_some()),
            ("restitution", contact.restitution.is_some()),
        ];
        let missing = present.iter().filter(|(_, there)| !there);
        let keys: Vec<&'static str> = missing.map(|&(key, _)| key).collect();
        if !keys.is_empty() {
            self.report(ModelErrorKind::MissingKeys { table, keys }, &contact.place);
        }
        let gap = self.read_optional(scope, contact.gap.as_ref());
        let restitution = self.read_optional(scope, contact.restitution.as_ref());
        if let (Some(value), Some(formula)) =
            (self.graph.as_number(restitution), &contact.restitution)
        {
            let value = value.high();
            if !(0.0..=1.0).contains(&value) {
                self.report(ModelErrorKind::Restitution { value }, &formula.place);
            }
        }
        let impulse = contact.impulse.as_ref();
        let impulse = impulse.map_or_else(Vec::new, |impulse| self.impulse(scope, impulse));
        Contact {
            name,
            gap,
            impulse,
            restitution,
            reset: None,
            friction: None,
        }
    }

    /// The impulse direction, one component a state.
    fn impulse(&mut self, scope: &Scope, impulse: &ImpulseDraft) -> Vec<Expr> {
        let zero = self.graph.number(0.0);
        let mut direction = vec![zero; self.states.len()];
        let Some(components) = &impulse.components else {
            return direction;
        };
        let mut misplaced = false;
        for Entry { name, formula } in components {
            let value = self.read(scope, formula);
            let index = self
                .states
                .iter()
                .position(|state| state.name.text == name.text);
            if let Some(index) = index {
                direction[index] = value;
                continue;
            }
            misplaced = true;
            let kind = if name.text == TIME {
                ModelErrorKind::ImpulseOnTime
            } else {
                let (states, nearest) = self.state_names(&name.text);
                let name = name.text.clone();
                ModelErrorKind::ImpulseOnUnknownState {
                    name,
                    states,
                    nearest,
                }
            };
            self.report(kind, &name.place);
        }
        if !misplaced && direction.iter().all(|&component| component == zero) {
            self.report(ModelErrorKind::NoImpulse, &impulse.place);
        }
        direction
    }

    pub(super) fn section(&mut self, scope: &Scope, section: &SectionDraft) -> Section {
        if section.surface.is_none() {
            let table = format!("[section.{}]", section.name.text);
            let kind = ModelErrorKind::MissingKeys {
                table,
                keys: vec!["surface"],
            };
            self.report(kind, &section.name.place);
        }
        let surface = self.read_optional(scope, section.surface.as_ref());
        Section {
            name: section.name.text.clone(),
            surface,
            direction: section.direction,
            reset: None,
        }
    }
}
