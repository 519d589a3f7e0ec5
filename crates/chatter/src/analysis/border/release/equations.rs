//! The release point: where contact ends, h = v = a = 0 and j > 0.

use super::super::error::BorderError;
use super::forcing::{Forcing, Turn};
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Mechanics, MechanicsError, Model};
use crate::numerics::linear::solve;
use crate::numerics::{DoubleDouble, Equations, Linearised, Matrix, Newton, Real};
use serde::{Deserialize, Serialize};

/// A state this small against the largest is zero: far below rounding of any number type.
const NOTHING: f64 = 1e-50;

/// A correction this many roundoffs of the state is no correction.
const NEWTON_DONE: f64 = 8.0;

/// Place of the acceleration among the functions.
const ACCELERATION: usize = 2;

/// Equations of the release point of a model with one contact.
#[derive(Clone, Debug)]
pub(crate) struct ReleaseEquations {
    graph: Graph,
    /// h, v, a.
    functions: Vec<Expr>,
    /// Their derivatives, a row each: by the states, then by the parameter.
    jacobian: Vec<Vec<Expr>>,
    jerk: Expr,
    restitution: Expr,
    jump: Vec<Expr>,
    field: Vec<Expr>,
    /// Derivatives of restitution, jerk and field: a row each, by the states, then by the parameter.
    slopes: Vec<Vec<Expr>>,
    /// What the forcing, if there is one, does to the phase.
    pub forcing: Forcing,
}

/// A release point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReleasePoint<R> {
    /// The state.
    pub state: Vec<R>,
    /// How it moves with the parameter.
    pub slope: Vec<R>,
    /// j > 0 there.
    pub jerk: R,
    /// Restitution of an impact of vanishing rate there.
    pub restitution: R,
    /// How the restitution there moves with the parameter.
    pub restitution_slope: R,
    /// How the jerk there moves with the parameter.
    pub jerk_slope: R,
    /// The free field there.
    pub field: Vec<R>,
    /// How the field there moves with the parameter.
    pub field_slope: Vec<R>,
    /// W / b there: what an impulse does to the state that changes the rate by one.
    pub jump: Vec<R>,
}

impl<R: Real> ReleasePoint<R> {
    /// Where it is expected at another value of the parameter.
    pub(crate) fn expected(&self, by: R) -> Vec<R> {
        (self.state.iter().zip(&self.slope))
            .map(|(&x, &slope)| x + slope * by)
            .collect()
    }
}

impl ReleaseEquations {
    pub(crate) fn new(model: &Model, parameter: usize) -> Result<Self, MechanicsError> {
        let mut mechanics = Mechanics::new(model)?;
        let contact = mechanics.contacts[0].clone();
        let field = mechanics.field.clone();
        let graph = &mut mechanics.graph;
        let rates = model.parameter_rates(graph, parameter);
        let states: Vec<Symbol> = (0..model.states.len()).map(Symbol::State).collect();
        let functions = vec![contact.gap, contact.rate, contact.acceleration];
        let mut all = functions.clone();
        all.extend([contact.restitution, contact.jerk]);
        all.extend(&field);
        let mut jacobian = graph.jacobian(&all, &states);
        let by_parameter = graph.directional_derivatives(&all, &|symbol| match symbol {
            Symbol::Parameter(i) => rates.get(i).copied(),
            Symbol::State(_) => None,
        });
        for (row, entry) in jacobian.iter_mut().zip(by_parameter) {
            row.push(entry);
        }
        let slopes = jacobian.split_off(functions.len());
        let forcing = Forcing::new(model, graph, &rates);
        Ok(Self {
            forcing,
            graph: mechanics.graph,
            functions,
            jacobian,
            jerk: contact.jerk,
            restitution: contact.restitution,
            jump: contact.jump,
            field,
            slopes,
        })
    }

    fn values<R: Real>(&self, exprs: &[Expr], state: &[R], parameters: &[R]) -> Vec<R> {
        self.graph.evaluate_all(exprs, state, parameters)
    }

    /// The derivatives of gap and rate, a row each: by the states, then by the parameter.
    pub(crate) fn gap_and_rate_slopes<R: Real>(
        &self,
        state: &[R],
        parameters: &[R],
    ) -> [Vec<R>; 2] {
        [0, 1].map(|row| self.values(&self.jacobian[row], state, parameters))
    }

    /// The state with these values of all states but one, that one such that the gap is zero; `None` where Newton's method
    /// does not get there.
    pub(crate) fn onto_surface(
        &self,
        parameters: &[f64],
        state: &[f64],
        bound: usize,
    ) -> Option<Vec<f64>> {
        let others = (0..state.len()).filter(|&i| i != bound);
        let held: Vec<(usize, f64)> = others.map(|i| (i, state[i])).collect();
        self.converge(parameters, state, &held)
    }

    /// Fails where the forcing has no period.
    pub(crate) fn check_forcing(&self, parameters: &[f64], value: f64) -> Result<(), BorderError> {
        self.forcing.check(&self.graph, parameters, value)
    }

    /// The phases with their periods.
    pub(crate) fn turns<R: Real>(&self, parameters: &[R]) -> Vec<Turn<R>> {
        self.forcing.turns(&self.graph, parameters)
    }

    /// Gap and rate.
    pub(crate) fn gap_and_rate<R: Real>(&self, state: &[R], parameters: &[R]) -> [R; 2] {
        [0, 1].map(|i| self.graph.evaluate(self.functions[i], state, parameters))
    }

