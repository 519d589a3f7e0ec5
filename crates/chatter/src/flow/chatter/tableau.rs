//! Richardson's tableau with known ratios, and its derivative.
//!
//! A quantity y_k = y + c_1 rho^k + c_2 rho^(2k) + … loses one term in each column, (y, x now and before)
//!
//! ```text
//! L = y + (y - x) rho / (1 - rho)
//! ```
//!
//! with rho, rho^2, …. Where rho changes by d rho, the derivatives of y_k contain k rho^k, k rho^(2k), …; the tableau
//! differentiated, weights included, annihilates these from the same samples (MATH.md 10):
//!
//! ```text
//! dL = dy + (dy - dx) rho / (1 - rho) + (y - x) drho / (1 - rho)^2
//! ```

use crate::numerics::Real;

/// The weights of the tableau's columns.
#[derive(Clone, Debug)]
pub(super) struct Weights<R> {
    columns: Vec<ColumnWeights<R>>,
}

#[derive(Clone, Debug)]
struct ColumnWeights<R> {
    /// rho / (1 - rho).
    weight: R,
    /// d rho / (1 - rho)^2 in each direction.
    slopes: Vec<R>,
}

impl<R: Real> Weights<R> {
    /// For samples every `stride` impacts of a sequence with a restitution, given with its derivatives.
    pub(super) fn new(restitution: R, slopes: &[R], stride: u32, samples: usize) -> Self {
        let zero = R::ZERO;
        let ratio = if restitution > zero {
            restitution.powf(R::splat(f64::from(stride)))
        } else {
            zero
        };
        let ratio_slope = |slope: R| {
            if stride == 1 {
                slope
            } else if restitution > zero {
                R::splat(f64::from(stride)) * ratio / restitution * slope
            } else {
                zero
            }
        };
        let ratio_slopes: Vec<R> = slopes.iter().map(|&slope| ratio_slope(slope)).collect();
        let (mut before, mut power) = (R::ONE, ratio);
        let columns = (1..samples.max(1))
            .map(|m| {
                let rest = R::ONE - power;
                let factor = R::splat(m as f64) * before / (rest * rest);
                let column = ColumnWeights {
                    weight: power / rest,
                    slopes: ratio_slopes.iter().map(|&slope| factor * slope).collect(),
                };
                before = power;
                power *= ratio;
                column
            })
            .collect();
        Self { columns }
    }
}

/// An extrapolated quantity, from where its latest sample is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit<R> {
    pub distance: R,
    /// By how much the last two entries of the tableau differ.
    pub error: R,
    /// By how much those before them lead to expect that they differ: they may agree by chance.
    pub expected: R,
    /// The largest distance of a sample.
    pub extent: R,
}

/// Extrapolates distances from the latest sample, and in place their derivatives in each direction: both are overwritten.
pub(super) fn extrapolate<R: Real>(
    values: &mut [R],
    derivatives: &mut [Vec<R>],
    weights: &Weights<R>,
) -> (Limit<R>, Vec<Limit<R>>) {
    let most = |values: &[R]| values.iter().fold(R::ZERO, |most, c| most.max(c.abs()));
    let extent = most(values);
    let extents: Vec<R> = derivatives.iter().map(|d| most(d)).collect();
    let mut before = R::ZERO;
    let mut falls = [R::ZERO; 2];
    let mut befores = vec![R::ZERO; derivatives.len()];
    let samples = values.len();
    for (level, column) in weights.columns.iter().take(samples - 1).enumerate() {
        let entries = samples - level;
        falls = [falls[1], (values[entries - 1] - before).abs()];
        before = values[entries - 1];
        for (derivative, before) in derivatives.iter().zip(&mut befores) {
            *before = derivative[entries - 1];
        }
        for i in 0..entries - 1 {
            let fall = values[i + 1] - values[i];
            for (derivative, &slope) in derivatives.iter_mut().zip(&column.slopes) {
                let (x, y) = (derivative[i], derivative[i + 1]);
                derivative[i] = (y - x).mul_add(column.weight, y) + fall * slope;
            }
            values[i] = fall.mul_add(column.weight, values[i + 1]);
        }
    }
    let limit = |distance: R, before: R, extent: R| Limit {
        distance,
        error: (distance - before).abs(),
        expected: R::ZERO,
        extent,
    };
    let along = (derivatives.iter().zip(befores).zip(extents))
        .map(|((derivative, before), extent)| limit(derivative[0], before, extent))
        .collect();
    let [earlier, late] = falls;
    let shrinks = samples > 3 && late < earlier;
    let expected = if shrinks {
        late * (late / earlier)
    } else {
        R::ZERO
    };
    let value = Limit {
        expected,
        ..limit(values[0], before, extent)
    };
    (value, along)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y_k = sum of a_j(p) rho(p)^(jk) with rho = p^stride: limit a_0 and its derivative from as many samples as terms.
    #[test]
    fn powers_of_the_ratio_and_their_derivatives_are_annihilated() {
        const TERMS: usize = 6;
        for (ratio, slope, stride) in [(0.8, 1.0, 3_u32), (0.5, -2.0, 1), (0.0, 1.0, 1)] {
            let coefficient = |j: usize| 1.0 + 0.3 * (j as f64 * 1.7).sin();
            let moves = |j: usize| (j as f64 * 2.3).cos();
            let mut values = Vec::new();
            let mut derivative = Vec::new();
            for k in 0..TERMS {
                let (mut value, mut rate) = (0.0, 0.0);
                for j in 0..TERMS {
                    let exponent = (k * j) as i32 * stride as i32;
                    let power = f64::powi(ratio, exponent);
                    value += coefficient(j) * power;
                    rate += moves(j) * power;
                    if exponent > 0 {
                        let falls = f64::from(exponent) * f64::powi(ratio, exponent - 1);
                        rate += coefficient(j) * falls * slope;
                    }
                }
                values.push(value);
                derivative.push(rate);
            }
            let mut derivatives = vec![derivative];
            let weights = Weights::new(ratio, &[slope], stride, TERMS);
            let (value, along) = extrapolate(&mut values, &mut derivatives, &weights);
            assert!((value.distance - coefficient(0)).abs() < 1e-14, "{value:?}");
            assert!((along[0].distance - moves(0)).abs() < 1e-12, "{along:?}");
        }
    }
}
