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

/// The fixed points at which a window begins and ends.
#[derive(Clone, Copy)]
pub(super) struct WindowEnds {
    pub fold: Option<FixedPoint>,
    pub period_doubling: Option<FixedPoint>,
    grazing: Option<Estimate<f64>>,
}

impl WindowEnds {
    /// Their parameter values; `None` if there are none.
    pub fn window(&self) -> Option<LocatedWindow> {
        let parameter = |point: FixedPoint| Estimate {
            value: point.at[2],
            error: point.error,
        };
        let window = LocatedWindow {
            fold: self.fold.map(parameter),
            period_doubling: self.period_doubling.map(parameter),
            grazing: self.grazing,
        };
        (window != LocatedWindow::default()).then_some(window)
    }
}

/// Where a step of the rate fails it is halved so often.
const RATE_HALVINGS: u32 = 4;
/// Rates towards the graze: each half of the one before.
const GRAZE_POINTS: usize = 9;
/// Beginnings of that sequence with fewer of them are not extrapolated.
const GRAZE_LEAST: usize = 4;
/// Ratios of the terms of a power series from one rate to the next.
const HALVES: [f64; 5] = [0.5, 0.25, 0.125, 0.0625, 0.03125];
/// Elsewhere the rate grows or shrinks by this factor a step, so many times at most; where there is no orbit with N impacts
/// so far away, by its root, so many times in turn.
const GROWTH: f64 = 1.15;
const STEPS: usize = 40;
const ROOTS: usize = 8;
const SECANT_STEPS: usize = 60;
/// A multiplier is met to this, or to what rounding leaves of it, which may not be more than a hundredth.
const MULTIPLIER_DONE: f64 = 1e-9;
const MULTIPLIER_VAGUE: f64 = 1e-2;
/// So many secant steps without gain are enough.
const PATIENCE: usize = 3;

/// The end of a bracket that moved.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Neither,
    Low,
    High,
}

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
    pub fn window(&self, middle: FixedPoint) -> WindowEnds {
        let mut towards = vec![middle];
        while towards.len() <= GRAZE_POINTS {
            let last = towards[towards.len() - 1];
            match self.at_rate(&last, last.rate * 0.5) {
                Some(next) => towards.push(next),
                None => break,
            }
        }
        // Where the orbit ends before its graze, as far as it goes.
        let nearer = if towards.len() <= GRAZE_POINTS {
            self.walk(towards[towards.len() - 1], 1.0 / GROWTH, |_| false)
        } else {
            Vec::new()
        };
        let nearest = nearer.last().unwrap_or(&towards[towards.len() - 1]);
        let wanted = -nearest.multiplier.signum();
        let away = self.walk(middle, GROWTH, |point| point.multiplier * wanted > 1.0);
        let meet = |multiplier: f64| -> Option<FixedPoint> {
            for branch in [&towards, &nearer, &away] {
                let crossed = |pair: &&[FixedPoint]| {
                    (pair[0].multiplier - multiplier) * (pair[1].multiplier - multiplier) <= 0.0
                };
                if let Some(pair) = branch.windows(2).find(crossed) {
                    return self.meet(pair[0], pair[1], multiplier);
                }
            }
            None
        };
        WindowEnds {
            fold: meet(1.0),
            period_doubling: meet(-1.0),
            grazing: graze(&towards),
        }
    }

    /// Fixed points whose rates are multiplied by a factor from one to the next, the first given, until one of them is far
    /// enough.
    fn walk(
        &self,
        first: FixedPoint,
        factor: f64,
        is_far: impl Fn(&FixedPoint) -> bool,
    ) -> Vec<FixedPoint> {
        let mut points = vec![first];
        let (mut factor, mut roots) = (factor, 0);
        while points.len() <= STEPS && roots <= ROOTS {
            let last = points[points.len() - 1];
            if is_far(&last) {
                break;
            }
            match self.at_rate(&last, last.rate * factor) {
                Some(next) => points.push(next),
                None => {
                    factor = factor.sqrt();
                    roots += 1;
                }
            }
        }
        points
    }

    /// Between two fixed points the one where the multiplier takes a value: the Illinois method in the rate on
    /// w (m - multiplier), which has no pole at the graze. Its error is what the last change makes of the multiplier's miss.
    fn meet(
        &self,
        mut low: FixedPoint,
        mut high: FixedPoint,
        multiplier: f64,
    ) -> Option<FixedPoint> {
        let value = |point: &FixedPoint| point.rate * (point.multiplier - multiplier);
        let miss = |point: &FixedPoint| (point.multiplier - multiplier).abs();
        let (mut at_low, mut at_high) = (value(&low), value(&high));
        let (mut best, other) = if miss(&low) < miss(&high) {
            (low, high)
        } else {
            (high, low)
        };
        let change = |from: &FixedPoint, to: &FixedPoint| {
            ((to.at[2] - from.at[2]) / (to.multiplier - from.multiplier)).abs()
        };
        let mut slope = change(&other, &best);
        let mut idle = 0;
        let mut moved = Side::Neither;
        for _ in 0..SECANT_STEPS {
            if miss(&best) <= MULTIPLIER_DONE || idle == PATIENCE {
                break;
            }
            let part = at_low / (at_low - at_high);
            let rate = low.rate + (high.rate - low.rate) * part;
            let near = if part < 0.5 { low } else { high };
            let point = self.at_rate(&near, rate)?;
            if miss(&point) < miss(&best) {
                slope = change(&best, &point);
                best = point;
                idle = 0;
            } else {
                idle += usize::from(miss(&best) <= MULTIPLIER_VAGUE);
            }
            let there = value(&point);
            // An end that stays twice would stay for ever: it is given half its weight.
            if there * at_low > 0.0 {
                (low, at_low) = (point, there);
                at_high *= if moved == Side::Low { 0.5 } else { 1.0 };
                moved = Side::Low;
            } else {
                (high, at_high) = (point, there);
                at_low *= if moved == Side::High { 0.5 } else { 1.0 };
                moved = Side::High;
            }
        }
        best.error = best.error.max(slope * miss(&best));
        (miss(&best) <= MULTIPLIER_VAGUE).then_some(best)
    }
}

/// The parameter at rate zero: a power series in the rate, of which each halving removes one more term. The nearer to the
/// graze, the less of the rate is left above rounding: of all beginnings of the sequence that counts which agrees best with
/// its neighbours.
fn graze(points: &[FixedPoint]) -> Option<Estimate<f64>> {
    let values: Vec<f64> = points.iter().map(|point| point.at[2]).collect();
    let plan = Plan {
        stride: 1,
        orders: HALVES.len(),
    };
    let limits: Vec<Estimate<f64>> = (GRAZE_LEAST..=values.len())
        .filter_map(|end| limit(&values[..end], &HALVES, plan))
        .collect();
    let amplified: f64 = HALVES
        .iter()
        .map(|half| (1.0 + half) / (1.0 - half))
        .product();
    let rounding = points.iter().fold(0.0_f64, |most, p| most.max(p.error)) * amplified;
    let agreeing = limits.windows(3).map(|neighbours| {
        let middle = neighbours[1];
        let apart = |other: Estimate<f64>| (other.value - middle.value).abs();
        Estimate {
            value: middle.value,
            error: (middle.error + rounding)
                .max(apart(neighbours[0]))
                .max(apart(neighbours[2])),
        }
    });
    agreeing.min_by(|a, b| a.error.total_cmp(&b.error))
}
