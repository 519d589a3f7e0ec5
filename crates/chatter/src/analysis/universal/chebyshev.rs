//! Chebyshev interpolants in double-double: how the series of this module are found before they are rounded.

use crate::numerics::{DoubleDouble, Real, Scalar};

/// A polynomial on an interval, by its Chebyshev coefficients.
#[derive(Clone, Debug)]
pub(super) struct Chebyshev {
    low: DoubleDouble,
    /// Two over the length of the interval.
    scale: DoubleDouble,
    coefficients: Vec<DoubleDouble>,
}

/// Where to sample, and the cosines that turn samples into coefficients: shared by many fits.
pub(super) struct Grid {
    count: usize,
    /// cos(pi i / (2 count)), i = 0 … 4 count - 1. A recurrence would lose digits near the ends of the interval.
    cosines: Vec<DoubleDouble>,
}

impl Grid {
    pub(super) fn new(count: usize) -> Self {
        let step = DoubleDouble::PI / DoubleDouble::from(2.0 * count as f64);
        let cosines = (0..4 * count)
            .map(|i| (step * DoubleDouble::from(i as f64)).sin_cos().1)
            .collect();
        Self { count, cosines }
    }

    /// The points of [low, high] to sample at.
    pub(super) fn points(
        &self,
        low: DoubleDouble,
        high: DoubleDouble,
    ) -> impl Iterator<Item = DoubleDouble> {
        (0..self.count).map(move |j| {
            low + (high - low)
                * (DoubleDouble::ONE + self.cosines[2 * j + 1])
                * DoubleDouble::from(0.5)
        })
    }

    /// The interpolant on [low, high] of the values at [`points`](Self::points), in their order.
    pub(super) fn interpolate(
        &self,
        low: DoubleDouble,
        high: DoubleDouble,
        values: &[DoubleDouble],
    ) -> Chebyshev {
        let period = 4 * self.count;
        let norm = DoubleDouble::from(2.0) / DoubleDouble::from(self.count as f64);
        let coefficients = (0..self.count)
            .map(|k| {
                let mut sum = DoubleDouble::ZERO;
                for (j, &value) in values.iter().enumerate() {
                    sum += value * self.cosines[k * (2 * j + 1) % period];
                }
                sum * norm * DoubleDouble::from(if k == 0 { 0.5 } else { 1.0 })
            })
            .collect();
        Chebyshev {
            low,
            scale: DoubleDouble::from(2.0) / (high - low),
            coefficients,
        }
    }
}

impl Chebyshev {
    fn normalised(&self, x: DoubleDouble) -> DoubleDouble {
        (x - self.low) * self.scale - DoubleDouble::ONE
    }

    /// The value at `x`.
    pub(super) fn at(&self, x: DoubleDouble) -> DoubleDouble {
        let z = self.normalised(x);
        let twice = z + z;
        let (mut next, mut after) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
        for &coefficient in self.coefficients[1..].iter().rev() {
            (next, after) = (coefficient + twice * next - after, next);
        }
        self.coefficients[0] + z * next - after
    }

    /// The values at `x` and `y` and the divided difference between them, which does not lose digits where they are
    /// close and is the derivative where they are equal.
    pub(super) fn pair(
        &self,
        x: DoubleDouble,
        y: DoubleDouble,
    ) -> (DoubleDouble, DoubleDouble, DoubleDouble) {
        let (zx, zy) = (self.normalised(x), self.normalised(y));
        let zero = DoubleDouble::ZERO;
        let ((mut bx, mut cx), (mut by, mut cy)) = ((zero, zero), (zero, zero));
        // The Clenshaw recurrence of the difference: b_k(x) - b_k(y) over x - y.
        let (mut bd, mut cd) = (zero, zero);
        for &coefficient in self.coefficients[1..].iter().rev() {
            (bd, cd) = ((zx + zx) * bd + (by + by) - cd, bd);
            (bx, cx) = (coefficient + (zx + zx) * bx - cx, bx);
            (by, cy) = (coefficient + (zy + zy) * by - cy, by);
        }
        (
            self.coefficients[0] + zx * bx - cx,
            self.coefficients[0] + zy * by - cy,
            (zx * bd + by - cd) * self.scale,
        )
    }

    /// How many coefficients to keep so that the rest sums to less than `tolerance` of the largest.
    fn length_to(&self, tolerance: f64) -> usize {
        let size = |c: &DoubleDouble| c.abs().to_f64();
        let largest = self.coefficients.iter().map(size).fold(0.0, f64::max);
        let mut tail = 0.0;
        let kept = self.coefficients.iter().rposition(|c| {
            tail += size(c);
            tail > tolerance * largest
        });
        kept.map_or(1, |last| last + 1)
    }

    /// Coefficients of the powers of z in [-1, 1], after dropping the tail that is below `tolerance` of the largest.
    pub(super) fn monomials(&self, tolerance: f64) -> Vec<DoubleDouble> {
        let length = self.length_to(tolerance);
        let mut sum = vec![DoubleDouble::ZERO; length];
        let mut previous = vec![DoubleDouble::ZERO; length + 1];
        let mut current = vec![DoubleDouble::ZERO; length + 1];
        previous[0] = DoubleDouble::ONE;
        current[1] = DoubleDouble::ONE;
        for (k, &coefficient) in self.coefficients[..length].iter().enumerate() {
            for (into, &power) in sum.iter_mut().zip(&previous) {
                *into += coefficient * power;
            }
            if k + 1 < length {
                let mut next = vec![DoubleDouble::ZERO; length + 1];
                for i in 0..length {
                    next[i + 1] = current[i] + current[i];
                }
                for (into, &old) in next.iter_mut().zip(&previous) {
                    *into -= old;
                }
                (previous, current) = (current, next);
            }
        }
        sum
    }

    /// Size of the last coefficients against the largest: how well the interpolant is resolved.
    #[cfg(test)]
    pub(super) fn tail(&self) -> f64 {
        let largest = self
            .coefficients
            .iter()
            .fold(0.0_f64, |a, b| a.max(b.abs().to_f64()));
        let last = &self.coefficients[self.coefficients.len() - 2..];
        last.iter().fold(0.0_f64, |a, b| a.max(b.abs().to_f64())) / largest
    }
}
