//! Polynomials in the scaled time, lowest coefficient first.

use super::{DoubleDouble, Scalar};
use std::sync::LazyLock;

/// Highest degree that [`bernstein`] converts.
pub const MAX_DEGREE: usize = 50;

/// Reciprocals of the binomial coefficients: row `n`, column `k`.
static INVERSE_BINOMIALS: LazyLock<Vec<Vec<DoubleDouble>>> = LazyLock::new(|| {
    let one = DoubleDouble::from(1.0);
    (0..=MAX_DEGREE)
        .map(|n| {
            let mut binomial = 1.0_f64;
            let mut row = vec![one];
            for k in 1..=n {
                // Exact: every binomial coefficient of degree 50 has at most 47 bits.
                binomial = binomial * (n + 1 - k) as f64 / k as f64;
                row.push(one / DoubleDouble::from(binomial));
            }
            row
        })
        .collect()
});

// Loops, not folds: an iterator's method is not always inlined into a kernel, and then it is compiled for the baseline.

/// p(s), the even and the odd powers each by Horner's rule: two sums that need not wait for each other.
#[inline(always)]
pub fn horner<S: Scalar>(coefficients: &[S], s: S) -> S {
    let square = s * s;
    let (mut even, mut odd) = (S::splat(0.0), S::splat(0.0));
    let pairs = coefficients.chunks_exact(2);
    if let &[last] = pairs.remainder() {
        even = last;
    }
    for pair in pairs.rev() {
        even = even.mul_add(square, pair[0]);
        odd = odd.mul_add(square, pair[1]);
    }
    odd.mul_add(s, even)
}

/// p(s) and p'(s).
#[inline(always)]
pub fn horner_with_slope<S: Scalar>(coefficients: &[S], s: S) -> (S, S) {
    S::horner_with_slope(coefficients, s)
}

/// sum_k |c_k| s^k for s >= 0: no partial sum of p on [0, s] is larger.
#[inline(always)]
pub fn magnitude<S: Scalar>(coefficients: &[S], s: S) -> S {
    let mut sum = S::splat(0.0);
    for &c in coefficients.iter().rev() {
        sum = sum.mul_add(s, c.abs());
    }
    sum
}

/// [`magnitude`] as four sums that need not wait for each other: where the whole step waits for it.
#[inline(always)]
pub(crate) fn short_magnitude<S: Scalar>(coefficients: &[S], s: S) -> S {
    let square = s * s;
    let fourth = square * square;
    let chunks = coefficients.chunks_exact(4);
    let rest = chunks.remainder();
    let size = |place: usize| rest.get(place).map_or(S::splat(0.0), |c| c.abs());
    let mut sums = [size(0), size(1), size(2), S::splat(0.0)];
    for chunk in chunks.rev() {
        if let &[first, second, third, last] = chunk {
            sums = [
                sums[0].mul_add(fourth, first.abs()),
                sums[1].mul_add(fourth, second.abs()),
                sums[2].mul_add(fourth, third.abs()),
                sums[3].mul_add(fourth, last.abs()),
            ];
        }
    }
    let low = sums[1].mul_add(s, sums[0]);
    let high = sums[3].mul_add(s, sums[2]);
    high.mul_add(square, low)
}

/// p^(order)(0) / order!, and by how much that may change within a distance of `s` to either side, at most.
pub fn derivative_bound<S: Scalar>(coefficients: &[S], order: usize, s: S) -> (S, S) {
    let (mut change, mut power, mut binomial) = (S::splat(0.0), s, 1.0);
    for (above, &c) in coefficients[order + 1..].iter().enumerate() {
        binomial *= (order + above + 1) as f64 / (above + 1) as f64;
        change = (c.abs() * S::splat(binomial)).mul_add(power, change);
        power *= s;
    }
    (coefficients[order], change)
}

/// Bernstein coefficients of p on [0, width]: their signs bound the number of roots there (Descartes' rule), and p lies
/// between the least and the greatest of them.
///
/// `out` receives as many values as there are coefficients. Rounding errors stay below the degree times the roundoff
/// times [`magnitude`].
#[inline(always)]
pub fn bernstein<S: Scalar>(coefficients: &[S], width: S, out: &mut [S]) {
    bernstein_from(
        coefficients[0],
        &coefficients[1..],
        width,
        &mut out[..coefficients.len()],
    );
}

/// [`bernstein`] of a polynomial given as its constant term and the coefficients after it.
#[inline(always)]
pub fn bernstein_from<S: Scalar>(constant: S, rest: &[S], width: S, out: &mut [S]) {
    let n = rest.len() + 1;
    let row = &INVERSE_BINOMIALS[n - 1][1..];
    let out = &mut out[..n];
    out[0] = constant;
    let mut power = width;
    for ((value, &c), &inverse) in out[1..].iter_mut().zip(rest).zip(row) {
        *value = c * power * S::from_double_double(inverse);
        power *= width;
    }
    // The scaled coefficients are the forward differences of the Bernstein ones: sum them up, antidiagonal by
    // antidiagonal.
    for first in 1..n {
        for i in (first..n).rev() {
            let below = out[i - 1];
            out[i] += below;
        }
    }
}

/// Splits Bernstein coefficients at the middle (de Casteljau): `left` becomes those of the left half, the result is the
/// right half's.
#[inline(always)]
pub fn split<S: Scalar>(left: &mut [S]) -> Vec<S> {
    let n = left.len();
    let half = S::splat(0.5);
    let mut right = vec![S::splat(0.0); n];
    for step in 0..n {
        right[n - 1 - step] = left[n - 1];
        for i in (step + 1..n).rev() {
            left[i] = (left[i - 1] + left[i]) * half;
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bernstein_of_a_quadratic() {
        // 1 - 3 s + s^2 on [0, 2]: values 1, -2, -1 at the Bernstein points.
        let mut out = [0.0; 3];
        bernstein(&[1.0, -3.0, 1.0], 2.0, &mut out);
        assert_eq!(out, [1.0, -2.0, -1.0]);
        let right = split(&mut out);
        assert_eq!(out, [1.0, -0.5, -1.0]);
        assert_eq!(right, [-1.0, -1.5, -1.0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn bernstein_coefficients_enclose_the_polynomial(
            coefficients in proptest::collection::vec(-1.0_f64..1.0, 2..27),
            width in 0.1_f64..1.5,
            at in 0.0_f64..1.0,
        ) {
            let mut out = vec![0.0; coefficients.len()];
            bernstein(&coefficients, width, &mut out);
            let noise = 1e-14 * magnitude(&coefficients, width);
            let value = horner(&coefficients, at * width);
            let least = out.iter().copied().fold(f64::INFINITY, f64::min);
            let most = out.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(least - noise <= value && value <= most + noise);
            prop_assert!((out[0] - coefficients[0]).abs() <= noise);
            prop_assert!((out[out.len() - 1] - horner(&coefficients, width)).abs() <= noise);
            let mut left = out.clone();
            let right = split(&mut left);
            prop_assert!((left[left.len() - 1] - horner(&coefficients, width / 2.0)).abs() <= noise);
            prop_assert_eq!(left[left.len() - 1], right[0]);
        }
    }
}
