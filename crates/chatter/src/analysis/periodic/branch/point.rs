//! One orbit of a branch.

use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::multipliers::{is_neutral, is_stable};
use crate::analysis::periodic::orbit::cleaned;
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::Complex;
use crate::numerics::stored::{list, number, pairs};
use serde::{Deserialize, Serialize};

/// The last correction leads from where the equations were evaluated last to the solution: no farther than so many of it.
const NEXT_TO: f64 = 2.0;

/// One orbit of a branch.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// The free parameters.
    #[serde(with = "list")]
    pub parameters: Vec<f64>,
    /// The period of the orbit.
    #[serde(with = "number")]
    pub period: f64,
    /// Impacts a period; none where infinitely many.
    pub impacts: Option<u64>,
    /// All but the trivial one, the largest first.
    #[serde(with = "pairs")]
    pub multipliers: Vec<Complex>,
    /// What moduli of multipliers about the unit circle may be off by.
    #[serde(with = "number")]
    pub modulus_error: f64,
    /// The state at the section, or just after an event.
    #[serde(with = "list")]
    pub state: Vec<f64>,
    /// The values of the user's functions there.
    #[serde(with = "list")]
    pub monitors: Vec<f64>,
    /// Largest residual of the equations.
    #[serde(with = "number")]
    pub residual: f64,
    /// The latest correction against the size of the state.
    #[serde(with = "number")]
    pub correction: f64,
}

impl Point {
    /// Of a solution. The landings that period and multipliers are read off are those of the latest evaluation, which may have been a
    /// trial elsewhere: then they are evaluated anew.
    pub(crate) fn new(shooting: &mut Shooting<f64>, station: &Station) -> Self {
        if !shooting.was_evaluated_at(&station.at, NEXT_TO * station.correction) {
            // Equations that have just been solved there have a value there.
            let _ = shooting.evaluate(&station.at);
        }
        let state = shooting.told_state(&station.at);
        let (multipliers, modulus_error) = shooting.multipliers_at(station);
        Self {
            parameters: shooting.free(&station.at).to_vec(),
            period: shooting.period(),
            impacts: shooting.impacts(),
            multipliers,
            modulus_error,
            state: cleaned(&state, &shooting.state_sizes()),
            monitors: shooting.monitored(&station.at),
            residual: station.residual,
            correction: station.correction,
        }
    }

    /// The same orbit as equations with one more event tell it, whose multipliers have a pole there, or mean another motion.
    pub(crate) fn moved(&self, shooting: &mut Shooting<f64>, at: &[f64]) -> Self {
        let mut moved = self.clone();
        moved.parameters = shooting.free(at).to_vec();
        if shooting.evaluate(at).is_ok() {
            moved.period = shooting.period();
            moved.state = cleaned(&shooting.told_state(at), &shooting.state_sizes());
            moved.monitors = shooting.monitored(at);
        }
        moved
    }

    /// The parameter that a branch is told over: the last of those that are free.
    pub fn parameter(&self) -> f64 {
        self.parameters.last().copied().unwrap_or(f64::NAN)
    }

    /// Whether all multipliers lie inside the unit circle by more than they may be off by.
    pub fn is_stable(&self) -> bool {
        is_stable(&self.multipliers, self.modulus_error)
    }

    /// Whether none lies outside the unit circle, and some on it as far as they are known.
    pub fn is_neutral(&self) -> bool {
        is_neutral(&self.multipliers, self.modulus_error)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::Point;

    /// Orbits of these periods, and the parameter that each is at.
    pub(in crate::analysis::periodic::branch) fn orbits(
        of: impl Fn(f64) -> f64,
        periods: impl Iterator<Item = f64>,
    ) -> Vec<Point> {
        let point = |period: f64| Point {
            parameters: vec![of(period)],
            period,
            impacts: Some(0),
            multipliers: Vec::new(),
            modulus_error: 0.0,
            state: Vec::new(),
            monitors: Vec::new(),
            residual: 0.0,
            correction: 0.0,
        };
        periods.map(point).collect()
    }
}
