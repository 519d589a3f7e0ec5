//! Changing what a model says: parameters, initial values, and expressions asked for later.

use super::scope::{Purpose, Scope};
use crate::expressions::{Expr, Graph, ParseError, nearest};
use crate::model::Model;
use crate::model::error::{ModelError, ModelErrorKind, Role};
use crate::model::names::TIME;
use crate::model::source::draft::{Content, Formula, Place};

impl Model {
    /// Gives a parameter another value: a number or an expression in other parameters.
    ///
    /// # Errors
    /// There is no such parameter, the text is no expression in parameters, the parameter would depend on itself, or
    /// some parameter or initial value would not be finite. The model is then unchanged.
    pub fn set_parameter(&mut self, name: &str, text: &str) -> Result<(), ModelError> {
        let place = Place::whole(name, text);
        let Some(index) = self.parameter_index(name) else {
            let known = self.parameter_names();
            return Err(unknown(name, Role::Parameter, &known));
        };
        let mut scope = Scope::new(Purpose::Parameter);
        for (index, parameter) in self.parameters.iter().enumerate() {
            scope.allow(&parameter.name, self.graph.parameter(index));
        }
        for state in &self.states {
            scope.bar(&state.name, Role::State);
        }
        for definition in &self.definitions {
            scope.bar(&definition.name, Role::Definition);
        }
        scope.bar(TIME, Role::Time);
        let value = read(&mut self.graph, &scope, text, &place)?;
        let before = core::mem::replace(&mut self.parameters[index].value, value);
        let outcome = self.check_constants(&place);
        if outcome.is_err() {
            self.parameters[index].value = before;
        }
        outcome
    }

    /// Gives a state another initial value: a number or an expression in parameters. Time is a state here, called `t`.
    ///
    /// # Errors
    /// There is no such state, the text is no expression in parameters, or the value is not finite. The model is then
    /// unchanged.
    pub fn set_initial(&mut self, name: &str, text: &str) -> Result<(), ModelError> {
        let place = Place::whole(name, text);
        let Some(index) = self.state_index(name) else {
            let known = self.state_names();
            return Err(unknown(name, Role::State, &known));
        };
        let mut scope = Scope::new(Purpose::Initial);
        for (index, parameter) in self.parameters.iter().enumerate() {
            scope.allow(&parameter.name, self.graph.parameter(index));
        }
        let values: Vec<Expr> = self.definitions.iter().map(|one| one.value).collect();
        let changes = self.graph.depend_on_state(&values);
        for (definition, changes) in self.definitions.iter().zip(changes) {
            if changes {
                scope.bar(&definition.name, Role::Definition);
            } else {
                scope.allow(&definition.name, definition.value);
            }
        }
        for state in &self.states {
            scope.bar(&state.name, Role::State);
        }
        scope.bar(TIME, Role::Time);
        let value = read(&mut self.graph, &scope, text, &place)?;
        let before = core::mem::replace(&mut self.states[index].initial, value);
        let outcome = self.check_constants(&place);
        if outcome.is_err() {
            self.states[index].initial = before;
        }
        outcome
    }

    /// Reads an expression in states, parameters and definitions (and `t`, if the model has time).
    ///
    /// # Errors
    /// The first thing that is wrong with the text.
    pub fn parse_expression(&mut self, text: &str) -> Result<Expr, ParseError> {
        let mut names: Vec<(&str, Expr)> = Vec::new();
        for (index, state) in self.states.iter().enumerate() {
            names.push((&state.name, self.graph.state(index)));
        }
        for (index, parameter) in self.parameters.iter().enumerate() {
            names.push((&parameter.name, self.graph.parameter(index)));
        }
        for definition in &self.definitions {
            names.push((&definition.name, definition.value));
        }
        let known: Vec<&str> = names.iter().map(|&(name, _)| name).collect();
        let resolve = |name: &str| {
            names
                .iter()
                .find(|(known, _)| *known == name)
                .map(|&(_, expr)| expr)
        };
        self.graph.parse(text, &resolve, &known)
    }

    /// No parameter depends on itself, and all parameters and initial values are finite.
    fn check_constants(&self, place: &Place) -> Result<(), ModelError> {
        if let Err(circle) = self.parameter_order() {
            let name = |&index: &usize| self.parameters[index].name.clone();
            let names = circle.iter().map(name).collect();
            let kind = ModelErrorKind::Circle {
                role: Role::Parameter,
                names,
            };
            return Err(ModelError::new(kind, place));
        }
        match self.undefined_constant() {
            Some(found) => Err(ModelError::new(found.kind, place)),
            None => Ok(()),
        }
    }
}

fn read(graph: &mut Graph, scope: &Scope, text: &str, place: &Place) -> Result<Expr, ModelError> {
    let formula = Formula {
        content: Content::Text(text.to_owned()),
        place: place.clone(),
    };
    let expr = scope.read(graph, &formula)?;
    Ok(expr.unwrap_or_else(|| graph.number(f64::NAN)))
}

fn unknown(name: &str, role: Role, known: &[&str]) -> ModelError {
    let kind = ModelErrorKind::UnknownName {
        name: name.to_owned(),
        role,
        known: known.iter().map(|&known| known.to_owned()).collect(),
        nearest: nearest(name, known.iter().copied()),
    };
    ModelError::new(kind, &Place::whole(name, name))
}
