//! Where a branch ends since its orbit comes to an equilibrium: the time beside that grows without bound, as the logarithm of how far away
//! the orbit passes it.

use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;
use crate::expressions::{Expr, Graph, Symbol};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Closed, Settings};
use crate::numerics::stored::{list, number};
use crate::numerics::{Equations, Linearised, Matrix, Newton, eigenvalues};
use core::convert::Infallible;
use core::fmt;
use serde::{Deserialize, Serialize};

/// An equilibrium that orbits come to, the longer the nearer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saddle {
    /// The names of the states that it is an equilibrium of: those that something depends on.
    pub names: Vec<String>,
    /// Their values.
    #[serde(with = "list")]
    pub state: Vec<f64>,
    /// How fast the motion leaves it: what is beside it grows as exp(rate t).
    #[serde(with = "number")]
    pub rate: f64,
    /// How near the last orbit passes it, against the size of its states.
    #[serde(with = "number")]
    pub distance: f64,
    /// The period of the last orbit.
    #[serde(with = "number")]
    pub period: f64,
}

impl fmt::Display for Saddle {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "the period, {:.6} here, grows without bound: at {:.1e} of its size the orbit passes a saddle at ",
            self.period, self.distance
        )?;
        for (index, (name, value)) in self.names.iter().zip(&self.state).enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            write!(out, "{comma}{name} = {value:.6}")?;
        }
        write!(out, ", which it leaves at the rate {:.6}", self.rate)
    }
}

/// An orbit this near to an equilibrium, against its size, is on its way there.
const NEAR: f64 = 1e-3;
/// A leg is looked at in so many places: beside an equilibrium it spends most of its time.
const PLACES: usize = 64;
/// The equilibrium is known to so many roundoffs, …
const ROUNDOFFS: f64 = 64.0;
/// … and a state of it that is less than this part of its size is zero.
const NOTHING: f64 = 1e-12;

/// What the field of a flight is to be zero in: states that nothing depends on may go on.
struct Rest<'a> {
    field: &'a [(usize, Expr, Vec<Expr>)],
    graph: &'a Graph,
    parameters: &'a [f64],
    state: Vec<f64>,
    sizes: &'a [f64],
}

impl Equations<f64> for Rest<'_> {
    type Left = Infallible;

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, Infallible> {
        for (&(state, ..), &x) in self.field.iter().zip(at) {
            self.state[state] = x;
        }
        let of = |expr: Expr| self.graph.evaluate(expr, &self.state, self.parameters);
        let rows = self
            .field
            .iter()
            .map(|(.., slopes)| slopes.iter().map(|&slope| of(slope)).collect());
        Ok(Linearised {
            residual: self.field.iter().map(|&(_, rate, _)| of(rate)).collect(),
            jacobian: Matrix::from_rows(&rows.collect::<Vec<Vec<f64>>>()),
        })
    }

    fn size(&self, _: &[f64], correction: &[f64]) -> f64 {
        let parts = self.field.iter().zip(correction);
        parts.fold(0.0, |most, (&(state, ..), x)| {
            most.max(x.abs() / self.sizes[state])
        })
    }
}

impl Shooting<f64> {
    /// The saddle that an orbit nearly comes to on one of its flights.
    pub(super) fn saddle(&mut self, at: &[f64]) -> Option<Saddle> {
        (0..self.steps.len()).find_map(|index| self.saddle_beside(at, index))
    }

    fn saddle_beside(&mut self, at: &[f64], index: usize) -> Option<Saddle> {
        let workshop = self.workshop.clone();
        let Passage::Leg(LegKind { mode, .. }) = self.steps[index].passage else {
            return None;
        };
        let (grip, _, on) = workshop.system.origin_of(mode)?;
        if grip.closed != Closed::NONE {
            return None;
        }
        let parameters =
            self.parameters_of(&workshop.parameters(self.free(at)), &self.steps[index]);
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
        let field: Vec<(usize, Expr, Vec<Expr>)> = field.collect();
        let (sizes, period) = (self.state_sizes(), self.period());
        let duration = at[self.duration_place(index)?];
        let speed = |state: &[f64]| {
            let rates = field
                .iter()
                .map(|&(own, rate, _)| graph.evaluate(rate, state, &parameters) / sizes[own]);
            rates.fold(0.0, |most: f64, rate| most.max(rate.abs()))
        };
        // By itself, without what happens at its end.
        let flight = workshop.leg(LegKind {
            mode,
            ends_at: None,
            jump: Jump::None,
        })?;
        let mut flyer = flight.flyer(&Settings::default());
        let start = self.node(at, index);
        let way = (1..PLACES).filter_map(|k| {
            let time = duration * k as f64 / PLACES as f64;
            let landing = flight.fly(&mut flyer, &parameters, start, time).ok()?;
            Some(landing.image)
        });
        let slowest = way.min_by(|a, b| speed(a).total_cmp(&speed(b)))?;
        let mut rest = Rest {
            field: &field,
            graph: &graph,
            parameters: &parameters,
            state: slowest.clone(),
            sizes: &sizes,
        };
        let start: Vec<f64> = states.iter().map(|&state| slowest[state]).collect();
        let found = Newton::to_rounding::<f64>(ROUNDOFFS)
            .solve(&mut rest, &start)
            .ok()?;
        let apart: Vec<f64> = found.at.iter().zip(&start).map(|(x, y)| x - y).collect();
        let distance = rest.size(&found.at, &apart);
        let Ok(there) = rest.evaluate(&found.at);
        let rates = eigenvalues(&there.jacobian);
        let rate = rates
            .iter()
            .fold(f64::NEG_INFINITY, |most, rate| most.max(rate.re));
        let is_saddle = rate > 0.0 && rates.iter().any(|rate| rate.re < 0.0);
        let whole = found.at.iter().zip(&states);
        (is_saddle && distance <= NEAR).then(|| Saddle {
            names: states
                .iter()
                .map(|&state| workshop.model.states[state].name.clone())
                .collect(),
            state: whole
                .map(|(&x, &state)| {
                    if x.abs() <= NOTHING * sizes[state] {
                        0.0
                    } else {
                        x
                    }
                })
                .collect(),
            rate,
            distance,
            period,
        })
    }
}
