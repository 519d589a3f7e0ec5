//! Local coordinates after an impact, and their derivatives from impact to impact.

use crate::expressions::{Expansion, Expr, Graph, Symbol, Tape};
use crate::flow::{Column, Direction};
use crate::model::{Mechanics, MechanicsError, Model};
use crate::numerics::Real;
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

/// Rate w, acceleration a and jerk j after an impact as functions of the state, and how they, and the state itself,
/// change along columns of derivatives when the impact moves with them.
#[derive(Clone, Debug)]
pub(crate) struct LocalTape {
    graph: Graph,
    tape: Tape,
    coordinates: usize,
    columns: usize,
}

/// Values at one impact.
#[derive(Clone, Debug)]
pub(crate) struct Local<R> {
    pub rate: R,
    pub acceleration: R,
    pub jerk: R,
    /// One for each column.
    pub slopes: Vec<Slopes<R>>,
}

/// Derivatives from impact to impact along one column.
#[derive(Clone, Debug)]
pub(crate) struct Slopes<R> {
    pub rate: R,
    pub acceleration: R,
    pub jerk: R,
    pub state: Vec<R>,
}

const SCALARS: usize = 3;

impl LocalTape {
    /// Of a contact, for states followed by these columns.
    pub(crate) fn new(
        model: &Model,
        contact: usize,
        columns: &[Column],
        coordinate: LocalCoordinate,
    ) -> Result<Self, MechanicsError> {
        let mut mechanics = Mechanics::new(model)?;
        let contact = mechanics.contacts[contact].clone();
        let graph = &mut mechanics.graph;
        let field = mechanics.field.clone();
        let coordinates = field.len();
        let mut functions = vec![contact.rate, contact.acceleration, contact.jerk];
        if coordinate == LocalCoordinate::AtRest {
            let rest: Vec<Expr> = (contact.jump.iter().enumerate())
                .map(|(i, &jump)| {
                    let state = graph.state(i);
                    let stop = graph.mul(contact.rate, jump);
                    graph.sub(state, stop)
                })
                .collect();
            for function in &mut functions[1..] {
                *function = graph.substitute(*function, &|symbol| match symbol {
                    Symbol::State(i) => rest.get(i).copied(),
                    Symbol::Parameter(_) => None,
                });
            }
        }
        functions.extend((0..coordinates).map(|i| graph.state(i)));
        let drifts: Vec<Expr> = functions
            .iter()
            .map(|&function| graph.lie_derivative(function, &field))
            .collect();
        let mut outputs = functions[..SCALARS].to_vec();
        for (index, column) in columns.iter().enumerate() {
            let parameters = match *column {
                Column::State => Vec::new(),
                Column::Parameter(p) => model.parameter_rates(graph, p),
            };
            let direction = Direction::new((index + 1) * coordinates, parameters);
            let gap = direction.along(graph, coordinates, &[contact.gap])[0];
            let late = graph.div(gap, contact.rate);
            let along = direction.along(graph, coordinates, &functions);
            for (&along, &drift) in along.iter().zip(&drifts) {
                let moved = graph.mul(drift, late);
                outputs.push(graph.sub(along, moved));
            }
        }
        let dimension = coordinates * (1 + columns.len());
        let tape = Tape::new(graph, dimension, &[], &outputs);
        Ok(Self {
            graph: mechanics.graph,
            tape,
            coordinates,
            columns: columns.len(),
        })
    }

    /// Scratch space.
    pub(crate) fn expansion<R: Real>(&self) -> Expansion<R> {
        Expansion::new(&[&self.tape])
    }

    /// The tape's constants at a parameter set.
    pub(crate) fn constants<R: Real>(&self, parameters: &[R]) -> Vec<R> {
        self.tape.constants(&self.graph, parameters)
    }

    /// Values at a state, `low` its rounding remainder.
    pub(crate) fn at<R: Real>(
        &self,
        expansion: &mut Expansion<R>,
        constants: &[R],
        state: &[R],
        low: &[R],
    ) -> Local<R> {
        let width = SCALARS + self.coordinates;
        let mut values = vec![R::ZERO; SCALARS + self.columns * width];
        expansion.evaluate(&self.tape, constants, state, low, &mut values);
        Local {
            rate: values[0],
            acceleration: values[1],
            jerk: values[2],
            slopes: values[SCALARS..]
                .chunks(width)
                .map(|slope| Slopes {
                    rate: slope[0],
                    acceleration: slope[1],
                    jerk: slope[2],
                    state: slope[SCALARS..].to_vec(),
                })
                .collect(),
        }
    }
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
        let slope = &self.slopes[column];
        let two = R::splat(2.0);
        let square = self.acceleration * self.acceleration;
        let product = slope.jerk * self.rate + self.jerk * slope.rate;
        (product - two * self.jerk * self.rate * slope.acceleration / self.acceleration) / square
    }
}
