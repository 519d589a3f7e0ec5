//! The release point: where contact ends, h = v = a = 0 and j > 0.

use super::super::error::{BorderError, Lack};
use super::super::problem::Here;
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Mechanics, Model};
use crate::numerics::{
    DoubleDouble, Equations, Linearised, Matrix, Newton, Real, Rounded, Solution, dot, moved, unit,
    with_rounding,
};
use core::ops::Range;
use serde::{Deserialize, Serialize};

/// A state this small against the largest is zero: far below rounding of any number type.
const NOTHING: f64 = 1e-50;

/// A correction this many roundoffs of the state is no correction.
const NEWTON_DONE: f64 = 8.0;

/// Gap, rate and acceleration vanish; their places among the functions, and those of the others.
pub(crate) const CONDITIONS: usize = 3;
const ACCELERATION: usize = 2;
pub(crate) const JERK: usize = 3;
const RESTITUTION: usize = 4;
pub(crate) const FIELD: usize = 5;

/// Equations of the release points of one contact. With n states they fill a surface of n - 3 dimensions, which as many of the
/// states are coordinates on.
#[derive(Clone, Debug)]
pub(crate) struct ReleaseEquations {
    graph: Graph,
    /// Gap, rate, acceleration, jerk, restitution, field.
    functions: Vec<Expr>,
    /// Their derivatives, a row each: by the states, then by the parameter.
    slopes: Vec<Vec<Expr>>,
    jump: Vec<Expr>,
}

with_rounding! {
    /// A release point.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct ReleasePoint<R> {
        /// Which contact ends.
        pub contact: usize,
        /// The state.
        pub state: Vec<R>,
        /// The states that are coordinates on the surface of release points: none where there are three.
        pub free: Vec<usize>,
        /// How the point moves with each of them; the parameter, which is last, does not.
        pub directions: Vec<Vec<R>>,
        /// How it moves with the parameter, which is last: of a border orbit, as its orbit does; else with the coordinates fixed.
        pub slope: Vec<R>,
        /// j > 0 there.
        pub jerk: R,
        /// Restitution of an impact of vanishing rate there.
        pub restitution: R,
        /// How the restitution there moves with the parameter.
        pub restitution_slope: R,
        /// How it moves with each coordinate.
        pub restitution_by: Vec<R>,
        /// W / b there: what an impulse does to the state that changes the rate by one, and not to the parameter.
        pub jump: Vec<R>,
    }
}

/// Near which point of which contact a release point is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub contact: usize,
    pub state: Vec<DoubleDouble>,
}

impl<R: Real> ReleasePoint<R> {
    /// Where it is.
    pub(crate) fn place(&self) -> Place {
        self.moved(&self.slope, R::ZERO)
    }

    /// A part of a displacement away from where it is.
    pub(crate) fn moved(&self, by: &[R], part: R) -> Place {
        Place {
            contact: self.contact,
            state: moved(&self.state, by, part).rounded(),
        }
    }

    /// Lets it move with the parameter as orbits that return to it do: their coordinates change so much.
    pub(crate) fn follow_orbit(&mut self, changes: &[R]) {
        self.slope = moved(&self.slope, &self.along(changes), R::ONE);
        self.restitution_slope += dot(&self.restitution_by, changes);
    }

    /// The displacement that these changes of the coordinates make.
    pub(crate) fn along(&self, changes: &[R]) -> Vec<R> {
        let nowhere = vec![R::ZERO; self.slope.len()];
        let parts = self.directions.iter().zip(changes);
        parts.fold(nowhere, |sum, (along, &change)| moved(&sum, along, change))
    }
}

impl ReleaseEquations {
    pub(crate) fn new(
        model: &Model,
        mechanics: &Mechanics,
        parameter: usize,
        contact: usize,
    ) -> Self {
        let contact = &mechanics.contacts[contact];
        let mut graph = mechanics.graph.clone();
        let states: Vec<Symbol> = (0..model.states.len()).map(Symbol::State).collect();
        let mut functions = vec![contact.gap, contact.rate, contact.acceleration];
        functions.extend([contact.jerk, contact.restitution]);
        functions.extend(&mechanics.field);
        let mut slopes = graph.jacobian(&functions, &states);
        let by_parameter = model.derivatives_by_parameter(&mut graph, &functions, parameter);
        for (row, entry) in slopes.iter_mut().zip(by_parameter) {
            row.push(entry);
        }
        Self {
            graph,
            functions,
            slopes,
            jump: contact.jump.clone(),
        }
    }

    /// Some of the functions with their derivatives: by the states, then by the parameter.
    pub(crate) fn at<R: Real>(
        &self,
        which: Range<usize>,
        state: &[R],
        parameters: &[R],
    ) -> Linearised<R> {
        let mut exprs = self.functions[which.clone()].to_vec();
        exprs.extend(self.slopes[which.clone()].iter().flatten());
        let mut residual = self.graph.evaluate_all(&exprs, state, parameters);
        let slopes = residual.split_off(which.len());
        let mut jacobian = Matrix::zeros(0, state.len() + 1);
        slopes
            .chunks(state.len() + 1)
            .for_each(|row| jacobian.push(row));
        Linearised { residual, jacobian }
    }

