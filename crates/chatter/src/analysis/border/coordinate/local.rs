//! Local coordinates after an impact, and their derivatives from impact to impact.

use crate::expressions::{Expansion, Expr, Graph, Symbol, Tape};
use crate::flow::{Column, Direction};
use crate::model::{Mechanics, Model};
use crate::numerics::{Matrix, Real, dot};
use serde::{Deserialize, Serialize};

/// How u = j w / nu^2 and nu = -a are read off the state after an impact. All choices agree to leading order in nu, so
/// the limits X and N are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LocalCoordinate {
    /// Acceleration and jerk where the state is, with the rate after the impact.
    #[default]
    AtImpact,
    /// Acceleration and jerk of the state brought to rest on the contact, x - v W / b. For the valve this is the paper's
    /// nu = delta - y3.
    AtRest,
}

/// Rate w, acceleration a and jerk j after an impact as functions of the state, and how they, the state itself and its place change
/// along columns of derivatives from impact to impact. Its place is what is left of it without rate and acceleration, taken away along
/// W and the field: it lies on the surface of release points but for O(nu^2), its derivatives but for O(nu^3) times those of u.
#[derive(Clone, Debug)]
pub(crate) struct LocalTape {
    graph: Graph,
    tape: Tape,
    states: usize,
}

/// Values at one impact.
#[derive(Clone, Debug)]
pub(crate) struct Local<R> {
    pub rate: R,
    pub acceleration: R,
    pub jerk: R,
    pub place: Vec<R>,
    /// Derivatives along the columns: rows for rate, acceleration, jerk, states, place.
    slopes: Matrix<R>,
}

const SCALARS: usize = 3;

impl LocalTape {
    /// Of a contact, for states followed by these columns.
    pub(crate) fn new(
        (model, mechanics): (&Model, &Mechanics),
        contact: usize,
        columns: &[Column],
        coordinate: LocalCoordinate,
    ) -> Self {
        let Mechanics {
            contacts, field, ..
        } = mechanics;
        let contact = &contacts[contact];
        let mut derived = mechanics.graph.clone();
        let graph = &mut derived;
        let states: Vec<Expr> = (0..field.len()).map(|i| graph.state(i)).collect();
        let mut functions = vec![contact.rate, contact.acceleration, contact.jerk];
        if coordinate == LocalCoordinate::AtRest {
            let rest = back(graph, &states, contact.rate, &contact.jump);
            for function in &mut functions[1..] {
                *function = graph.substitute(*function, &|symbol| match symbol {
                    Symbol::State(i) => rest.get(i).copied(),
                    Symbol::Parameter(_) => None,
                });
            }
        }
        let mut outputs = functions.clone();
        let by_jump = graph.directional_derivatives(&[contact.acceleration], &|symbol| {
            let Symbol::State(i) = symbol else {
                return None;
            };
            contact.jump.get(i).copied()
        });
        // A state, or a change of it, less what W and the field make of it.
        let less = |graph: &mut Graph, x: &[Expr], by_jump: Expr, by_field: Expr| {
            let rest = back(graph, x, by_jump, &contact.jump);
            back(graph, &rest, by_field, field)
        };
        let by_field = |graph: &mut Graph, rate: Expr, acceleration: Expr| {
            let share = back(graph, &[acceleration], rate, &by_jump)[0];
            graph.div(share, contact.jerk)
        };
        if !columns.is_empty() {
            let late = by_field(graph, contact.rate, contact.acceleration);
            outputs.extend(less(graph, &states, contact.rate, late));
        }
        functions.extend(&states);
        functions.push(contact.acceleration);
        // Rate and acceleration change by gamma + alpha a and gamma L_(W / b) a + alpha j: alpha to first order in a, so that it has no
        // pole.
        let turned = graph.mul(contact.acceleration, by_jump[0]);
        let turned = graph.div(turned, contact.jerk);
        for (index, &column) in columns.iter().enumerate() {
            let along = Direction::of(column, model, graph, (index + 1) * field.len());
            let mut slopes = along.at_event(graph, (field, contact.gap), &functions);
            let acceleration = slopes.pop().unwrap_or(contact.acceleration);
            outputs.extend(&slopes);
            let first = by_field(graph, slopes[0], acceleration);
            let second = graph.mul(first, turned);
            let alpha = graph.add(first, second);
            let gamma = back(graph, &slopes[..1], alpha, &[contact.acceleration])[0];
            outputs.extend(less(graph, &slopes[SCALARS..], gamma, alpha));
        }
        let dimension = field.len() * (1 + columns.len());
        let tape = Tape::new(graph, dimension, &[], &outputs);
        Self {
            graph: derived,
            tape,
            states: field.len(),
        }
    }

