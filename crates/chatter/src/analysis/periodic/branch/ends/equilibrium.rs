//! Equilibria of the flight that a step of an orbit is.

use super::forced_rest::ALIKE;
use crate::analysis::periodic::shooting::Shooting;
use crate::expressions::{Expr, Graph, Symbol};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Closed, Settings};
use crate::numerics::{Equations, Linearised, Matrix, Newton};
use core::convert::Infallible;

/// An equilibrium is known to so many roundoffs.
const ROUNDOFFS: f64 = 64.0;

/// Beside a state are those that differ from it by so small a part of the sizes of states: beside zero, and beside what rounds.
const BESIDE: [f64; 2] = [1e-100, ROUNDOFFS * f64::EPSILON];
/// From so many directions slopes come to what they are.
const DIRECTIONS: usize = 5;

/// The field of a flight and its slopes, at some parameters: in states that something depends on, others may go on.
#[derive(Clone, Debug)]
pub(super) struct Equilibria {
    /// Those states.
    pub states: Vec<usize>,
    /// All parameters, pieces of lookups included.
    pub parameters: Vec<f64>,
    /// Sizes of all states.
    sizes: Vec<f64>,
    field: Vec<(usize, Expr, Vec<Expr>)>,
    graph: Graph,
}

/// Where the field is zero.
#[derive(Clone, Debug)]
pub(super) struct Equilibrium {
    /// All states.
    pub state: Vec<f64>,
    /// The slopes of the field.
    pub slopes: Matrix<f64>,
}

struct Rest<'a> {
    of: &'a Equilibria,
    state: Vec<f64>,
    sizes: &'a [f64],
}

impl Equations<f64> for Rest<'_> {
    type Left = Infallible;

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, Infallible> {
        for (&state, &x) in self.of.states.iter().zip(at) {
            // On the other side of a surface by no more than rounding formulas may have no value, as powers have none.
            let is_rounding = x.abs() <= ROUNDOFFS * f64::EPSILON * self.sizes[state];
            self.state[state] = if is_rounding { 0.0 } else { x };
        }
        Ok(self.of.at(&self.state))
    }

    fn size(&self, _: &[f64], correction: &[f64]) -> f64 {
        let parts = self.of.states.iter().zip(correction);
        parts.fold(0.0, |most, (&state, x)| {
            most.max(x.abs() / self.sizes[state])
        })
    }
}

impl Equilibria {
    /// How fast a state moves, against the sizes of states. Clocks go on.
    pub(super) fn speed(&self, state: &[f64], sizes: &[f64]) -> f64 {
        let moves = |rate: Expr| {
            let mut symbols = self.graph.symbols(rate).into_iter();
            symbols.any(|symbol| matches!(symbol, Symbol::State(_)))
        };
        let rates = (self.field.iter())
            .filter(|&&(_, rate, _)| moves(rate))
            .map(|&(own, rate, _)| self.graph.evaluate(rate, state, &self.parameters) / sizes[own]);
        rates.fold(0.0, |most: f64, rate| most.max(rate.abs()))
    }

    /// The field at a state, and its slopes.
    pub(super) fn at(&self, state: &[f64]) -> Linearised<f64> {
        let own = self.slopes(state);
        let is_known = own.iter().flatten().all(|slope| slope.is_finite());
        let slopes = match is_known {
            true => own,
            false => self.slopes_beside(state).unwrap_or(own),
        };
        let of = |expr: Expr| (self.graph).evaluate(expr, state, &self.parameters);
        Linearised {
            residual: self.field.iter().map(|&(_, rate, _)| of(rate)).collect(),
            jacobian: Matrix::from_rows(&slopes),
        }
    }

    fn slopes(&self, state: &[f64]) -> Vec<Vec<f64>> {
        let of = |expr: Expr| (self.graph).evaluate(expr, state, &self.parameters);
        let rows = self.field.iter();
        rows.map(|(.., slopes)| slopes.iter().map(|&slope| of(slope)).collect())
            .collect()
    }

    /// The slopes where their formulas have no value, as those of v |(x, v)| have none at the origin, if they come to the same from all sides.
    fn slopes_beside(&self, state: &[f64]) -> Option<Vec<Vec<f64>>> {
        BESIDE.into_iter().find_map(|reach| {
            let all = (0..DIRECTIONS).map(|k| {
                let mut beside = state.to_vec();
                for (i, &index) in self.states.iter().enumerate() {
                    let (k, i) = (k as f64, i as f64);
                    beside[index] += reach * self.sizes[index] * libm::sin(1.0 + k + (1.0 + k) * i);
                }
                self.slopes(&beside)
            });
            let all: Vec<Vec<Vec<f64>>> = all.collect();
            let (first, others) = all.split_first()?;
            let is_limit = others.iter().all(|other| {
                let pairs = first.iter().flatten().zip(other.iter().flatten());
                let mut pairs =
                    pairs.map(|(one, two)| (one - two).abs() <= ALIKE * (1.0 + one.abs()));
                pairs.all(|alike| alike)
            });
            is_limit.then(|| first.clone())
        })
    }

