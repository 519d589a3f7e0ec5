//! The release point: where contact ends, h = v = a = 0 and j > 0.

use crate::analysis::periodic::closure::Closure;
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Mechanics, MechanicsError, Model};
use crate::numerics::{
    DoubleDouble, Equations, Linearised, Matrix, Newton, Real, dot, with_rounding,
};
use serde::{Deserialize, Serialize};

/// A state this small against the largest is zero: far below rounding of any number type.
const NOTHING: f64 = 1e-50;

/// A correction this many roundoffs of the state is no correction.
const NEWTON_DONE: f64 = 8.0;

/// Place of the acceleration among the functions, and how many they are.
const ACCELERATION: usize = 2;
pub(crate) const CONDITIONS: usize = 3;

/// Equations of the release points of one contact. With n states they fill a surface of n - 3 dimensions, which as many of the
/// states are coordinates on.
#[derive(Clone, Debug)]
pub(crate) struct ReleaseEquations {
    pub contact: usize,
    pub(super) graph: Graph,
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
    /// The phases of a forcing, and where all states start; none where the equations have no period.
    pub(super) closure: Option<Closure>,
    pub(super) initial: Vec<Expr>,
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
        /// How the point moves with each of them.
        pub directions: Vec<Vec<R>>,
        /// How it moves with the parameter: of a border orbit, as its orbit does; else with the coordinates fixed.
        pub slope: Vec<R>,
        /// j > 0 there.
        pub jerk: R,
        /// Restitution of an impact of vanishing rate there.
        pub restitution: R,
        /// How the restitution there moves with the parameter.
        pub restitution_slope: R,
        /// How it moves with each coordinate.
        pub restitution_by: Vec<R>,
        /// How the jerk there moves with the parameter.
        pub jerk_slope: R,
        /// The free field there.
        pub field: Vec<R>,
        /// How the field there moves with the parameter.
        pub field_slope: Vec<R>,
        /// W / b there: what an impulse does to the state that changes the rate by one.
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
        self.moved(&vec![R::ZERO; self.state.len()])
    }

    /// A displacement away from where it is.
    pub(crate) fn moved(&self, by: &[R]) -> Place {
        let moved = self.state.iter().zip(by).map(|(&x, &by)| x + by);
        Place {
            contact: self.contact,
            state: moved.map(|x| x.to_double_double()).collect(),
        }
    }

    /// Where it is expected at another value of the parameter.
    pub(crate) fn expected(&self, by: R) -> Place {
        let moved: Vec<R> = self.slope.iter().map(|&slope| slope * by).collect();
        self.moved(&moved)
    }

    /// Lets it move with the parameter as orbits that return to it do: their coordinates change so much.
    pub(crate) fn follow_orbit(&mut self, moved: &[R]) {
        let along = self.along(moved);
        for (slope, part) in self.slope.iter_mut().zip(along) {
            *slope += part;
        }
        self.restitution_slope += dot(&self.restitution_by, moved);
    }

    /// The displacement that these changes of the coordinates make.
    pub(crate) fn along(&self, changes: &[R]) -> Vec<R> {
        let mut sum = vec![R::ZERO; self.state.len()];
        for (direction, &change) in self.directions.iter().zip(changes) {
            for (sum, &part) in sum.iter_mut().zip(direction) {
                *sum += part * change;
            }
        }
        sum
    }
}