    /// Scratch space, with the constants at a parameter set.
    pub(crate) fn scratch<R: Real>(&self, parameters: &[R]) -> (Expansion<R>, Vec<R>) {
        let constants = self.tape.constants(&self.graph, parameters);
        (Expansion::new(&[&self.tape]), constants)
    }

    /// Values at a state, `low` its rounding remainder.
    pub(crate) fn at<R: Real>(
        &self,
        (expansion, constants): &mut (Expansion<R>, Vec<R>),
        state: &[R],
        low: &[R],
    ) -> Local<R> {
        let mut values = vec![R::ZERO; self.tape.outputs.len()];
        expansion.evaluate(&self.tape, constants, state, low, &mut values);
        // Without columns there is no place, either.
        let (scalars, rest) = values.split_at(SCALARS);
        let (place, rest) = rest.split_at(rest.len().min(self.states));
        let rows = SCALARS + 2 * self.states;
        let mut slopes = Matrix::zeros(rows, rest.len() / rows);
        for (index, &slope) in rest.iter().enumerate() {
            slopes[(index % rows, index / rows)] = slope;
        }
        Local {
            rate: scalars[0],
            acceleration: scalars[1],
            jerk: scalars[2],
            place: place.to_vec(),
            slopes,
        }
    }
}

/// x - part * by.
fn back(graph: &mut Graph, x: &[Expr], part: Expr, by: &[Expr]) -> Vec<Expr> {
    let moved = x.iter().zip(by).map(|(&x, &by)| {
        let step = graph.mul(part, by);
        graph.sub(x, step)
    });
    moved.collect()
}

impl<R: Real> Local<R> {
    /// nu = -a.
    pub(crate) fn nu(&self) -> R {
        -self.acceleration
    }

    /// u = j w / nu^2.
    pub(crate) fn u(&self) -> R {
        self.jerk * self.rate / (self.acceleration * self.acceleration)
    }

    /// du along a column.
    pub(crate) fn u_slope(&self, column: usize) -> R {
        let [rate, acceleration, jerk] = [0, 1, 2].map(|of| self.slopes[(of, column)]);
        let square = self.acceleration * self.acceleration;
        let product = jerk * self.rate + self.jerk * rate;
        let two = R::splat(2.0);
        (product - two * self.jerk * self.rate * acceleration / self.acceleration) / square
    }

    /// How rate and acceleration change along a combination of columns.
    pub(crate) fn rates_along(&self, weights: &[R]) -> [R; 2] {
        [0, 1].map(|of| dot(self.slopes.row(of), weights))
    }

    /// How a state changes along each column.
    pub(crate) fn state_slopes(&self, state: usize) -> &[R] {
        self.slopes.row(SCALARS + state)
    }

    /// How the state changes along a combination of columns.
    pub(crate) fn along(&self, weights: &[R]) -> Vec<R> {
        let states = 0..self.place.len();
        states.map(|i| dot(self.state_slopes(i), weights)).collect()
    }

    /// How a component of its place does.
    pub(crate) fn place_along(&self, component: usize, weights: &[R]) -> R {
        dot(self.state_slopes(self.place.len() + component), weights)
    }
}
