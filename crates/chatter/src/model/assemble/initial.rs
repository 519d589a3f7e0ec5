//! Initial values: of every state, in what does not change.

use super::Assembly;
use crate::expressions::Expr;
use crate::model::assemble::scope::{Purpose, Scope};
use crate::model::error::{ModelErrorKind, Role};
use crate::model::names::TIME;
use crate::model::source::draft::{Entry, Name, Place};

impl<'a> Assembly<'a> {
    /// Names for initial values: parameters, and definitions that do not change.
    fn constants(&mut self) -> Scope<'a> {
        let mut scope = Scope::new(Purpose::Initial);
        for (index, entry) in self.parameters.iter().enumerate() {
            scope.allow(&entry.name.text, self.graph.parameter(index));
        }
        let changes = self.graph.depend_on_state(&self.meanings);
        for (index, entry) in self.definitions.iter().enumerate() {
            if changes[index] {
                scope.bar(&entry.name.text, Role::Definition);
            } else {
                scope.allow(&entry.name.text, self.placeholder(index));
            }
        }
        for entry in &self.states {
            scope.bar(&entry.name.text, Role::State);
        }
        scope.bar(TIME, Role::Time);
        scope
    }

    /// Initial values of the states, and of time where the model says one, last.
    pub(super) fn read_initial(&mut self, entries: &[Entry], flight: &Place) -> Vec<Expr> {
        let scope = self.constants();
        let mut values: Vec<Option<Expr>> = vec![None; self.states.len() + 1];
        for entry in entries {
            let name = &entry.name.text;
            let value = self.read(&scope, &entry.formula);
            let index = self
                .states
                .iter()
                .position(|state| state.name.text == *name);
            if let Some(index) = index {
                values[index] = Some(value);
            } else if name == TIME {
                self.uses_time = true;
                values[self.states.len()] = Some(value);
            } else if !self.states.is_empty() {
                let (states, nearest) = self.state_names(name);
                let name = name.clone();
                let kind = ModelErrorKind::InitialOfUnknownState {
                    name,
                    states,
                    nearest,
                };
                self.report(kind, &entry.name.place);
            }
        }
        self.check_initial(&values, flight);
        let zero = self.graph.number(0.0);
        values
            .into_iter()
            .map(|value| value.unwrap_or(zero))
            .collect()
    }

    fn check_initial(&mut self, values: &[Option<Expr>], flight: &Place) {
        let states = self.states.clone();
        let missing = states
            .iter()
            .zip(values)
            .filter(|(state, value)| value.is_none() && self.is_first(state));
        let missing: Vec<&Name> = missing.map(|(state, _)| &state.name).collect();
        if missing.len() > 1 && missing.len() == states.len() {
            let states = missing.iter().map(|name| name.text.clone()).collect();
            self.report(ModelErrorKind::NothingInitial { states }, flight);
            return;
        }
        for name in missing {
            let state = name.text.clone();
            self.report(ModelErrorKind::NoInitial { state }, &name.place);
        }
    }

    /// Whether no earlier state has this name.
    fn is_first(&self, state: &Entry) -> bool {
        let same = |other: &&&Entry| other.name.text == state.name.text;
        let first = self.states.iter().find(same);
        first.is_none_or(|&first| core::ptr::eq(first, state))
    }
}