impl ReleaseEquations {
    pub(crate) fn new(
        model: &Model,
        parameter: usize,
        index: usize,
    ) -> Result<Self, MechanicsError> {
        let mut mechanics = Mechanics::new(model)?;
        let contact = mechanics.contacts[index].clone();
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
        Ok(Self {
            contact: index,
            closure: (Closure::with_section(model, &[parameter], None, None).ok())
                .map(|(closure, _)| closure),
            initial: model.states.iter().map(|state| state.initial).collect(),
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

    /// The states that the surface of release points near a state is a graph over: all but those that gap, rate and acceleration
    /// depend on most.
    fn free_states<R: Real>(&self, state: &[R], parameters: &[R]) -> Vec<usize> {
        let states = state.len();
        let mut rows: Vec<Vec<R>> = (self.jacobian.iter())
            .map(|row| self.values(&row[..states], state, parameters))
            .collect();
        let mut free: Vec<usize> = (0..states).collect();
        while free.len() + CONDITIONS > states && !rows.is_empty() {
            let largest = |row: &[R]| {
                free.iter()
                    .map(|&i| row[i].abs().to_f64())
                    .fold(0.0, f64::max)
            };
            // Of equals the first.
            let row = rows.remove(
                (0..rows.len())
                    .rev()
                    .max_by(|&a, &b| largest(&rows[a]).total_cmp(&largest(&rows[b])))
                    .unwrap_or(0),
            );
            let most = largest(&row);
            let place = free.iter().position(|&i| row[i].abs().to_f64() == most);
            let pivot = free.remove(place.unwrap_or(0));
            for other in &mut rows {
                let factor = other[pivot] / row[pivot];
                for (entry, &above) in other.iter_mut().zip(&row) {
                    *entry -= factor * above;
                }
            }
        }
        free
    }

    /// The release point that Newton's method finds from a guess with its coordinates, in the first forcing period; `None`
    /// where it does not converge to a point with positive jerk.
    pub(crate) fn solve<R: Real>(&self, parameters: &[R], guess: &[R]) -> Option<ReleasePoint<R>> {
        let states = guess.len();
        let free = self.free_states(guess, parameters);
        let held =
            |state: &[R]| -> Vec<(usize, R)> { free.iter().map(|&i| (i, state[i])).collect() };
        let mut state = self.converge(parameters, guess, &held(guess))?;
        if self.to_first_turn(parameters, &mut state) {
            // A shift by many periods has lost digits.
            state = self.converge(parameters, &state, &held(&state))?;
        }
        // What Newton's method leaves of a zero.
        let largest = state.iter().fold(R::ONE, |most, x| most.max(x.abs()));
        for x in &mut state {
            if x.abs() < largest * R::splat(NOTHING) {
                *x = R::ZERO;
            }
        }
        let mut rows: Vec<Vec<R>> = (self.jacobian.iter())
            .map(|row| self.values(&row[..states], &state, parameters))
            .collect();
        let mut shift: Vec<R> = (self.jacobian.iter())
            .map(|row| -self.graph.evaluate(row[states], &state, parameters))
            .collect();
        for &i in &free {
            let mut row = vec![R::ZERO; states];
            row[i] = R::ONE;
            rows.push(row);
            shift.push(R::ZERO);
        }
        let factors = Matrix::from_rows(&rows).factored()?;
        let slope = factors.solve(&shift);
        let directions: Vec<Vec<R>> = (CONDITIONS..states)
            .map(|place| {
                let mut unit = vec![R::ZERO; states];
                unit[place] = R::ONE;
                factors.solve(&unit)
            })
            .collect();
        let jerk = self.graph.evaluate(self.jerk, &state, parameters);
        if !(jerk > R::ZERO && jerk.is_finite()) {
            return None;
        }
        let by = |row: &[Expr]| self.values(row, &state, parameters);
        let mut totals: Vec<R> = (self.slopes.iter())
            .map(|row| {
                let by = by(row);
                by[states] + dot(&by[..states], &slope)
            })
            .collect();
        let field_slope = totals.split_off(2);
        let restitution_by = by(&self.slopes[0][..states]);
        Some(ReleasePoint {
            contact: self.contact,
            restitution: self.graph.evaluate(self.restitution, &state, parameters),
            restitution_slope: totals[0],
            restitution_by: directions.iter().map(|d| dot(&restitution_by, d)).collect(),
            jerk_slope: totals[1],
            field: self.values(&self.field, &state, parameters),
            field_slope,
            jump: self.values(&self.jump, &state, parameters),
            state,
            free,
            directions,
            slope,
            jerk,
        })
    }

    /// Field, W / b, and the derivatives of the acceleration by the states.
    pub(crate) fn around<R: Real>(&self, state: &[R], parameters: &[R]) -> [Vec<R>; 3] {
        let slopes = &self.jacobian[ACCELERATION][..state.len()];
        [&self.field, &self.jump, slopes].map(|exprs| self.values(exprs, state, parameters))
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

    /// A release point polished in another number type.
    pub(crate) fn polish<R: Real>(
        &self,
        parameters: &[R],
        near: &Place,
    ) -> Option<ReleasePoint<R>> {
        let guess: Vec<R> = (near.state.iter())
            .map(|&x| R::from_double_double(x))
            .collect();
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
