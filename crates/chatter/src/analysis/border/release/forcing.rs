//! The phase of a forced system: states that the equations know up to whole periods.

use super::super::problem::Here;
use crate::analysis::periodic::closure::Turn as Phase;
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

impl<R: Real> Here<'_, R> {
    /// How often each phase turns from one state to another.
    pub(crate) fn turns(&self, from: &[R], to: &[R]) -> Vec<Turn<R>> {
        let turn = |phase: &Phase<R>| Turn {
            state: phase.state,
            period: phase.period,
            period_slope: phase.slopes[0],
            count: libm::round(((to[phase.state] - from[phase.state]) / phase.period).to_f64())
                as i64,
        };
        self.phases.iter().map(turn).collect()
    }

    /// Takes whole periods from the phases until they are within one from where the model starts; whether there were any.
    pub(super) fn to_first_turn(&self, state: &mut [R]) -> bool {
        let initial = self.problem.model.initial_state(&self.parameters);
        let mut reduced = false;
        for phase in &self.phases {
            let way = state[phase.state] - initial[phase.state];
            let turns = (way / phase.period).to_f64().floor();
            if turns != 0.0 && turns.is_finite() {
                state[phase.state] -= phase.period * R::splat(turns);
                reduced = true;
            }
        }
        reduced
    }
}

impl Here<'_, f64> {
    /// What leads from one state to another, and how far they lie apart, relative to their size: phases up to whole periods.
    pub(crate) fn apart(&self, a: &[f64], b: &[f64]) -> (Vec<f64>, f64) {
        let sizes: Vec<f64> = (a.iter().zip(b))
            .map(|(a, b)| 1.0 + a.abs() + b.abs())
            .collect();
        let (off, difference) = self.closure.apart(&self.phases, (a, b), &sizes);
        (off, difference.distance)
    }
}