    /// The state with the values of some states that a guess has, at which as many of gap, rate and acceleration as that leaves are
    /// zero, by Newton's method. The parameter, which is last, is held, too.
    pub(crate) fn converge<R: Real>(
        &self,
        parameters: &[R],
        guess: &[R],
        held: &[usize],
    ) -> Option<Solution<R>> {
        let start: Vec<R> = guess.iter().copied().chain([R::ZERO]).collect();
        let held = [held, &[guess.len()]].concat();
        let mut equations = Held {
            release: self,
            parameters,
            held: held.iter().map(|&i| (i, start[i])).collect(),
        };
        let newton = Newton::to_rounding::<R>(NEWTON_DONE);
        let mut found = newton.solve(&mut equations, &start).ok()?;
        found.at.pop();
        Some(found)
    }

    /// The acceleration.
    pub(crate) fn acceleration(&self, state: &[f64], parameters: &[f64]) -> f64 {
        self.graph
            .evaluate(self.functions[ACCELERATION], state, parameters)
    }

    /// The state that an impulse leaves at rest on the contact, the gap being zero.
    pub(crate) fn brought_to_rest(&self, state: &[f64], parameters: &[f64]) -> Vec<f64> {
        let rate = self.graph.evaluate(self.functions[1], state, parameters);
        let jump = self.graph.evaluate_all(&self.jump, state, parameters);
        moved(state, &jump, -rate)
    }
}

impl<R: Real> Here<'_, R> {
    /// Some of a contact's functions with their derivatives.
    pub(crate) fn functions(
        &self,
        contact: usize,
        which: Range<usize>,
        state: &[R],
    ) -> Linearised<R> {
        self.problem.releases[contact].at(which, state, &self.parameters)
    }

    /// The state with these values of all states but one, that one such that the gap is zero; `None` where Newton's method
    /// does not get there.
    pub(crate) fn onto_surface(&self, contact: usize, state: &[R], bound: usize) -> Option<Vec<R>> {
        let others: Vec<usize> = (0..state.len()).filter(|&i| i != bound).collect();
        let found = self.problem.releases[contact].converge(&self.parameters, state, &others)?;
        Some(found.at)
    }

    /// The release point near one that is known, with its coordinates.
    pub(crate) fn release(&self, near: &Place) -> Result<ReleasePoint<R>, BorderError> {
        let found = self.solve(near.contact, &near.state.rounded());
        found.ok_or_else(|| self.lacks(Lack::Release))
    }

    /// The release point that Newton's method finds from a guess with its coordinates, in the first forcing period; `None`
    /// where it does not converge to a point with positive jerk.
    pub(crate) fn solve(&self, contact: usize, guess: &[R]) -> Option<ReleasePoint<R>> {
        let equations = &self.problem.releases[contact];
        let converge =
            |guess: &[R], free: &[usize]| equations.converge(&self.parameters, guess, free);
        // What gap, rate and acceleration depend on most is no coordinate; nor is the parameter, which is last.
        let mut slopes = self.functions(contact, 0..CONDITIONS, guess).jacobian;
        (0..CONDITIONS).for_each(|row| slopes[(row, guess.len())] = R::ZERO);
        let mut free = slopes.free_columns();
        free.pop();
        let mut found = converge(guess, &free)?;
        if self.to_first_turn(&mut found.at) {
            // A shift by many periods has lost digits.
            found = converge(&found.at, &free)?;
        }
        let Solution {
            at: mut state,
            factors,
            ..
        } = found;
        // What Newton's method leaves of a zero.
        let largest = state.iter().fold(R::ONE, |most, x| most.max(x.abs()));
        for x in &mut state {
            if x.abs() < largest * R::splat(NOTHING) {
                *x = R::ZERO;
            }
        }
        // What is held moves one after the other: the coordinates, then the parameter.
        let size = state.len() + 1;
        let moved = |place: usize| factors.solve(&unit(size, place));
        let directions: Vec<Vec<R>> = (CONDITIONS..size - 1).map(moved).collect();
        let slope = moved(size - 1);
        let here = self.functions(contact, JERK..FIELD, &state);
        let [jerk, restitution] = here.residual[..] else {
            return None;
        };
        let by = here.jacobian.row(RESTITUTION - JERK);
        let mut jump = (equations.graph).evaluate_all(&equations.jump, &state, &self.parameters);
        jump.push(R::ZERO);
        (jerk > R::ZERO && jerk.is_finite()).then(|| ReleasePoint {
            contact,
            restitution_slope: dot(by, &slope),
            restitution_by: directions.iter().map(|along| dot(by, along)).collect(),
            state,
            free,
            directions,
            slope,
            jerk,
            restitution,
            jump,
        })
    }
}

/// Gap, rate and acceleration, as many as leave room for what is held at a value.
struct Held<'a, R> {
    release: &'a ReleaseEquations,
    parameters: &'a [R],
    held: Vec<(usize, R)>,
}

impl<R: Real> Equations<R> for Held<'_, R> {
    type Left = core::convert::Infallible;

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Self::Left> {
        let (count, state) = (at.len() - self.held.len(), &at[..at.len() - 1]);
        let mut here = self.release.at(0..count, state, self.parameters);
        for &(i, value) in &self.held {
            here.residual.push(at[i] - value);
            here.jacobian.push(&unit(at.len(), i));
        }
        Ok(here)
    }

    fn size(&self, at: &[R], correction: &[R]) -> f64 {
        let parts = at.iter().zip(correction);
        parts.fold(0.0_f64, |most, (x, dx)| {
            most.max((dx.abs() / (x.abs() + R::ONE)).to_f64())
        })
    }
}
