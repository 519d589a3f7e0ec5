//! A window of the system itself: fold, period doubling and graze of the orbit with N impacts.
//!
//! The orbit is followed as a curve over the rate w after its last impact. Over w everything is smooth, the graze w = 0
//! included, where over the parameter it is a root: a multiplier m goes to infinity like 1 / w.

use super::return_map::{FixedPoint, ReturnMap};
use crate::numerics::{Bracket, Estimate, Plan, limit, moved, ratios};
use serde::{Deserialize, Serialize};

/// What is known of the ends of a window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowEnds<T> {
    /// Where the multiplier is 1.
    pub fold: Option<T>,
    /// Where it is -1.
    pub period_doubling: Option<T>,
    /// Where the last impact grazes.
    pub grazing: Option<T>,
}

impl<T: Copy> WindowEnds<T> {
    /// Fold, period doubling and graze.
    pub fn ends(&self) -> [Option<T>; 3] {
        [self.fold, self.period_doubling, self.grazing]
    }
}

/// A window of the system: parameter values.
pub type LocatedWindow = WindowEnds<Estimate<f64>>;

/// Where a step of the rate fails it is halved so often.
const RATE_HALVINGS: u32 = 4;
/// Beginnings of the sequence towards the graze with fewer of them are not extrapolated.
const GRAZE_LEAST: usize = 4;
/// So many terms of a power series in the rate are eliminated: their ratios are powers of a half.
const POWERS: usize = 5;
const SECANT_STEPS: usize = 60;
/// A multiplier is met to this, or to what rounding leaves of it, which may not be more than a hundredth.
const MULTIPLIER_DONE: f64 = 1e-9;
const MULTIPLIER_VAGUE: f64 = 1e-2;
/// However well it is met, it is known no better than this: a derivative of a flow of many impacts.
const MULTIPLIER_KNOWN: f64 = 1e-8;
/// So many secant steps without gain are enough.
const PATIENCE: usize = 3;

/// How the rate changes from one fixed point to the next: by this factor, so many times at most; where there is no orbit
/// with N impacts so far away, by its root, so many times in turn.
struct Walk {
    factor: f64,
    steps: usize,
    roots: usize,
}

/// Each half of the one before, as the extrapolation needs them.
const TOWARDS_GRAZE: Walk = Walk {
    factor: 0.5,
    steps: 9,
    roots: 0,
};
const AWAY: Walk = Walk {
    factor: 1.15,
    steps: 40,
    roots: 8,
};
const NEARER: Walk = Walk {
    factor: 1.0 / AWAY.factor,
    ..AWAY
};

