//! The phase of a forced system: states that the equations know up to whole periods.

use super::super::error::BorderError;
use crate::expressions::{Expr, Graph, Symbol};
use crate::model::{Model, Phase};
use crate::numerics::{Real, with_rounding};
use serde::{Deserialize, Serialize};

/// The phases of a model, and how their periods depend on the parameter that is varied.
#[derive(Clone, Debug)]
pub(crate) struct Forcing {
    phases: Vec<PhaseOf>,
    /// Whether time enters the equations in another way.
    aperiodic: bool,
}

#[derive(Clone, Debug)]
struct PhaseOf {
    phase: Phase,
    /// Where the model starts.
    initial: Expr,
    /// Derivatives of the rates by the parameter.
    rate_slopes: Vec<Expr>,
}

with_rounding! {
    /// A state that returns shifted by whole periods.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Turn<R> {
        /// Place of the state: time, or an angle.
        pub state: usize,
        /// Its period.
        pub period: R,
        /// How the period changes with the parameter.
        pub period_slope: R,
        /// By how many periods the border orbit advances.
        pub count: i64,
    }
}

impl Forcing {
    /// `graph` continues the model's own; `parameter_rates` are the derivatives of all parameters by the varied one.
    pub(crate) fn new(model: &Model, graph: &mut Graph, parameter_rates: &[Expr]) -> Self {
        let phases: Vec<PhaseOf> = (model.phases(graph).into_iter())
            .map(|phase| PhaseOf {
                initial: model.states[phase.state].initial,
                rate_slopes: graph.directional_derivatives(phase.rates(), &|symbol| match symbol {
                    Symbol::Parameter(i) => parameter_rates.get(i).copied(),
                    Symbol::State(_) => None,
                }),
                phase,
            })
            .collect();
        let aperiodic =
            (model.time).is_some_and(|time| phases.iter().all(|p| p.phase.state != time));
        Self { phases, aperiodic }
    }

    /// Fails where the equations never return to what they were.
    pub(crate) fn check(
        &self,
        graph: &Graph,
        parameters: &[f64],
        value: f64,
    ) -> Result<(), BorderError> {
        let has_period = |p: &PhaseOf| p.phase.period(graph, parameters).is_some();
        if self.aperiodic || !self.phases.iter().all(has_period) {
            return Err(BorderError::Aperiodic { value });
        }
        Ok(())
    }

    /// Whether a state is a phase.
    pub(crate) fn is_phase(&self, state: usize) -> bool {
        self.phases.iter().any(|p| p.phase.state == state)
    }

    /// The phases with their periods, no turn counted yet.
    pub(crate) fn turns<R: Real>(&self, graph: &Graph, parameters: &[R]) -> Vec<Turn<R>> {
        let turn = |p: &PhaseOf| {
            let period = p.phase.period(graph, parameters)?;
            let relative_slope = (p.phase.rates().iter().zip(&p.rate_slopes))
                .map(|(&rate, &slope)| [rate, slope].map(|e| graph.evaluate(e, &[], parameters)))
                .find(|[rate, _]| *rate != R::ZERO)
                .map_or(R::ZERO, |[rate, slope]| slope / rate);
            Some(Turn {
                state: p.phase.state,
                period,
                period_slope: -period * relative_slope,
                count: 0,
            })
        };
        self.phases.iter().filter_map(turn).collect()
    }

    /// Takes whole periods from the phases until they are within one from where the model starts; whether there were any.
    pub(crate) fn reduce<R: Real>(&self, graph: &Graph, parameters: &[R], state: &mut [R]) -> bool {
        let mut reduced = false;
        for p in &self.phases {
            let Some(period) = p.phase.period(graph, parameters) else {
                continue;
            };
            let start = graph.evaluate(p.initial, &[], parameters);
            let turns = ((state[p.phase.state] - start) / period).to_f64().floor();
            if turns != 0.0 && turns.is_finite() {
                state[p.phase.state] -= period * R::splat(turns);
                reduced = true;
            }
        }
        reduced
    }
}
