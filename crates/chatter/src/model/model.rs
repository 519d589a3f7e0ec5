//! An impacting system as its equations.

use super::direction::Direction;
use super::drawing::Shape;
use super::simultaneous::Simultaneous;
use crate::expressions::{Expr, Graph, Symbol};
use crate::numerics::Real;

/// An impacting system (MATH.md 1): `dx/dt = f(x, p)` in flight, and contacts that change the state at impacts.
///
/// All expressions are handles into [`graph`](Self::graph). States are numbered as in [`states`](Self::states),
/// parameters as in [`parameters`](Self::parameters).
#[derive(Clone, Debug)]
pub struct Model {
    /// What the model is called, in words.
    pub title: Option<String>,
    /// Where it was published.
    pub source: Option<String>,
    /// Holds every expression of the model.
    pub graph: Graph,
    /// States in the order of the file; time, where the model needs it, comes last.
    pub states: Vec<State>,
    /// Place of time `t` among the states, if the equations use it. Its derivative is 1.
    pub time: Option<usize>,
    /// Parameters in the order of the file.
    pub parameters: Vec<Parameter>,
    /// What happens where several contacts touch at one instant.
    pub simultaneous: Simultaneous,
    /// Contacts in the order of the file.
    pub contacts: Vec<Contact>,
    /// Named surfaces in the order of the file.
    pub sections: Vec<Section>,
    /// Named expressions in the order of the file.
    pub definitions: Vec<Definition>,
    /// Surfaces where an expression changes its form, as formulas: what events of sliding and switching are told with.
    pub surfaces: Vec<String>,
    /// What the mechanism looks like, part by part in the order of the file.
    pub drawing: Vec<Shape>,
}

/// One component of the state.
#[derive(Clone, Debug)]
pub struct State {
    /// Its name in expressions.
    pub name: String,
    /// `dx/dt` in free flight.
    pub derivative: Expr,
    /// The same as it was written: with roots of squares, and tables of steps that the motion may come to rest on.
    pub written: Expr,
    /// Value where a trajectory starts unless told otherwise; depends on parameters only.
    pub initial: Expr,
    /// How plots call it.
    pub label: Option<Label>,
}

/// A constant of the model.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name in expressions.
    pub name: String,
    /// A number, or an expression in other parameters.
    pub value: Expr,
    /// How plots call it.
    pub label: Option<Label>,
}

/// Words for the axis of a plot.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Label {
    /// What the quantity is, such as `valve lift $y_1$`.
    pub text: Option<String>,
    /// Its unit, such as `mm`.
    pub unit: Option<String>,
}

/// A unilateral constraint `gap >= 0` and what an impact does there.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Its name in output.
    pub name: String,
    /// The contact function h.
    pub gap: Expr,
    /// The direction W in which an impact changes the state, one component a state. Its length does not matter.
    pub impulse: Vec<Expr>,
    /// The restitution r, in [0, 1].
    pub restitution: Expr,
    /// The state after an impact, one component a state, where that is given in place of impulse and restitution.
    pub reset: Option<Vec<Expr>>,
    /// Dry friction along the surface.
    pub friction: Option<Friction>,
}

/// Coulomb's friction in a contact: the tangential force is at most the coefficient times the normal one, and opposes
/// the sliding.
#[derive(Clone, Debug)]
pub struct Friction {
    /// The coefficient mu, not negative.
    pub coefficient: Expr,
    /// The direction W_t in which a tangential impulse changes the state, in the unit of the contact's impulse.
    pub along: Vec<Expr>,
    /// The rate of sliding v_t, which a positive tangential impulse makes larger.
    pub rate: Expr,
}

/// A named surface where trajectories are looked at.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its name on the command line.
    pub name: String,
    /// The function that vanishes on the surface.
    pub surface: Expr,
    /// Which crossings count.
    pub direction: Direction,
    /// The state after a crossing, one component a state, if this is an event that changes it.
    pub reset: Option<Vec<Expr>>,
}

