//! From a draft to a model: names are resolved, texts parsed, definitions written out, and everything checked that can
//! be wrong whatever the values of the parameters.

use super::dependency::dependency_order;
use super::draft::{ContactDraft, Draft, Entry, Formula, ImpulseDraft, Name, Place, SectionDraft};
use super::error::{ModelError, ModelErrorKind, Role};
use super::model::{Contact, Definition, Label, Model, Parameter, Section, State};
use super::names::{TIME, is_name_of, reserved_meaning};
use super::scope::{Purpose, Scope};
use crate::expressions::{Expr, Graph, Symbol, nearest};
use std::collections::HashMap;

impl Draft {
    /// Resolves, parses and checks everything. What has been reported before comes along.
    ///
    /// # Errors
    /// All that is wrong, in no particular order.
    pub fn assemble(self, reported: Vec<ModelError>) -> Result<Model, Vec<ModelError>> {
        let mut assembly = Assembly::new(&self, reported);
        let model = assembly.model(&self);
        let mut errors = assembly.errors;
        if errors.is_empty() {
            errors.extend(not_finite(&model, &self));
        }
        if errors.is_empty() {
            Ok(model)
        } else {
            Err(errors)
        }
    }
}

/// The work on one draft.
///
/// While formulas are read, definition number k stands as the parameter that comes k-th after the last real one, so that
/// definitions may come in any order; [`Assembly::settle`] writes them out. One more such parameter stands for whatever
/// could not be read.
struct Assembly<'a> {
    graph: Graph,
    errors: Vec<ModelError>,
    states: Vec<&'a Entry>,
    parameters: &'a [Entry],
    definitions: &'a [Entry],
    /// Definitions written out, so far as they are known.
    meanings: Vec<Expr>,
    used: Vec<bool>,
    uses_time: bool,
}

impl<'a> Assembly<'a> {
    fn new(draft: &'a Draft, errors: Vec<ModelError>) -> Self {
        let flight = draft.flight.iter().flat_map(|(_, entries)| entries);
        Self {
            graph: Graph::default(),
            errors,
            states: flight
                .flatten()
                .filter(|entry| entry.name.text != TIME)
                .collect(),
            parameters: &draft.parameters,
            definitions: &draft.definitions,
            meanings: Vec::new(),
            used: vec![false; draft.definitions.len()],
            uses_time: false,
        }
    }

    fn report(&mut self, kind: ModelErrorKind, place: &Place) {
        self.errors.push(ModelError::new(kind, place));
    }

    fn model(&mut self, draft: &'a Draft) -> Model {
        self.check_flight(draft);
        self.check_names(draft);
        let parameters = self.read_parameters();
        let definitions = self.read_definitions();
        let equations = self.equations();
        let derivatives: Vec<Expr> = (self.states.clone().into_iter())
            .map(|entry| self.read(&equations, &entry.formula))
            .collect();
        let mut contacts: Vec<Contact> = (draft.contacts.iter().enumerate())
            .map(|(index, contact)| self.contact(&equations, contact, index, draft))
            .collect();
        let sections = (draft.sections.iter())
            .map(|section| self.section(&equations, section))
            .collect();
        let flight = draft
            .flight
            .as_ref()
            .map_or(&draft.place, |(place, _)| place);
        let mut initial = self.read_initial(&draft.initial, flight);
        let mut states: Vec<State> = (self.states.iter().zip(derivatives).zip(&mut initial))
            .map(|((entry, derivative), initial)| State {
                name: entry.name.text.clone(),
                derivative,
                initial: *initial,
                label: None,
            })
            .collect();
        let time = self.uses_time.then_some(states.len());
        if time.is_some() {
            let zero = self.graph.number(0.0);
            contacts
                .iter_mut()
                .for_each(|contact| contact.impulse.push(zero));
            states.push(State {
                name: TIME.to_owned(),
                derivative: self.graph.number(1.0),
                initial: initial.last().copied().unwrap_or(zero),
                label: None,
            });
        }
        let mut model = Model {
            title: draft.title.clone(),
            source: draft.source.clone(),
            graph: core::mem::take(&mut self.graph),
            states,
            time,
            parameters,
            contacts,
            sections,
            definitions,
        };
        for (definition, &used) in model.definitions.iter_mut().zip(&self.used) {
            definition.used = used;
        }
        self.check_circles(&model);
        self.label(&mut model, draft);
        model
    }