impl ReturnMap<'_> {
    /// The fixed point at another rate, from a neighbour.
    fn at_rate(&self, from: &FixedPoint, rate: f64) -> Option<FixedPoint> {
        self.at_rate_by(from, rate, RATE_HALVINGS)
    }

    fn at_rate_by(&self, from: &FixedPoint, rate: f64, halvings: u32) -> Option<FixedPoint> {
        let guess = moved(&from.at, &from.direction, rate - from.rate);
        self.solve(&guess, Some(rate)).or_else(|| {
            let halvings = halvings.checked_sub(1)?;
            let between = self.at_rate_by(from, (rate * from.rate).sqrt(), halvings)?;
            self.at_rate_by(&between, rate, halvings)
        })
    }

    /// The whole window, from one of its orbits, and its period doubling and fold themselves.
    pub fn window(&self, middle: FixedPoint) -> (LocatedWindow, [Option<FixedPoint>; 2]) {
        let towards = self.walk(&middle, TOWARDS_GRAZE, |_| false);
        let mut nearest = &towards[towards.len() - 1];
        let mut nearer = Vec::new();
        if towards.len() <= TOWARDS_GRAZE.steps {
            // The orbit ends before its graze: as far as it goes.
            nearer = self.walk(nearest, NEARER, |_| false);
            nearest = &nearer[nearer.len() - 1];
        }
        let wanted = -nearest.trace().signum();
        let away = self.walk(&middle, AWAY, |point| point.excess(wanted) * wanted > 0.0);
        let end = |multiplier: f64| {
            let crossed = |pair: &&[FixedPoint]| {
                pair[0].excess(multiplier) * pair[1].excess(multiplier) <= 0.0
            };
            let mut branches = [&towards, &nearer, &away].into_iter();
            let pair = branches.find_map(|branch| branch.windows(2).find(crossed))?;
            self.meet((&pair[0], &pair[1]), multiplier)
        };
        let ends = [end(-1.0), end(1.0)];
        let [period_doubling, fold] = ends.each_ref().map(|end| {
            end.as_ref().map(|point| Estimate {
                value: point.parameter(),
                error: point.error,
            })
        });
        let window = WindowEnds {
            fold,
            period_doubling,
            grazing: graze(&towards),
        };
        (window, ends)
    }

    /// Fixed points one after the other, the first given, until one of them is far enough.
    fn walk(
        &self,
        first: &FixedPoint,
        walk: Walk,
        is_far: impl Fn(&FixedPoint) -> bool,
    ) -> Vec<FixedPoint> {
        let mut points = vec![first.clone()];
        let (mut factor, mut roots) = (walk.factor, 0);
        while points.len() <= walk.steps && roots <= walk.roots {
            let last = &points[points.len() - 1];
            if is_far(last) {
                break;
            }
            match self.at_rate(last, last.rate * factor) {
                Some(next) => points.push(next),
                None => {
                    factor = factor.sqrt();
                    roots += 1;
                }
            }
        }
        points
    }

    /// Between two fixed points the one where the multiplier takes a value: a root over the rate of w times its excess, which
    /// has no pole at the graze. Its error is what the last change makes of the multiplier's miss, and of what it is
    /// known to.
    fn meet(&self, (low, high): (&FixedPoint, &FixedPoint), multiplier: f64) -> Option<FixedPoint> {
        let value = |point: &FixedPoint| point.rate * point.excess(multiplier);
        let miss = |point: &FixedPoint| point.excess(multiplier).abs();
        let (best, other) = if miss(low) < miss(high) {
            (low, high)
        } else {
            (high, low)
        };
        let change = |from: &FixedPoint, to: &FixedPoint| {
            let moved = to.excess(multiplier) - from.excess(multiplier);
            ((to.parameter() - from.parameter()) / moved).abs()
        };
        let mut slope = change(other, best);
        let mut best = best.clone();
        let mut idle = 0;
        let mut bracket = Bracket::new((low.rate, value(low)), (high.rate, value(high)));
        let mut ends = [low.clone(), high.clone()];
        for _ in 0..SECANT_STEPS {
            if miss(&best) <= MULTIPLIER_DONE || idle == PATIENCE {
                break;
            }
            let Some(rate) = bracket.as_mut().and_then(Bracket::place) else {
                break;
            };
            let off = |end: &FixedPoint| (end.rate - rate).abs();
            let near = usize::from(off(&ends[1]) < off(&ends[0]));
            let point = self.at_rate(&ends[near], rate)?;
            if miss(&point) < miss(&best) {
                slope = change(&best, &point);
                best = point.clone();
                idle = 0;
            } else {
                idle += usize::from(miss(&best) <= MULTIPLIER_VAGUE);
            }
            let there = value(&point);
            ends[usize::from(there * value(&ends[0]) <= 0.0)] = point;
            if let Some(bracket) = &mut bracket {
                bracket.narrow(rate, there);
            }
        }
        best.error = best.error.max(slope * miss(&best).max(MULTIPLIER_KNOWN));
        (miss(&best) <= MULTIPLIER_VAGUE).then_some(best)
    }
}

/// The parameter at rate zero: a power series in the rate, of which each halving removes one more term. The nearer to the
/// graze, the less of the rate is left above rounding: of all beginnings of the sequence that counts which agrees best with
/// its neighbours.
fn graze(points: &[FixedPoint]) -> Option<Estimate<f64>> {
    let values: Vec<f64> = points.iter().map(FixedPoint::parameter).collect();
    let plan = Plan {
        stride: 1,
        orders: POWERS,
    };
    let halves = ratios(&[1.0], 0.5, POWERS, 1);
    let limits: Vec<Estimate<f64>> = (GRAZE_LEAST..=values.len())
        .filter_map(|end| limit(&values[..end], &halves, plan))
        .collect();
    let amplified: f64 = halves
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
