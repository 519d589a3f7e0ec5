//! What was derived from a model, as formulas, and what looks wrong about it.

pub(super) mod corners;
pub(super) mod warning;

use self::warning::Warning;
use super::Model;
use super::mechanics::identically_zero::is_identically_zero;
use super::mechanics::{ContactMechanics, Mechanics, MechanicsError};
use super::model::Contact;
use crate::expressions::{Expr, Graph, Names, Symbol};
use std::collections::BTreeSet;

/// What [`check`] finds.
#[derive(Clone, PartialEq, Debug)]
pub struct Check {
    /// One for each contact whose impulse changes the rate of its gap, in order.
    pub contacts: Vec<ContactFormulas>,
    /// What looks wrong.
    pub warnings: Vec<Warning>,
}

/// What is derived for one contact, in the notation of model files.
#[derive(Clone, PartialEq, Debug)]
pub struct ContactFormulas {
    /// Name of the contact.
    pub name: String,
    /// h.
    pub gap: String,
    /// v = L_f h.
    pub rate: String,
    /// a = L_f v.
    pub acceleration: String,
    /// j = L_f a.
    pub jerk: String,
    /// b = L_W v.
    pub rate_per_impulse: String,
    /// The states that an impact changes, and what it makes of them (M1).
    pub impact: Vec<NamedFormula>,
    /// d/dt of each state while this contact alone is closed (M2).
    pub sticking: Vec<NamedFormula>,
}

/// A formula and what it is for.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NamedFormula {
    /// Name of the state.
    pub name: String,
    /// The formula, in the notation of model files.
    pub text: String,
}

/// Distances and rates below this are taken for the rounding of a start that is meant to be in contact.
const ROUNDING: f64 = 1e-12;

/// Contacts that are compared with each other: more than any flow takes.
const MOST_COMPARED: usize = 64;

/// Derives the mechanics of a model and looks for what its author may not have meant.
pub fn check(model: &Model) -> Check {
    let mut inspection = Inspection::new(model);
    inspection.contacts();
    inspection.start();
    inspection.sections();
    inspection.unused();
    Check {
        contacts: inspection.formulas,
        warnings: inspection.warnings,
    }
}

struct Inspection<'a> {
    model: &'a Model,
    state_names: Vec<String>,
    parameter_names: Vec<String>,
    parameters: Vec<f64>,
    initial: Vec<f64>,
    formulas: Vec<ContactFormulas>,
    warnings: Vec<Warning>,
}

