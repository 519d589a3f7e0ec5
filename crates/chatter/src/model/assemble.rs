//! From a draft to a model: names are resolved, texts parsed, definitions written out, and everything checked that can
//! be wrong whatever the values of the parameters.

mod contacts;
mod corners;
mod dependency;
mod initial;
mod naming;
mod overrides;
pub(super) mod scope;
mod tables;
mod undefined;

use self::dependency::dependency_order;
use self::scope::{Purpose, Scope};
use self::undefined::Written;
use super::drawing::Shape;
use super::error::{ModelError, ModelErrorKind, Role};
use super::model::{Contact, Definition, Label, Model, Parameter, Section, State};
use super::names::TIME;
use super::source::draft::{Draft, Entry, Formula, Place};
use crate::expressions::{Expr, Graph, Symbol, nearest};

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
            errors.extend(undefined(&model, &self));
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
        self.read_tables(draft);
        let parameters = self.read_parameters();
        let definitions = self.read_definitions();
        let equations = self.equations();
        let derivatives: Vec<Expr> = (self.states.clone().into_iter())
            .map(|entry| self.read(&equations, &entry.formula))
            .collect();
        let mut contacts: Vec<Contact> = (draft.contacts.iter().enumerate())
            .map(|(index, contact)| self.contact(&equations, contact, index, draft))
            .collect();
        let mut sections: Vec<Section> = (draft.sections.iter())
            .map(|section| self.section(&equations, section))
            .collect();
        // A drawing changes nothing of the motion: that it names time does not make time a state.
        let uses_time = self.uses_time;
        let drawing: Vec<Shape> = (draft.drawing.iter())
            .map(|shape| Shape {
                kind: shape.kind,
                numbers: (shape.numbers.iter())
                    .map(|formula| self.read(&equations, formula))
                    .collect(),
            })
            .collect();
        self.uses_time = uses_time;
        let flight = draft
            .flight
            .as_ref()
            .map_or(&draft.place, |(place, _)| place);
        let mut initial = self.read_initial(&draft.initial, flight);
        let mut states: Vec<State> = (self.states.iter().zip(derivatives).zip(&mut initial))
            .map(|((entry, derivative), initial)| State {
                name: entry.name.text.clone(),
                derivative,
                written: derivative,
                initial: *initial,
                label: None,
            })
            .collect();
        let time = self.uses_time.then_some(states.len());
        if time.is_some() {
            let zero = self.graph.number(0.0);
            let time = self.graph.state(states.len());
            for contact in &mut contacts {
                contact.impulse.push(zero);
                contact.reset.iter_mut().for_each(|reset| reset.push(time));
                (contact.friction.iter_mut()).for_each(|friction| friction.along.push(zero));
            }
            for section in &mut sections {
                section.reset.iter_mut().for_each(|reset| reset.push(time));
            }
            states.push(State {
                name: TIME.to_owned(),
                derivative: self.graph.number(1.0),
                written: self.graph.number(1.0),
                initial: initial.last().copied().unwrap_or(zero),
                label: None,
            });
        }
        for contact in &mut contacts {
            contact.decide_at_impact(&mut self.graph, &states);
            contact.as_impulse(&mut self.graph, &states, parameters.len());
        }
        let mut model = Model {
            title: draft.title.clone(),
            source: draft.source.clone(),
            graph: core::mem::take(&mut self.graph),
            states,
            time,
            parameters,
            simultaneous: draft.simultaneous,
            contacts,
            sections,
            definitions,
            surfaces: Vec::new(),
            drawing,
        };
        for (definition, &used) in model.definitions.iter_mut().zip(&self.used) {
            definition.used = used;
        }
        self.check_circles(&model);
        self.label(&mut model, draft);
        model.take_sizes();
        model.part_jumps();
        model.surfaces = model.surface_names();
        model
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
        let symbols = self.graph.symbols(raw);
        let time = Symbol::State(self.states.len());
        let names_time = symbols.contains(&time);
        for used in symbols.into_iter().filter_map(definition) {
            if let Some(flag) = self.used.get_mut(used) {
                *flag = true;
            }
        }
        let meanings = &self.meanings;
        let settled = self
            .graph
            .substitute(raw, &|symbol| meanings.get(definition(symbol)?).copied());
        // Time that comes in by a definition was met when that was settled.
        if names_time && !self.uses_time {
            self.uses_time = self.graph.symbols(settled).contains(&time);
        }
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

/// The first formula without a value, in a model that is right otherwise.
fn undefined(model: &Model, draft: &Draft) -> Option<ModelError> {
    let found = model.undefined()?;
    let named = |entries: &'_ [Entry], index: usize| {
        let name = &model.states[index].name;
        let entry = entries.iter().find(|entry| entry.name.text == *name)?;
        Some(entry.formula.place.clone())
    };
    let place = |formula: &Option<Formula>| Some(formula.as_ref()?.place.clone());
    let place = match found.written {
        Written::Parameter(k) => Some(draft.parameters[k].formula.place.clone()),
        Written::Definition(k) => Some(draft.definitions[k].formula.place.clone()),
        Written::Initial(k) => named(&draft.initial, k),
        Written::Derivative(k) => (draft.flight.as_ref())
            .and_then(|(_, entries)| named(entries.as_deref().unwrap_or_default(), k)),
        Written::Gap(k) => place(&draft.contacts[k].gap),
        Written::Impulse(k, state) => (draft.contacts[k].impulse.as_ref())
            .and_then(|impulse| named(impulse.components.as_deref().unwrap_or_default(), state)),
        Written::Restitution(k) => place(&draft.contacts[k].restitution),
        Written::Surface(k) => place(&draft.sections[k].surface),
    };
    Some(ModelError::new(
        found.kind,
        &place.unwrap_or_else(|| draft.place.clone()),
    ))
}
