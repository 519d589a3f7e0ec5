//! The phase of a forced system: states that the equations know up to whole periods.

use super::super::error::{BorderError, Lack};
use super::equations::ReleaseEquations;
use crate::numerics::{Real, with_rounding};
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
    /// The phases with their periods, no turn counted yet.
    pub(crate) fn turns<R: Real>(&self, parameters: &[R]) -> Vec<Turn<R>> {
        let known = self.closure.as_ref().map(|phases| phases.turns(parameters));
        let turns = known.and_then(Result::ok).unwrap_or_default();
        (turns.iter())
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

    /// What leads from one state to another, phases up to whole periods.
    pub(crate) fn difference(&self, from: &[f64], to: &[f64], parameters: &[f64]) -> Vec<f64> {
        let mut off: Vec<f64> = to.iter().zip(from).map(|(b, a)| b - a).collect();
        for turn in self.turns(parameters) {
            let off = &mut off[turn.state];
            *off -= turn.period * libm::round(*off / turn.period);
        }
        off
    }

    /// How far two states lie apart, phases up to whole periods, relative to their size.
    pub(crate) fn apart(&self, a: &[f64], b: &[f64], parameters: &[f64]) -> f64 {
        let sizes = a.iter().zip(b).map(|(a, b)| 1.0 + a.abs() + b.abs());
        let off = self.difference(a, b, parameters);
        off.iter()
            .zip(sizes)
            .map(|(off, size)| off.abs() / size)
            .fold(0.0, f64::max)
    }
}
