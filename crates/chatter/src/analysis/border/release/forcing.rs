//! The phase of a forced system: states that the equations know up to whole periods.

use super::super::error::{BorderError, Lack};
use super::equations::ReleaseEquations;
use crate::analysis::periodic::closure::Turn as Period;
use crate::numerics::{Real, moved, with_rounding};
use serde::{Deserialize, Serialize};

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

impl<R: Real> Turn<R> {
    /// By how much a state grows with the turns of its phase, and how that changes with the parameter: zero but for phases.
    pub(crate) fn of(turns: &[Self], state: usize) -> [R; 2] {
        let turn = turns.iter().find(|turn| turn.state == state);
        turn.map_or([R::ZERO; 2], |turn| {
            let count = R::splat(turn.count as f64);
            [turn.period * count, turn.period_slope * count]
        })
    }
}

impl ReleaseEquations {
    /// The phases with their periods; none where the equations never return to what they were.
    fn periods<R: Real>(&self, parameters: &[R]) -> Vec<Period<R>> {
        let known = self.closure.as_ref().map(|phases| phases.turns(parameters));
        known.and_then(Result::ok).unwrap_or_default()
    }

    /// The phases with their periods, no turn counted yet.
    pub(crate) fn turns<R: Real>(&self, parameters: &[R]) -> Vec<Turn<R>> {
        (self.periods(parameters).iter())
            .map(|turn| Turn {
                state: turn.state,
                period: turn.period,
                period_slope: turn.slopes[0],
                count: 0,
            })
            .collect()
    }

    /// Fails where the equations never return to what they were.
    pub(crate) fn check_forcing(&self, parameters: &[f64], value: f64) -> Result<(), BorderError> {
        let known = self.closure.as_ref().map(|phases| phases.turns(parameters));
        match known {
            Some(Ok(_)) => Ok(()),
            _ => Err(Lack::Period.at(value)),
        }
    }

    /// Whether a state is a phase.
    pub(crate) fn is_phase(&self, state: usize) -> bool {
        (self.closure.as_ref()).is_some_and(|phases| phases.is_phase(state))
    }

    /// Takes whole periods from the phases until they are within one from where the model starts; whether there were any.
    pub(super) fn to_first_turn<R: Real>(&self, parameters: &[R], state: &mut [R]) -> bool {
        let mut reduced = false;
        for turn in self.turns(parameters) {
            let initial = self.initial[turn.state];
            let start = self.graph.evaluate(initial, &[], parameters);
            let turns = ((state[turn.state] - start) / turn.period).to_f64().floor();
            if turns != 0.0 && turns.is_finite() {
                state[turn.state] -= turn.period * R::splat(turns);
                reduced = true;
            }
        }
        reduced
    }

    /// What leads from one state to another, and how far they lie apart, relative to their size: phases up to whole periods.
    pub(crate) fn apart(&self, a: &[f64], b: &[f64], parameters: &[f64]) -> (Vec<f64>, f64) {
        let sizes: Vec<f64> = (a.iter().zip(b))
            .map(|(a, b)| 1.0 + a.abs() + b.abs())
            .collect();
        let Some(closure) = &self.closure else {
            return (moved(b, a, -1.0), f64::INFINITY);
        };
        let (off, difference) = closure.apart(&self.periods(parameters), (a, b), &sizes);
        (off, difference.distance)
    }
}
