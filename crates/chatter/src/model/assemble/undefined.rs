//! Whether everything that was written has a value, as far as parameters decide it.

use crate::expressions::{Expr, Function, Graph, Node, Symbol};
use crate::model::Model;
use crate::model::error::{ModelError, ModelErrorKind};
use crate::model::source::draft::Place;
use core::fmt;

/// A formula of a model, by what it is for and its position.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::model) enum Written {
    Parameter(usize),
    Initial(usize),
    Definition(usize),
    Derivative(usize),
    Gap(usize),
    /// Contact and state.
    Impulse(usize, usize),
    Restitution(usize),
    Surface(usize),
}

/// A formula that has no finite value whatever the state.
pub(in crate::model) struct Undefined {
    pub written: Written,
    pub kind: ModelErrorKind,
}

impl Model {
    /// Checks that every formula has a finite value, as far as parameters decide it: parameters and initial values, and in
    /// all others whatever no state changes, such as `1/m`.
    ///
    /// # Errors
    /// The first that has none, and what it is at these values.
    pub fn check_defined(&self) -> Result<(), ModelError> {
        match self.undefined() {
            Some(found) => Err(ModelError::new(found.kind, &Place::named("the model"))),
            None => Ok(()),
        }
    }

    /// The first formula that has no finite value for lack of one of what no state changes.
    pub(in crate::model) fn undefined(&self) -> Option<Undefined> {
        let parameters = self.parameter_values::<f64>(&[]);
        let written = self.written();
        let all: Vec<Expr> = written.iter().map(|&(_, expr)| expr).collect();
        if !has_undefined(&self.graph, &all, &parameters) {
            return None;
        }
        (written.into_iter())
            .find_map(|(written, expr)| self.undefined_in(written, expr, &parameters))
    }

    /// The same among parameters and initial values alone.
    pub(in crate::model) fn undefined_constant(&self) -> Option<Undefined> {
        let parameters = self.parameter_values::<f64>(&[]);
        let constant = |written| matches!(written, Written::Parameter(_) | Written::Initial(_));
        let mut constants = (self.written().into_iter()).filter(|&(written, _)| constant(written));
        constants.find_map(|(written, expr)| self.undefined_in(written, expr, &parameters))
    }

    fn undefined_in(&self, written: Written, expr: Expr, parameters: &[f64]) -> Option<Undefined> {
        let (part, value) = undefined_part(&self.graph, expr, parameters)?;
        let whole = Name {
            model: self,
            written,
        };
        let what = match written {
            Written::Parameter(_) | Written::Initial(_) => whole.to_string(),
            _ if part == expr => format!("{whole}, `{}`,", self.formula(part)),
            _ => format!("`{}` in {whole}", self.formula(part)),
        };
        let kind = ModelErrorKind::NotFinite { what, value };
        Some(Undefined { written, kind })
    }

    /// Every formula, in the order in which an author would look at them.
    fn written(&self) -> Vec<(Written, Expr)> {
        let mut all = Vec::new();
        let parameters = self.parameters.iter().map(|parameter| parameter.value);
        all.extend(
            parameters
                .enumerate()
                .map(|(k, e)| (Written::Parameter(k), e)),
        );
        let initial = self.states.iter().map(|state| state.initial);
        all.extend(initial.enumerate().map(|(k, e)| (Written::Initial(k), e)));
        let definitions = self.definitions.iter().map(|definition| definition.value);
        all.extend(
            definitions
                .enumerate()
                .map(|(k, e)| (Written::Definition(k), e)),
        );
        let derivatives = self.states.iter().map(|state| state.derivative);
        all.extend(
            derivatives
                .enumerate()
                .map(|(k, e)| (Written::Derivative(k), e)),
        );
        for (index, contact) in self.contacts.iter().enumerate() {
            all.push((Written::Gap(index), contact.gap));
            let impulse = contact.impulse.iter().enumerate();
            all.extend(impulse.map(|(state, &e)| (Written::Impulse(index, state), e)));
            all.push((Written::Restitution(index), contact.restitution));
        }
        let surfaces = self.sections.iter().map(|section| section.surface);
        all.extend(surfaces.enumerate().map(|(k, e)| (Written::Surface(k), e)));
        all
    }
}

/// The name of a formula in a message.
struct Name<'m> {
    model: &'m Model,
    written: Written,
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = self.model;
        let state = |index: usize| &model.states[index].name;
        let contact = |index: usize| &model.contacts[index].name;
        match self.written {
            Written::Parameter(k) => write!(f, "parameter `{}`", model.parameters[k].name),
            Written::Initial(k) => write!(f, "the initial value of `{}`", state(k)),
            Written::Definition(k) => write!(f, "definition `{}`", model.definitions[k].name),
            Written::Derivative(k) => write!(f, "d/dt of `{}`", state(k)),
            Written::Gap(k) => write!(f, "the gap of contact `{}`", contact(k)),
            Written::Impulse(k, of) => {
                write!(
                    f,
                    "the impulse on `{}` of contact `{}`",
                    state(of),
                    contact(k)
                )
            }
            Written::Restitution(k) => write!(f, "the restitution of contact `{}`", contact(k)),
            Written::Surface(k) => write!(f, "the surface of section `{}`", model.sections[k].name),
        }
    }
}