    /// The state where some states have given values, and as many of gap, rate and acceleration as that leaves are zero, by
    /// Newton's method from a guess.
    pub(crate) fn converge<R: Real>(
        &self,
        parameters: &[R],
        guess: &[R],
        held: &[(usize, R)],
    ) -> Option<Vec<R>> {
        let mut equations = Held {
            release: self,
            parameters,
            held,
        };
        let newton = Newton::to_rounding::<R>(NEWTON_DONE);
        Some(newton.solve(&mut equations, guess).ok()?.at)
    }

    /// The release point that Newton's method finds from a guess, in the first forcing period; `None` where it does not
    /// converge to a point with positive jerk.
    pub(crate) fn solve<R: Real>(&self, parameters: &[R], guess: &[R]) -> Option<ReleasePoint<R>> {
        let states = guess.len();
        let mut state = self.converge(parameters, guess, &[])?;
        if self.forcing.reduce(&self.graph, parameters, &mut state) {
            // A shift by many periods has lost digits.
            state = self.converge(parameters, &state, &[])?;
        }
        // What Newton's method leaves of a zero.
        let largest = state.iter().fold(R::ONE, |most, x| most.max(x.abs()));
        for x in &mut state {
            if x.abs() < largest * R::splat(NOTHING) {
                *x = R::ZERO;
            }
        }
        let rows: Vec<Vec<R>> = (self.jacobian.iter())
            .map(|row| self.values(&row[..states], &state, parameters))
            .collect();
        let shift: Vec<R> = (self.jacobian.iter())
            .map(|row| -self.graph.evaluate(row[states], &state, parameters))
            .collect();
        let slope = solve(&rows, &shift)?;
        let jerk = self.graph.evaluate(self.jerk, &state, parameters);
        if !(jerk > R::ZERO && jerk.is_finite()) {
            return None;
        }
        let mut totals: Vec<R> = (self.slopes.iter())
            .map(|row| {
                let by = self.values(row, &state, parameters);
                (by.iter().zip(&slope)).fold(by[states], |sum, (&by, &moves)| sum + by * moves)
            })
            .collect();
        let field_slope = totals.split_off(2);
        Some(ReleasePoint {
            restitution: self.graph.evaluate(self.restitution, &state, parameters),
            restitution_slope: totals[0],
            jerk_slope: totals[1],
            field: self.values(&self.field, &state, parameters),
            field_slope,
            jump: self.values(&self.jump, &state, parameters),
            state,
            slope,
            jerk,
        })
    }

    /// The acceleration.
    pub(crate) fn acceleration<R: Real>(&self, state: &[R], parameters: &[R]) -> R {
        self.graph
            .evaluate(self.functions[ACCELERATION], state, parameters)
    }

    /// The state that an impulse leaves at rest on the contact, the gap being zero.
    pub(crate) fn brought_to_rest(&self, state: &[f64], parameters: &[f64]) -> Vec<f64> {
        let [_, rate] = self.gap_and_rate(state, parameters);
        let jump = self.values(&self.jump, state, parameters);
        (state.iter().zip(jump))
            .map(|(x, jump)| x - rate * jump)
            .collect()
    }

    /// The first phase, if there is one.
    pub(crate) fn first_turn(&self, parameters: &[f64]) -> Option<Turn<f64>> {
        self.forcing.turns(&self.graph, parameters).first().copied()
    }

    /// How far two states lie apart, phases up to whole periods, relative to their size.
    pub(crate) fn apart(&self, a: &[f64], b: &[f64], parameters: &[f64]) -> f64 {
        let turns = self.turns(parameters);
        (a.iter().zip(b).enumerate())
            .map(|(i, (a, b))| {
                let mut off = a - b;
                if let Some(turn) = turns.iter().find(|turn| turn.state == i) {
                    off -= turn.period * libm::round(off / turn.period);
                }
                off.abs() / (1.0 + a.abs() + b.abs())
            })
            .fold(0.0, f64::max)
    }

    /// A release point polished in another number type.
    pub(crate) fn polish<R: Real>(
        &self,
        parameters: &[R],
        near: &[DoubleDouble],
    ) -> Option<ReleasePoint<R>> {
        let guess: Vec<R> = near.iter().map(|&x| R::from_double_double(x)).collect();
        self.solve(parameters, &guess)
    }
}

/// Gap, rate and acceleration, as many as leave room for states that are held at a value.
struct Held<'a, R> {
    release: &'a ReleaseEquations,
    parameters: &'a [R],
    held: &'a [(usize, R)],
}

impl<R: Real> Equations<R> for Held<'_, R> {
    type Left = core::convert::Infallible;

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Self::Left> {
        let states = at.len();
        let count = states - self.held.len();
        let (functions, rows) = (&self.release.functions, &self.release.jacobian);
        let mut exprs = functions[..count].to_vec();
        exprs.extend(rows[..count].iter().flat_map(|row| &row[..states]));
        let mut residual = self.release.values(&exprs, at, self.parameters);
        let slopes = residual.split_off(count);
        let mut jacobian = Matrix::zeros(0, states);
        slopes.chunks(states).for_each(|row| jacobian.push(row));
        for &(state, value) in self.held {
            residual.push(at[state] - value);
            let mut row = vec![R::ZERO; states];
            row[state] = R::ONE;
            jacobian.push(&row);
        }
        Ok(Linearised { residual, jacobian })
    }

    fn size(&self, at: &[R], correction: &[R]) -> f64 {
        let parts = at.iter().zip(correction);
        parts.fold(0.0_f64, |most, (x, dx)| {
            most.max((dx.abs() / (x.abs() + R::ONE)).to_f64())
        })
    }
}