/// A named expression, written out wherever it is used.
#[derive(Clone, Debug)]
pub struct Definition {
    /// Its name in expressions.
    pub name: String,
    /// What it stands for.
    pub value: Expr,
    /// Whether another equation names it.
    pub used: bool,
}

impl Model {
    /// Position of the state called `name`.
    pub fn state_index(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|state| state.name == name)
    }

    /// Position of the parameter called `name`.
    pub fn parameter_index(&self, name: &str) -> Option<usize> {
        let same = |parameter: &Parameter| parameter.name == name;
        self.parameters.iter().position(same)
    }

    /// Position of the contact called `name`.
    pub fn contact_index(&self, name: &str) -> Option<usize> {
        self.contacts
            .iter()
            .position(|contact| contact.name == name)
    }

    /// The section called `name`.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.name == name)
    }

    /// State names, in order.
    pub fn state_names(&self) -> Vec<&str> {
        self.states.iter().map(|state| &*state.name).collect()
    }

    /// Parameter names, in order.
    pub fn parameter_names(&self) -> Vec<&str> {
        let parameters = self.parameters.iter();
        parameters
            .map(|parameter| parameter.name.as_str())
            .collect()
    }

    /// Shows every expression that a trajectory is made by, so that it may be another one.
    pub(super) fn for_each_expression<'a>(&'a mut self, mut show: impl FnMut(&'a mut Expr)) {
        for state in &mut self.states {
            show(&mut state.derivative);
        }
        for contact in &mut self.contacts {
            show(&mut contact.gap);
            contact.impulse.iter_mut().for_each(&mut show);
            show(&mut contact.restitution);
            contact.reset.iter_mut().flatten().for_each(&mut show);
            if let Some(friction) = &mut contact.friction {
                show(&mut friction.coefficient);
                friction.along.iter_mut().for_each(&mut show);
                show(&mut friction.rate);
            }
        }
        for section in &mut self.sections {
            show(&mut section.surface);
            section.reset.iter_mut().flatten().for_each(&mut show);
        }
    }

    /// The vector field of free flight, one component a state.
    pub fn field(&self) -> Vec<Expr> {
        self.states.iter().map(|state| state.derivative).collect()
    }

    /// Parameter values in order. Each of `overrides` (position, value) replaces what the model says; parameters
    /// defined through it follow. Parameters that use each other in a circle are NaN, which no reader of models lets
    /// through.
    pub fn parameter_values<R: Real>(&self, overrides: &[(usize, R)]) -> Vec<R> {
        let mut values: Vec<R> = self.parameters.iter().map(|_| R::splat(f64::NAN)).collect();
        let order = self
            .parameter_order()
            .unwrap_or_else(|_| (0..self.parameters.len()).collect());
        for index in order {
            let overridden = overrides.iter().rev().find(|(at, _)| *at == index);
            values[index] = match overridden {
                Some(&(_, value)) => value,
                None => self
                    .graph
                    .evaluate(self.parameters[index].value, &[], &values),
            };
        }
        values
    }

    /// The parameters at these positions and those defined through them.
    pub fn with_dependents(&self, positions: &[usize]) -> Vec<usize> {
        let mut moving = positions.to_vec();
        loop {
            let depends = |value: Expr| {
                let symbols = self.graph.symbols(value);
                (moving.iter()).any(|&index| symbols.contains(&Symbol::Parameter(index)))
            };
            let found = (0..self.parameters.len())
                .find(|index| !moving.contains(index) && depends(self.parameters[*index].value));
            match found {
                Some(index) => moving.push(index),
                None => return moving,
            }
        }
    }

    /// The state a trajectory starts from, at these parameter values.
    pub fn initial_state<R: Real>(&self, parameters: &[R]) -> Vec<R> {
        let value = |state: &State| self.graph.evaluate(state.initial, &[], parameters);
        self.states.iter().map(value).collect()
    }
}