/// What formulas are made of, with values where no state is, and whether states change them. Without pieces that are not chosen, where parameters alone
/// choose: these may be of use elsewhere.
struct Parts {
    parts: Vec<Expr>,
    values: Vec<f64>,
    /// By the index of the expression.
    moves: Vec<bool>,
}

impl Parts {
    fn new(graph: &Graph, roots: &[Expr], parameters: &[f64]) -> Self {
        let all = graph.reachable(roots);
        let values = graph.evaluate_all::<f64>(&all, &[], parameters);
        let size = all.last().map_or(0, |part| part.index() + 1);
        let mut moves = vec![false; size];
        for &part in &all {
            let mut moved = matches!(graph.node(part), Node::Symbol(Symbol::State(_)));
            graph.for_each_operand(part, |operand| moved |= moves[operand.index()]);
            moves[part.index()] = moved;
        }
        let value = |part: Expr| all.binary_search(&part).map_or(f64::NAN, |at| values[at]);
        let mut is_asked = vec![false; size];
        roots.iter().for_each(|root| is_asked[root.index()] = true);
        for &part in all.iter().rev() {
            if !is_asked[part.index()] {
                continue;
            }
            let chosen = match *graph.node(part) {
                Node::Switch {
                    surface,
                    above,
                    below,
                    edge,
                } if !moves[surface.index()] => edge
                    .chosen(value(surface), above, below)
                    .map(|piece| [surface, piece]),
                _ => None,
            };
            match chosen {
                Some(operands) => {
                    (operands.into_iter()).for_each(|operand| is_asked[operand.index()] = true);
                }
                None => graph.for_each_operand(part, |operand| is_asked[operand.index()] = true),
            }
        }
        let pairs = all.iter().copied().zip(values.iter().copied());
        let (parts, values) = pairs.filter(|(part, _)| is_asked[part.index()]).unzip();
        Self {
            parts,
            values,
            moves,
        }
    }

    fn value(&self, part: Expr) -> f64 {
        let found = self.parts.binary_search(&part);
        found.map_or(f64::NAN, |place| self.values[place])
    }

    /// Those that no state changes, with their values.
    fn fixed(&self) -> impl Iterator<Item = (Expr, f64)> {
        let all = self.parts.iter().copied().zip(self.values.iter().copied());
        all.filter(|(part, _)| !self.moves[part.index()])
    }
}

/// Whether any part that no state changes has no finite value: formulas share their parts, and are looked at one by one only then.
fn has_undefined(graph: &Graph, all: &[Expr], parameters: &[f64]) -> bool {
    let parts = Parts::new(graph, all, parameters);
    parts
        .fixed()
        .any(|(part, own)| !own.is_finite() || leaves_domain(graph, part, &parts))
}

/// The first part of an expression that no state changes and that has no finite value at these parameters, as large as
/// there is, with its value.
fn undefined_part(graph: &Graph, expr: Expr, parameters: &[f64]) -> Option<(Expr, f64)> {
    let all = Parts::new(graph, &[expr], parameters);
    let size = expr.index() + 1;
    let (mut outside, mut undefined) = (vec![false; size], vec![None; size]);
    for (&part, &own) in all.parts.iter().zip(&all.values) {
        let at = part.index();
        graph.for_each_operand(part, |operand| {
            undefined[at] = undefined[at].or(undefined[operand.index()]);
        });
        if !all.moves[at] && undefined[at].is_none() && leaves_domain(graph, part, &all) {
            undefined[at] = Some(own);
        }
    }
    // What something that moves is made of, or the whole.
    outside[expr.index()] = true;
    for part in all.parts.iter().filter(|part| all.moves[part.index()]) {
        graph.for_each_operand(*part, |operand| outside[operand.index()] = true);
    }
    all.fixed()
        .filter(|(part, _)| outside[part.index()])
        .find_map(|(part, own)| match undefined[part.index()] {
            _ if !own.is_finite() => Some((part, own)),
            Some(inside) => Some((part, inside)),
            None => None,
        })
}

/// Whether an operation on finite values has none, overflow aside.
fn leaves_domain(graph: &Graph, part: Expr, all: &Parts) -> bool {
    let value = |part: Expr| all.value(part);
    match *graph.node(part) {
        Node::Power(base, exponent) => {
            let (base, exponent) = (value(base), value(exponent));
            let finite = base.is_finite() && exponent.is_finite();
            finite && (value(part).is_nan() || (base == 0.0 && exponent < 0.0))
        }
        Node::Call(Function::Ln | Function::Asin | Function::Acos, argument) => {
            value(argument).is_finite() && !value(part).is_finite()
        }
        _ => false,
    }
}