impl<'a> Inspection<'a> {
    fn new(model: &'a Model) -> Self {
        let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
        let parameters = model.parameter_values(&[]);
        Self {
            model,
            state_names: owned(model.state_names()),
            parameter_names: owned(model.parameter_names()),
            initial: model.initial_state(&parameters),
            parameters,
            formulas: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn contacts(&mut self) {
        // A model of switches, or of events, needs none.
        let is_smooth = self.model.surfaces.is_empty()
            && self
                .model
                .sections
                .iter()
                .all(|section| section.reset.is_none());
        if self.model.contacts.is_empty() && is_smooth {
            self.warnings.push(Warning::NoContact);
        }
        for contact in &self.model.contacts {
            // Each by itself, so that one that is wrong does not hide the others.
            let alone = Model {
                contacts: vec![contact.clone()],
                ..self.model.clone()
            };
            match Mechanics::new(&alone) {
                Ok(mut mechanics) => self.contact(contact, &mut mechanics),
                Err(MechanicsError::ImpulseLeavesRate { contact }) => {
                    self.warnings.push(Warning::ImpulseLeavesRate { contact });
                }
                Err(error) => {
                    self.warnings.push(Warning::NotDerived { error });
                    return;
                }
            }
        }
        self.like_contacts();
    }

    /// Contacts that are one surface, or would be but for a constant factor.
    fn like_contacts(&mut self) {
        let contacts = &self.model.contacts;
        let mut graph = self.model.graph.clone();
        for (second, like) in contacts.iter().enumerate().take(MOST_COMPARED) {
            for contact in &contacts[..second] {
                // Proportional gaps a and b: a b(x0) - b a(x0) vanishes for every x.
                let [a, b] = [contact.gap, like.gap];
                let [a_start, b_start] = [a, b].map(|gap| {
                    let value = graph.evaluate(gap, &self.initial, &self.parameters);
                    if value == 0.0 { 1.0 } else { value }
                });
                let factors = [a_start, b_start].map(|value: f64| graph.number(value));
                let (left, right) = (graph.mul(factors[1], a), graph.mul(factors[0], b));
                let scaled = graph.sub(left, right);
                let plain = graph.sub(a, b);
                if [scaled, plain]
                    .iter()
                    .any(|&zero| self.vanishes(&graph, zero))
                {
                    self.warnings.push(Warning::LikeContacts {
                        contacts: [contact.name.clone(), like.name.clone()],
                    });
                }
            }
        }
    }

    fn contact(&mut self, contact: &Contact, mechanics: &mut Mechanics) {
        let derived = mechanics.contacts[0].clone();
        let name = || contact.name.clone();
        let graph = &mut mechanics.graph;
        let shift = graph.lie_derivative(contact.gap, &contact.impulse);
        if !self.vanishes(graph, shift) {
            let change = self.text(graph, shift);
            self.warnings.push(Warning::ImpulseMovesGap {
                contact: name(),
                change,
            });
        }
        let bend = second_derivative_along(graph, derived.rate, &contact.impulse);
        if !self.vanishes(graph, bend) {
            self.warnings
                .push(Warning::RateNotAffine { contact: name() });
        }
        self.contact_start(graph, &derived);
        if let Ok(sticking) = mechanics.sticking(&[0]) {
            let formulas = self.formulas_of(&mechanics.graph, &derived, &sticking.field);
            self.formulas.push(formulas);
        }
    }

    /// What is odd about a contact at the initial state.
    fn contact_start(&mut self, graph: &Graph, derived: &ContactMechanics) {
        let contact = || derived.name.clone();
        let rate = self.at_start(graph, derived.rate);
        // Choices in a restitution are made for rates as they are at impacts: it says nothing of a state that moves away.
        let is_fixed = !graph.depends_on_state(derived.restitution);
        let value = self.at_start(graph, derived.restitution);
        if !(0.0..=1.0).contains(&value) && (is_fixed || rate <= 0.0) {
            self.warnings.push(Warning::Restitution {
                contact: contact(),
                value,
            });
        }
        let gap = self.at_start(graph, derived.gap);
        let acceleration = self.at_start(graph, derived.acceleration);
        let per_impulse = self.at_start(graph, derived.rate_per_impulse);
        let values = [
            ("gap", gap),
            ("rate", rate),
            ("acceleration", acceleration),
            ("rate per impulse", per_impulse),
        ];
        let mut finite = true;
        for (what, value) in values {
            if !value.is_finite() {
                let what = format!("the {what} of contact `{}`", derived.name);
                self.warnings.push(Warning::NotFinite { what, value });
                finite = false;
            }
        }
        if !finite {
            return;
        }
        if per_impulse == 0.0 {
            self.warnings
                .push(Warning::NoImpactAtStart { contact: contact() });
        }
        if gap < -ROUNDING {
            self.warnings.push(Warning::NegativeGap {
                contact: contact(),
                gap,
            });
        } else if gap <= ROUNDING && rate < -ROUNDING {
            self.warnings.push(Warning::StartsWithImpact {
                contact: contact(),
                rate,
            });
        }
    }

    fn start(&mut self) {
        for (index, state) in self.model.states.iter().enumerate() {
            let value = self.at_start(&self.model.graph, state.derivative);
            if !value.is_finite() {
                let what = format!("d/dt of `{}`", self.state_names[index]);
                self.warnings.push(Warning::NotFinite { what, value });
            }
        }
    }

    fn sections(&mut self) {
        for section in &self.model.sections {
            if !self.model.graph.depends_on_state(section.surface) {
                let section = section.name.clone();
                self.warnings.push(Warning::SectionWithoutState { section });
            }
        }
    }

    fn unused(&mut self) {
        let used = self.used_symbols();
        let model = self.model;
        for (index, parameter) in model.parameters.iter().enumerate() {
            if !used.contains(&Symbol::Parameter(index)) {
                let name = parameter.name.clone();
                self.warnings.push(Warning::UnusedParameter { name });
            }
        }
        for definition in model
            .definitions
            .iter()
            .filter(|definition| !definition.used)
        {
            let name = definition.name.clone();
            self.warnings.push(Warning::UnusedDefinition { name });
        }
        for (index, state) in model.states.iter().enumerate() {
            if !used.contains(&Symbol::State(index)) && model.time != Some(index) {
                let name = state.name.clone();
                self.warnings.push(Warning::UnusedState { name });
            }
        }
    }

    /// Every symbol that some equation of the model has in it.
    fn used_symbols(&self) -> BTreeSet<Symbol> {
        let model = self.model;
        let initial = model.states.iter().map(|state| state.initial);
        let parameters = model.parameters.iter().map(|parameter| parameter.value);
        let sections = model.sections.iter().map(|section| section.surface);
        let definitions = model.definitions.iter().map(|definition| definition.value);
        let all: Vec<Expr> = (model.equations().into_iter())
            .chain(
                (initial.chain(parameters))
                    .chain(sections)
                    .chain(definitions),
            )
            .collect();
        model.graph.symbols_of(&all)
    }

    fn formulas_of(
        &self,
        graph: &Graph,
        derived: &ContactMechanics,
        sticking: &[Expr],
    ) -> ContactFormulas {
        let named = |index: usize, expr: Expr| NamedFormula {
            name: self.state_names[index].clone(),
            text: self.text(graph, expr),
        };
        let changed = |&(index, &after): &(usize, &Expr)| *graph.node(after) != state_node(index);
        let after = derived.after_impact.iter().enumerate().filter(changed);
        ContactFormulas {
            name: derived.name.clone(),
            gap: self.text(graph, derived.gap),
            rate: self.text(graph, derived.rate),
            acceleration: self.text(graph, derived.acceleration),
            jerk: self.text(graph, derived.jerk),
            rate_per_impulse: self.text(graph, derived.rate_per_impulse),
            impact: after.map(|(index, &after)| named(index, after)).collect(),
            sticking: sticking
                .iter()
                .enumerate()
                .map(|(index, &expr)| named(index, expr))
                .collect(),
        }
    }

    fn text(&self, graph: &Graph, expr: Expr) -> String {
        let names = Names {
            states: &self.state_names,
            parameters: &self.parameter_names,
        };
        graph.to_text(expr, names)
    }

    fn at_start(&self, graph: &Graph, expr: Expr) -> f64 {
        graph.evaluate(expr, &self.initial, &self.parameters)
    }

    fn vanishes(&self, graph: &Graph, expr: Expr) -> bool {
        is_identically_zero(graph, expr, self.initial.len(), self.parameters.len())
    }
}

fn state_node(index: usize) -> crate::expressions::Node {
    crate::expressions::Node::Symbol(Symbol::State(index))
}

/// The second derivative of `expr` along a straight line in the direction `direction` has here.
fn second_derivative_along(graph: &mut Graph, expr: Expr, direction: &[Expr]) -> Expr {
    let mut terms = Vec::with_capacity(direction.len());
    for (index, &component) in direction.iter().enumerate() {
        let slope = graph.derivative(expr, Symbol::State(index));
        let bend = graph.lie_derivative(slope, direction);
        terms.push(graph.mul(component, bend));
    }
    graph.sum(&terms)
}
