//! Limits of sequences whose error is a sum of known geometric sequences.

use super::Real;
use serde::{Deserialize, Serialize};

/// A number and the estimate of its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate<R> {
    /// The number.
    pub value: R,
    /// Estimated absolute error.
    pub error: f64,
}

impl<R: Real> Estimate<R> {
    /// The numbers alone.
    pub fn values(estimates: &[Self]) -> Vec<R> {
        estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// The product of two.
    pub(crate) fn times(self, other: Self) -> Self {
        let [a, b] = [self, other].map(|factor| factor.value.abs().to_f64());
        Self {
            value: self.value * other.value,
            error: self.error * b + other.error * a,
        }
    }

    /// The estimate times an exact factor.
    pub(crate) fn scaled(self, factor: R) -> Self {
        Self {
            value: self.value * factor,
            error: self.error * factor.to_f64().abs(),
        }
    }
}

/// How a limit is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Terms lie this many impacts apart.
    pub stride: usize,
    /// At most so many ratios are eliminated.
    pub orders: usize,
}

/// So many powers of a ratio, each times each of these, largest first and so often: where a ratio changes along a derivative, what
/// it multiplies occurs k times in term k as well, and is to be eliminated twice.
pub fn ratios<R: Real>(firsts: &[R], ratio: R, powers: usize, copies: usize) -> Vec<R> {
    let of = |&first: &R| {
        let next = move |&power: &R| Some(power * ratio);
        core::iter::successors(Some(first * ratio), next).take(powers)
    };
    let mut all: Vec<R> = (firsts.iter().flat_map(of))
        .flat_map(|ratio| core::iter::repeat_n(ratio, copies))
        .collect();
    all.sort_by(|a, b| b.partial_cmp(a).unwrap_or(core::cmp::Ordering::Equal));
    all
}

/// The limit of a sequence a + sum_i c_i ratios_i^k, from its latest terms.
///
/// Eliminates one ratio after the other, largest first, and keeps the order at which successive results agree best: more
/// orders remove more of the tail but amplify rounding. No number for an empty sequence.
pub fn limit<R: Real>(terms: &[R], ratios: &[R], plan: Plan) -> Estimate<R> {
    let mut column: Vec<R> = terms.iter().rev().step_by(plan.stride).copied().collect();
    column.reverse();
    let last = column.last().copied().unwrap_or(R::splat(f64::NAN));
    let mut best = Estimate {
        value: last,
        error: f64::INFINITY,
    };
    let mut previous = last;
    for &ratio in ratios.iter().take(plan.orders) {
        if column.len() < 2 {
            break;
        }
        let power = (1..plan.stride).fold(ratio, |power, _| power * ratio);
        let weight = power / (R::ONE - power);
        column = column
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).mul_add(weight, pair[1]))
            .collect();
        let value = column[column.len() - 1];
        // Two signs of error: what the last ratio changed, and how far the results still move along the sequence.
        let drift = match column.len() {
            1 => R::ZERO,
            n => (value - column[n - 2]).abs(),
        };
        let error = (value - previous).abs().max(drift).to_f64();
        if error <= best.error {
            best = Estimate { value, error };
        }
        previous = value;
    }
    let floor = best.value.abs().to_f64() * R::ROUNDOFF;
    best.error = best.error.max(floor);
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// k r^k beside r^k, as in derivatives where r changes.
    #[test]
    fn ratios_that_change_are_removed_twice() {
        let all = ratios(&[1.0, 0.9], 0.5, 2, 2);
        assert_eq!(all, [0.5, 0.5, 0.45, 0.45, 0.25, 0.25, 0.225, 0.225]);
        let term = |k: i32| 1.5 + (2.0 - 0.7 * f64::from(k)) * f64::powi(0.5, k);
        let terms: Vec<f64> = (0..4).map(term).collect();
        let plan = Plan {
            stride: 1,
            orders: 8,
        };
        let found = limit(&terms, &ratios(&[1.0], 0.5, 1, 2), plan);
        assert!((found.value - 1.5).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn known_tails_are_removed() {
        let ratios = [0.87, 0.76, 0.7, 0.61, 0.6];
        let terms: Vec<f64> = (0..40)
            .map(|k| {
                ratios
                    .iter()
                    .enumerate()
                    .map(|(i, &ratio)| libm::pow(ratio, f64::from(k)) * (i as f64 - 1.5))
                    .sum::<f64>()
                    + 2.5
            })
            .collect();
        let plan = Plan {
            stride: 3,
            orders: 5,
        };
        let found = limit(&terms, &ratios, plan);
        assert!((found.value - 2.5).abs() < 1e-11, "{found:?}");
        assert!(found.error < 1e-3);
        let rough = limit(&terms[..10], &ratios, plan);
        assert!((rough.value - 2.5).abs() <= 3.0 * rough.error, "{rough:?}");
    }
}