    fn check_flight(&mut self, draft: &'a Draft) {
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
    fn check_names(&mut self, draft: &'a Draft) {
        let of = |role: Role| move |entry: &'a Entry| (role, &entry.name);
        let mut quantities: Vec<(Role, &Name)> = (self.states.iter().copied().map(of(Role::State)))
            .chain(self.parameters.iter().map(of(Role::Parameter)))
            .chain(self.definitions.iter().map(of(Role::Definition)))
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
                self.errors.push(error.with_related(&there.place, label));
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

    fn placeholder(&mut self, definition: usize) -> Expr {
        self.graph.parameter(self.parameters.len() + definition)
    }

    fn unreadable(&mut self) -> Expr {
        self.placeholder(self.definitions.len())
    }

    /// Reads a formula as it stands, definitions as placeholders.
    fn read_raw(&mut self, scope: &Scope, formula: &Formula) -> Expr {
        match scope.read(&mut self.graph, formula) {
            Ok(Some(expr)) => expr,
            Ok(None) => self.unreadable(),
            Err(error) => {
                self.errors.push(error);
                self.unreadable()
            }
        }
    }

    /// Reads a formula and writes out the definitions in it.
    fn read(&mut self, scope: &Scope, formula: &Formula) -> Expr {
        let raw = self.read_raw(scope, formula);
        self.settle(raw)
    }

    /// Reads a formula that may be missing, which is for the caller to report.
    fn read_optional(&mut self, scope: &Scope, formula: Option<&Formula>) -> Expr {
        match formula {
            Some(formula) => self.read(scope, formula),
            None => self.unreadable(),
        }
    }

    fn settle(&mut self, raw: Expr) -> Expr {
        let first = self.parameters.len();
        let definition = |symbol| match symbol {
            Symbol::Parameter(index) => index.checked_sub(first),
            Symbol::State(_) => None,
        };
        for used in self.graph.symbols(raw).into_iter().filter_map(definition) {
            if let Some(flag) = self.used.get_mut(used) {
                *flag = true;
            }
        }
        let meanings = &self.meanings;
        let settled = self
            .graph
            .substitute(raw, &|symbol| meanings.get(definition(symbol)?).copied());
        let time = Symbol::State(self.states.len());
        self.uses_time |= self.graph.symbols(settled).contains(&time);
        settled
    }

    fn read_parameters(&mut self) -> Vec<Parameter> {
        let mut scope = Scope::new(Purpose::Parameter);
        for (index, entry) in self.parameters.iter().enumerate() {
            scope.allow(&entry.name.text, self.graph.parameter(index));
        }
        for entry in &self.states {
            scope.bar(&entry.name.text, Role::State);
        }
        for entry in self.definitions {
            scope.bar(&entry.name.text, Role::Definition);
        }
        scope.bar(TIME, Role::Time);
        let parameters = self.parameters;
        let read = |entry: &Entry| Parameter {
            name: entry.name.text.clone(),
            value: self.read_raw(&scope, &entry.formula),
            label: None,
        };
        parameters.iter().map(read).collect()
    }

    /// Reads the definitions and writes them out, each after those it uses.
    fn read_definitions(&mut self) -> Vec<Definition> {
        let scope = self.equations();
        let raw: Vec<Expr> = (self.definitions.iter())
            .map(|entry| self.read_raw(&scope, &entry.formula))
            .collect();
        let (first, count) = (self.parameters.len(), self.definitions.len());
        let mut uses: Vec<Vec<usize>> = Vec::with_capacity(count);
        for &raw in &raw {
            let used = |symbol| match symbol {
                Symbol::Parameter(index) => index.checked_sub(first).filter(|&k| k < count),
                Symbol::State(_) => None,
            };
            uses.push(
                self.graph
                    .symbols(raw)
                    .into_iter()
                    .filter_map(used)
                    .collect(),
            );
        }
        let unreadable = self.unreadable();
        self.meanings = vec![unreadable; count];
        match dependency_order(&uses) {
            Ok(order) => {
                for index in order {
                    self.meanings[index] = self.settle(raw[index]);
                }
            }
            Err(circle) => self.report_circle(Role::Definition, self.definitions, &circle),
        }
        let entries = self.definitions.iter().zip(&self.meanings);
        entries
            .map(|(entry, &value)| Definition {
                name: entry.name.text.clone(),
                value,
                used: false,
            })
            .collect()
    }

    /// Names for equations of motion, gaps, surfaces and so on.
    fn equations(&mut self) -> Scope<'a> {
        let mut scope = Scope::new(Purpose::Equation);
        for (index, entry) in self.states.iter().enumerate() {
            scope.allow(&entry.name.text, self.graph.state(index));
        }
        for (index, entry) in self.parameters.iter().enumerate() {
            scope.allow(&entry.name.text, self.graph.parameter(index));
        }
        for (index, entry) in self.definitions.iter().enumerate() {
            scope.allow(&entry.name.text, self.placeholder(index));
        }
        scope.allow(TIME, self.graph.state(self.states.len()));
        scope
    }

    /// Names for initial values: parameters, and definitions that do not change.
    fn constants(&mut self) -> Scope<'a> {
        let mut scope = Scope::new(Purpose::Initial);
        for (index, entry) in self.parameters.iter().enumerate() {
            scope.allow(&entry.name.text, self.graph.parameter(index));
        }
        for (index, entry) in self.definitions.iter().enumerate() {
            if self.graph.depends_on_state(self.meanings[index]) {
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
    fn read_initial(&mut self, entries: &[Entry], flight: &Place) -> Vec<Expr> {
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
            .filter(|(_, value)| value.is_none());
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

    /// Names of the states, and the one nearest to `name`.
    fn state_names(&self, name: &str) -> (Vec<String>, Option<String>) {
        let names: Vec<String> = self
            .states
            .iter()
            .map(|state| state.name.text.clone())
            .collect();
        let nearest = nearest(name, names.iter().map(|name| &**name));
        (names, nearest)
    }

    fn contact(
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
            if !(0.0..1.0).contains(&value) {
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

    fn section(&mut self, scope: &Scope, section: &SectionDraft) -> Section {
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
        }
    }

    fn check_circles(&mut self, model: &Model) {
        if let Err(circle) = model.parameter_order() {
            self.report_circle(Role::Parameter, self.parameters, &circle);
        }
    }

    fn report_circle(&mut self, role: Role, entries: &[Entry], circle: &[usize]) {
        let names = circle
            .iter()
            .map(|&index| entries[index].name.text.clone())
            .collect();
        let kind = ModelErrorKind::Circle { role, names };
        self.report(kind, &entries[circle[0]].name.place);
    }

    fn label(&mut self, model: &mut Model, draft: &Draft) {
        for entry in &draft.labels {
            let name = &entry.name;
            let label: Label = entry.label.clone();
            if let Some(index) = model.state_index(&name.text) {
                model.states[index].label = Some(label);
            } else if let Some(index) = model.parameter_index(&name.text) {
                model.parameters[index].label = Some(label);
            } else {
                let known = model
                    .state_names()
                    .into_iter()
                    .chain(model.parameter_names());
                let nearest = nearest(&name.text, known);
                let name_text = name.text.clone();
                let kind = ModelErrorKind::LabelOfUnknownName {
                    name: name_text,
                    nearest,
                };
                self.report(kind, &name.place);
            }
        }
    }
}

/// The first parameter, else initial value, that is not finite, in a model that is right otherwise.
fn not_finite(model: &Model, draft: &Draft) -> Option<ModelError> {
    let (role, index, kind) = model.not_finite()?;
    let entry = match role {
        Role::State => {
            let name = &model.states[index].name;
            (draft.initial.iter()).find(|entry| entry.name.text == *name)
        }
        _ => draft.parameters.get(index),
    };
    let place = entry.map_or(&draft.place, |entry| &entry.formula.place);
    Some(ModelError::new(kind, place))
}
