//! Contacts and sections.

use super::Assembly;
use crate::expressions::Expr;
use crate::model::assemble::scope::Scope;
use crate::model::error::ModelErrorKind;
use crate::model::model::{Contact, Friction, Section};
use crate::model::names::TIME;
use crate::model::source::draft::{
    ContactDraft, Draft, Entry, FrictionDraft, ImpulseDraft, SectionDraft,
};

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
        let is_reset = contact.reset.is_some();
        let beside = [
            ("impulse", contact.impulse.is_some()),
            ("restitution", contact.restitution.is_some()),
        ];
        for (key, _) in beside.into_iter().filter(|&(_, there)| there && is_reset) {
            self.report(ModelErrorKind::ResetBesideImpulse { key }, &contact.place);
        }
        let present = [
            ("gap", contact.gap.is_some()),
            ("impulse", contact.impulse.is_some() || is_reset),
            ("restitution", contact.restitution.is_some() || is_reset),
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
        let reset = contact.reset.as_ref().map(|reset| self.reset(scope, reset));
        let friction = (contact.friction.as_ref())
            .and_then(|friction| self.friction(scope, friction, is_reset));
        Contact {
            name,
            gap,
            impulse,
            restitution,
            reset,
            friction,
        }
    }

    /// The state after an impact or an event: what is not named stays.
    fn reset(&mut self, scope: &Scope, reset: &ImpulseDraft) -> Vec<Expr> {
        let mut after: Vec<Expr> = (0..self.states.len())
            .map(|i| self.graph.state(i))
            .collect();
        for (index, value) in self.components(scope, reset) {
            after[index] = value;
        }
        after
    }

    fn friction(
        &mut self,
        scope: &Scope,
        friction: &FrictionDraft,
        is_reset: bool,
    ) -> Option<Friction> {
        if is_reset {
            self.report(ModelErrorKind::FrictionBesideReset, &friction.place);
            return None;
        }
        let present = [
            ("coefficient", friction.coefficient.is_some()),
            ("along", friction.along.is_some()),
        ];
        let missing = present.iter().filter(|(_, there)| !there);
        let keys: Vec<&'static str> = missing.map(|&(key, _)| key).collect();
        if !keys.is_empty() {
            let table = "friction".to_owned();
            self.report(ModelErrorKind::MissingKeys { table, keys }, &friction.place);
        }
        let coefficient = self.read_optional(scope, friction.coefficient.as_ref());
        if let (Some(value), Some(formula)) =
            (self.graph.as_number(coefficient), &friction.coefficient)
            && value.high() < 0.0
        {
            let value = value.high();
            self.report(
                ModelErrorKind::FrictionCoefficient { value },
                &formula.place,
            );
        }
        let components = friction.along.as_ref()?;
        let along = self.impulse(scope, components);
        let rate = match &friction.rate {
            Some(rate) => self.read(scope, rate),
            None => {
                let zero = self.graph.number(0.0);
                let moved: Vec<usize> = (0..along.len()).filter(|&i| along[i] != zero).collect();
                let &[only] = &moved[..] else {
                    self.report(ModelErrorKind::SlidingRateUnknown, &components.place);
                    return None;
                };
                self.graph.state(only)
            }
        };
        Some(Friction {
            coefficient,
            along,
            rate,
        })
    }

    /// The impulse direction, one component a state.
    fn impulse(&mut self, scope: &Scope, impulse: &ImpulseDraft) -> Vec<Expr> {
        let zero = self.graph.number(0.0);
        let mut direction = vec![zero; self.states.len()];
        let Some(components) = &impulse.components else {
            return direction;
        };
        let before = self.errors.len();
        for (index, value) in self.components(scope, impulse) {
            direction[index] = value;
        }
        let misplaced = self.errors.len() > before;
        if !misplaced && components.is_empty() | direction.iter().all(|&c| c == zero) {
            self.report(ModelErrorKind::NoImpulse, &impulse.place);
        }
        direction
    }

    /// Expressions by the number of the state that they are for.
    fn components(&mut self, scope: &Scope, table: &ImpulseDraft) -> Vec<(usize, Expr)> {
        let mut found = Vec::new();
        for Entry { name, formula } in table.components.iter().flatten() {
            let value = self.read(scope, formula);
            let index = self
                .states
                .iter()
                .position(|state| state.name.text == name.text);
            if let Some(index) = index {
                found.push((index, value));
                continue;
            }
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
        found
    }

    pub(super) fn section(&mut self, scope: &Scope, section: &SectionDraft) -> Section {
        let table = if section.is_event {
            "[[event]]".to_owned()
        } else {
            format!("[section.{}]", section.name.text)
        };
        if section.surface.is_none() {
            let table = table.clone();
            let kind = ModelErrorKind::MissingKeys {
                table,
                keys: vec!["surface"],
            };
            self.report(kind, &section.name.place);
        }
        if section.is_event && section.reset.is_none() {
            let kind = ModelErrorKind::MissingKeys {
                table,
                keys: vec!["reset"],
            };
            self.report(kind, &section.name.place);
        }
        let surface = self.read_optional(scope, section.surface.as_ref());
        let reset = section.reset.as_ref().map(|reset| self.reset(scope, reset));
        Section {
            name: section.name.text.clone(),
            surface,
            direction: section.direction,
            reset,
        }
    }
}