    /// The equilibrium near a state.
    pub(super) fn near(&self, state: &[f64], sizes: &[f64]) -> Option<Equilibrium> {
        let mut rest = Rest {
            of: self,
            state: state.to_vec(),
            sizes,
        };
        let start: Vec<f64> = self.states.iter().map(|&index| state[index]).collect();
        let found = Newton::to_rounding::<f64>(ROUNDOFFS)
            .solve(&mut rest, &start)
            .ok()?;
        let Ok(there) = rest.evaluate(&found.at);
        Some(Equilibrium {
            state: rest.state,
            slopes: there.jacobian,
        })
    }
}

/// An orbit that goes no farther than this part of the sizes of states has shrunk to a point.
const SHRUNK: f64 = 1e-4;

impl Shooting<f64> {
    /// Whether an orbit has shrunk to a point: all its nodes, and where its flights are half over and end, from where events may take states back.
    /// Phases turn on where friction comes to hold all else.
    pub(in crate::analysis::periodic::branch) fn has_shrunk(&mut self, at: &[f64]) -> bool {
        let parameters = self.workshop.parameters(self.free(at));
        let passed = |index: usize, part: f64| {
            let step = &self.steps[index];
            let (kind, place) = (step.flight()?, self.duration_place(index)?);
            let flight = LegKind {
                ends_at: None,
                jump: Jump::None,
                ..kind
            };
            let leg = self.workshop.leg(flight)?;
            let all = self.parameters_of(&parameters, step);
            let (node, time) = (self.node(at, index), part * at[place]);
            let landing = leg.fly(&mut leg.flyer(&Settings::default()), &all, node, time);
            Some(landing.ok()?.image)
        };
        let is_near = |state: &Vec<f64>| self.is_one_place(state, self.node(at, 0));
        let steps = 0..self.steps.len();
        let mut places: Vec<Vec<f64>> =
            (steps.clone().map(|index| self.node(at, index).to_vec())).collect();
        if !places.iter().all(is_near) {
            return false;
        }
        for index in steps {
            let passed = [0.5, 1.0].map(|part| passed(index, part));
            let [Some(halfway), Some(end)] = passed else {
                return false;
            };
            places.extend([halfway, end]);
        }
        places.iter().all(is_near) && !self.leaves_walls(at, &places)
    }

    /// Whether an orbit leaves a wall by no small part of how far that is from the origin: a length of the model, beside which it is no point however
    /// large others on its branch are.
    fn leaves_walls(&self, at: &[f64], places: &[Vec<f64>]) -> bool {
        let (model, sizes) = (&self.workshop.model, self.state_sizes());
        self.steps.iter().enumerate().any(|(index, step)| {
            let Some(contact) = step.impact() else {
                return false;
            };
            let node = self.node(at, (index + 1) % self.steps.len());
            let symbols = model.graph.symbols(model.contacts[contact].gap);
            symbols.into_iter().any(|symbol| match symbol {
                Symbol::State(state) if self.is_place(state) => {
                    let wall = node[state];
                    let is_told = wall.abs() > SHRUNK * SHRUNK * sizes[state];
                    is_told
                        && (places.iter()).any(|at| (at[state] - wall).abs() > SHRUNK * wall.abs())
                }
                _ => false,
            })
        })
    }

    /// Whether a state is neither a phase nor one that nothing depends on.
    fn is_place(&self, state: usize) -> bool {
        let closure = &self.workshop.closure;
        !(closure.is_idle(state) || closure.is_phase(state))
    }

    /// Whether states are one, but for phases and what nothing depends on.
    pub(in crate::analysis::periodic::branch) fn is_one_place(
        &self,
        one: &[f64],
        other: &[f64],
    ) -> bool {
        let sizes = self.state_sizes();
        let parts = one.iter().zip(other).zip(&sizes).enumerate();
        let mut parts = parts.filter(|(index, _)| self.is_place(*index));
        parts.all(|(_, ((x, y), size))| (x - y).abs() <= SHRUNK * size)
    }

    /// Those of the mode of a step in which nothing is held.
    pub(super) fn equilibria(&self, at: &[f64], index: usize) -> Option<Equilibria> {
        let workshop = &self.workshop;
        let LegKind { mode, .. } = self.steps[index].flight()?;
        let (grip, _, on) = workshop.system.origin_of(mode)?;
        if grip.closed != Closed::NONE {
            return None;
        }
        let mut graph = on.mechanics.graph.clone();
        let states =
            (0..workshop.model.states.len()).filter(|&state| !workshop.closure.is_idle(state));
        let states: Vec<usize> = states.collect();
        let field = states.iter().map(|&state| {
            let rate = on.mechanics.field[state];
            let slopes = states
                .iter()
                .map(|&by| graph.derivative(rate, Symbol::State(by)));
            (state, rate, slopes.collect())
        });
        let field = field.collect();
        Some(Equilibria {
            parameters: self.parameters_of(&workshop.parameters(self.free(at)), &self.steps[index]),
            sizes: self.state_sizes(),
            states,
            field,
            graph,
        })
    }
}
