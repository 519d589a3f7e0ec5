//! Where a branch ends since its orbit shrinks to an equilibrium at which no pair of eigenvalues is imaginary: it lies on a wall that is struck, or on
//! a surface on which formulas change their form.
//!
//! So small an orbit is one of the model made linear there on each side, with its impacts: such orbits come in all sizes s, and only at one value of
//! the parameter. What was left out vanishes as powers of s:
//!
//! ```text
//! p - p* = c_1 s + c_2 s^2 + ...
//! ```
//!
//! As s vanishes so does all that tells p from (M1), which is singular at s = 0; but with a given rate of an event, which is in proportion to s, it is
//! regular, and p* is the limit along rates that halve.

use super::equilibrium::Equilibria;
use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::branch::changes::holds::sequence_holds;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::{Solved, roundoff};
use crate::numerics::stored::number;
use crate::numerics::{Plan, dot, limit, ratios};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Where an orbit shrinks to nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shrunk {
    /// The parameter.
    pub name: String,
    /// Its value there.
    #[serde(with = "number")]
    pub value: f64,
    /// Estimated error of that.
    #[serde(with = "number")]
    pub error: f64,
}

impl fmt::Display for Shrunk {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, error } = self;
        write!(
            out,
            "the orbit shrinks to an equilibrium as {name} comes to {value} (error {error:.0e})"
        )
    }
}

/// Sizes of the orbits that a value is told from have this ratio, and there are so many.
const RATIO: f64 = 0.5;
const SIZES: usize = 12;
/// Where nothing is left of an orbit its speed is in proportion to its rates, but for this factor.
const IN_PROPORTION: f64 = 2.0;
/// What errors of single values come to in a limit with ratios 1/2, 1/4, ..: no more than the product of all (1 + 2^-k)/(1 - 2^-k).
const AMPLIFIED: f64 = 8.3;
/// A value is known where its error is no more than this part of the parameter's size.
const KNOWN: f64 = 1e-9;

impl Walker {
    /// Where an orbit that no forcing moves shrinks to nothing, if it does so on from a station.
    pub(in crate::analysis::periodic::branch) fn shrinks_to(
        &mut self,
        station: &Station,
    ) -> Option<Shrunk> {
        if self.shooting.counts.iter().any(|&count| count != 0) {
            return None;
        }
        self.settle(station);
        let index = self.shooting.fastest_event()?;
        let (rate, gradient) = self.shooting.monitor(index, &station.at).ok()?;
        if rate * dot(&gradient, &station.tangent) >= 0.0 {
            return None;
        }
        let mut shooting = self.shooting.clone();
        let start = shooting.speed(&station.at)?;
        let mut at = station.at.clone();
        let (mut values, mut off) = (Vec::with_capacity(SIZES), 0.0_f64);
        for k in 0..SIZES {
            let part = RATIO.powi(k as i32);
            let level = Bordered::Level(index, rate * part);
            let Solved {
                told,
                error,
                at: found,
                ..
            } = shooting.solved(&level, &at).ok()?;
            let speed = shooting.speed(&found)? / (start * part);
            let shrinks = (1.0 / IN_PROPORTION..=IN_PROPORTION).contains(&speed);
            if !shrinks || !sequence_holds(&mut shooting, &found) {
                return None;
            }
            values.push(*told.last()?);
            off = off.max(error);
            at = found;
        }
        let plan = Plan {
            stride: 1,
            orders: SIZES,
        };
        let found = limit(&values, &ratios(&[1.0], RATIO, SIZES, 1), plan);
        let error = found.error + AMPLIFIED * off.max(roundoff(found.value));
        let scale = *shooting.scales().last()?;
        let workshop = &shooting.workshop;
        let name = &workshop.model.parameters[*workshop.free.last()?].name;
        (error <= KNOWN * scale).then(|| Shrunk {
            name: name.clone(),
            value: found.value,
            error,
        })
    }
}

impl Shooting<f64> {
    /// The step that ends with the fastest impact of an orbit, or where it has none with the fastest event.
    fn fastest_event(&self) -> Option<usize> {
        let rate = |index: &usize| self.latest[*index].surface_rate.abs();
        let fastest = |of: &dyn Fn(&usize) -> bool| {
            let all = (0..self.latest.len()).filter(of);
            all.max_by(|a, b| rate(a).total_cmp(&rate(b)))
        };
        let hits = |index: &usize| self.steps[*index].impact().is_some();
        let ends = |index: &usize| self.steps[*index].ends_at().is_some();
        fastest(&hits).or_else(|| fastest(&ends))
    }

    /// The speed of the fastest node of an orbit, against the sizes of states.
    fn speed(&self, at: &[f64]) -> Option<f64> {
        let sizes = self.state_sizes();
        let speed = |index: usize| {
            let field: Equilibria = self.equilibria(at, index)?;
            Some(field.speed(self.node(at, index), &sizes))
        };
        (0..self.steps.len()).try_fold(0.0, |most: f64, index| Some(most.max(speed(index)?)))
    }
}
