//! A window of the system itself: fold, period doubling and graze of the orbit with N impacts.
//!
//! The orbit is followed as a curve over the rate w after its last impact. Over w everything is smooth, the graze w = 0
//! included, where over the parameter it is a root: a multiplier m goes to infinity like 1 / w.

use super::extrapolate::{Estimate, Plan, limit};
use super::return_map::{FixedPoint, ReturnMap};
use serde::{Deserialize, Serialize};

/// A window of the system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LocatedWindow {
    /// Parameter value where the multiplier is 1.
    pub fold: Option<Estimate<f64>>,
    /// Parameter value where it is -1.
    pub period_doubling: Option<Estimate<f64>>,
    /// Parameter value where the last impact grazes.
    pub grazing: Option<Estimate<f64>>,
}

/// Where a step of the rate fails it is halved so often.
const RATE_HALVINGS: u32 = 4;
/// Rates towards the graze: each half of the one before.
const GRAZE_POINTS: usize = 9;
/// Fewer of them are not extrapolated.
const GRAZE_LEAST: usize = 4;
/// Ratios of the terms of a power series from one rate to the next.
const HALVES: [f64; 5] = [0.5, 0.25, 0.125, 0.0625, 0.03125];
/// Away from the graze the rate grows by this factor a step, so many times at most.
const GROWTH: f64 = 1.15;
const GROWTH_STEPS: usize = 40;
const SECANT_STEPS: usize = 60;
/// A multiplier is met to this, or to what rounding leaves of it, which may not be more than a hundredth.
const MULTIPLIER_DONE: f64 = 1e-9;
const MULTIPLIER_VAGUE: f64 = 1e-2;
/// So many secant steps without gain are enough.
const PATIENCE: usize = 3;

impl ReturnMap<'_> {
    /// The fixed point at another rate, from a neighbour.
    fn at_rate(&self, from: &FixedPoint, rate: f64) -> Option<FixedPoint> {
        self.at_rate_by(from, rate, RATE_HALVINGS)
    }

    fn at_rate_by(&self, from: &FixedPoint, rate: f64, halvings: u32) -> Option<FixedPoint> {
        let step = rate - from.rate;
        let guess = [0, 1, 2].map(|i| from.at[i] + from.direction[i] * step);
        self.solve(guess, Some(rate)).or_else(|| {
            let halvings = halvings.checked_sub(1)?;
            let between = self.at_rate_by(from, (rate * from.rate).sqrt(), halvings)?;
            self.at_rate_by(&between, rate, halvings)
        })
    }

    /// The whole window, from one of its orbits.
    pub fn window(&self, middle: FixedPoint) -> LocatedWindow {
        let mut towards = vec![middle];
        for _ in 0..GRAZE_POINTS {
            let last = towards[towards.len() - 1];
            match self.at_rate(&last, last.rate * 0.5) {
                Some(next) => towards.push(next),
                None => break,
            }
        }
        let mut away = vec![middle];
        let wanted = -towards[towards.len() - 1].multiplier.signum();
        for _ in 0..GROWTH_STEPS {
            let last = away[away.len() - 1];
            if last.multiplier * wanted > 1.0 {
                break;
            }
            match self.at_rate(&last, last.rate * GROWTH) {
                Some(next) => away.push(next),
                None => break,
            }
        }
        let meet = |multiplier: f64| -> Option<Estimate<f64>> {
            for branch in [&towards, &away] {
                let crossed = |pair: &&[FixedPoint]| {
                    (pair[0].multiplier - multiplier) * (pair[1].multiplier - multiplier) <= 0.0
                };
                if let Some(pair) = branch.windows(2).find(crossed) {
                    return self.meet(pair[0], pair[1], multiplier);
                }
            }
            None
        };
        LocatedWindow {
            fold: meet(1.0),
            period_doubling: meet(-1.0),
            grazing: graze(&towards),
        }
    }

    /// The parameter between two fixed points where the multiplier takes a value: safeguarded secant in the rate on
    /// w (m - multiplier), which has no pole at the graze. Its error is the last change.
    fn meet(
        &self,
        mut low: FixedPoint,
        mut high: FixedPoint,
        multiplier: f64,
    ) -> Option<Estimate<f64>> {
        let value = |point: &FixedPoint| point.rate * (point.multiplier - multiplier);
        let miss = |point: &FixedPoint| (point.multiplier - multiplier).abs();
        let (mut at_low, mut at_high) = (value(&low), value(&high));
        let (mut best, other) = if miss(&low) < miss(&high) {
            (low, high)
        } else {
            (high, low)
        };
        let mut change = (best.at[2] - other.at[2]).abs();
        let mut idle = 0;
        for _ in 0..SECANT_STEPS {
            if miss(&best) <= MULTIPLIER_DONE || idle == PATIENCE {
                break;
            }
            let part = at_low / (at_low - at_high);
            let rate = low.rate + (high.rate - low.rate) * part;
            let near = if part < 0.5 { low } else { high };
            let point = self.at_rate(&near, rate)?;
            if miss(&point) < miss(&best) {
                change = (point.at[2] - best.at[2]).abs();
                best = point;
                idle = 0;
            } else {
                idle += usize::from(miss(&best) <= MULTIPLIER_VAGUE);
            }
            let there = value(&point);
            if there * at_low > 0.0 {
                (low, at_low) = (point, there);
                at_high *= 0.5;
            } else {
                (high, at_high) = (point, there);
                at_low *= 0.5;
            }
        }
        (miss(&best) <= MULTIPLIER_VAGUE).then_some(Estimate {
            value: best.at[2],
            error: change.max(best.error),
        })
    }
}

/// The parameter at rate zero: a power series in the rate, of which each halving removes one more term. The nearer to the
/// graze, the less of the rate is left above rounding: of all beginnings of the sequence that counts which agrees best with
/// the one before.
fn graze(points: &[FixedPoint]) -> Option<Estimate<f64>> {
    let values: Vec<f64> = points.iter().map(|point| point.at[2]).collect();
    let plan = Plan {
        stride: 1,
        orders: HALVES.len(),
    };
    let limits: Vec<Estimate<f64>> = (GRAZE_LEAST..=values.len())
        .filter_map(|end| limit(&values[..end], &HALVES, plan))
        .collect();
    let rounding = points.iter().fold(0.0_f64, |most, p| most.max(p.error));
    (limits.windows(2))
        .map(|pair| {
            let change = (pair[1].value - pair[0].value).abs();
            Estimate {
                value: pair[1].value,
                error: pair[1].error.max(change).max(rounding),
            }
        })
        .min_by(|a, b| a.error.total_cmp(&b.error))
}
