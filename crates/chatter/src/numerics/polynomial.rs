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
    let mut sums = [S::splat(0.0); 2];
    // Two pairs at a time, after those that are left over at the top. A pair is a loop of its own: for single numbers one
    // instruction.
    let fours = coefficients.chunks_exact(4);
    let pairs = fours.remainder().chunks_exact(2);
    if let [last] = pairs.remainder() {
        sums[0] = *last;
    }
    for pair in pairs.rev() {
        for k in 0..2 {
            sums[k] = sums[k].mul_add(square, pair[k]);
        }
    }
    for four in fours.rev() {
        for k in 0..2 {
            sums[k] = sums[k].mul_add(square, four[k + 2]);
        }
        for k in 0..2 {
            sums[k] = sums[k].mul_add(square, four[k]);
        }
    }
    let [even, odd] = sums;
    odd.mul_add(s, even)
}

/// p(s) and p'(s), each as [`horner`].
#[inline(always)]
pub fn horner_with_slope<S: Scalar>(coefficients: &[S], s: S) -> (S, S) {
    let square = s * s;
    let (mut sums, mut slopes) = ([S::splat(0.0); 2], [S::splat(0.0); 2]);
    let fours = coefficients.chunks_exact(4);
    let pairs = fours.remainder().chunks_exact(2);
    if let [last] = pairs.remainder() {
        sums[0] = *last;
    }
    for pair in pairs.rev() {
        for k in 0..2 {
            slopes[k] = slopes[k].mul_add(square, sums[k]);
            sums[k] = sums[k].mul_add(square, pair[k]);
        }
    }
    for four in fours.rev() {
        for k in 0..2 {
            slopes[k] = slopes[k].mul_add(square, sums[k]);
            sums[k] = sums[k].mul_add(square, four[k + 2]);
        }
        for k in 0..2 {
            slopes[k] = slopes[k].mul_add(square, sums[k]);
            sums[k] = sums[k].mul_add(square, four[k]);
        }
    }
    let ([even, odd], [even_slope, odd_slope]) = (sums, slopes);
    let value = odd.mul_add(s, even);
    let slope = (s + s).mul_add(odd_slope.mul_add(s, even_slope), odd);
    (value, slope)
}

/// [`horner_with_slope`] of an even number of leading terms, at least four.
#[inline(always)]
pub(crate) fn leading_with_slope<S: Scalar, const N: usize>(leading: &[S; N], s: S) -> (S, S) {
    let square = s * s;
    let mut slopes = [leading[N - 2], leading[N - 1]];
    let mut sums = slopes;
    for k in 0..2 {
        sums[k] = sums[k].mul_add(square, leading[N - 4 + k]);
    }
    for pair in (0..N / 2 - 2).rev() {
        for k in 0..2 {
            slopes[k] = slopes[k].mul_add(square, sums[k]);
            sums[k] = sums[k].mul_add(square, leading[2 * pair + k]);
        }
    }
    let ([even, odd], [even_slope, odd_slope]) = (sums, slopes);
    let value = odd.mul_add(s, even);
    let slope = (s + s).mul_add(odd_slope.mul_add(s, even_slope), odd);
    (value, slope)
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

/// So many leading terms [`Sizes`] tells from the others.
pub(crate) const LEADING: usize = 4;

/// Sums of the sizes of a polynomial's terms at s >= 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes<S> {
    /// Of all: [`magnitude`].
    pub all: S,
    /// Of those after the leading four, over s^4.
    pub beyond: S,
}

/// The sums of sizes, of even and of odd powers as in [`horner`].
#[inline(always)]
pub(crate) fn sizes<S: Scalar>(coefficients: &[S], s: S) -> Sizes<S> {
    let zero = S::splat(0.0);
    let Some((leading, others)) = coefficients.split_first_chunk::<LEADING>() else {
        let mut all = zero;
        for c in coefficients.iter().rev() {
            all = all.mul_add(s, c.abs());
        }
        return Sizes { all, beyond: zero };
    };
    let square = s * s;
    let mut sums = [zero; 2];
    let pairs = others.chunks_exact(2);
    if let [last] = pairs.remainder() {
        sums[0] = last.abs();
    }
    for pair in pairs.rev() {
        for k in 0..2 {
            sums[k] = sums[k].mul_add(square, pair[k].abs());
        }
    }
    let beyond = sums[1].mul_add(s, sums[0]);
    for first in [2, 0] {
        for k in 0..2 {
            sums[k] = sums[k].mul_add(square, leading[first + k].abs());
        }
    }
    Sizes {
        all: sums[1].mul_add(s, sums[0]),
        beyond,
    }
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
    let mut first = 1;
    while first + 3 < n {
        add_up::<S, 4>(out, first);
        first += 4;
    }
    while first < n {
        add_up::<S, 1>(out, first);
        first += 1;
    }
}

/// Adds to each number from `first` on the one before it, `TIMES` times in turn, each time from one place further on. All in one
/// run, which hands sums from one to the next.
#[inline(always)]
fn add_up<S: Scalar, const TIMES: usize>(out: &mut [S], first: usize) {
    let (before, rest) = out.split_at_mut(first);
    let Some(&last) = before.last() else { return };
    // What the number before was after so many times.
    let mut below = [last; TIMES];
    let (begin, rest) = rest.split_at_mut((TIMES - 1).min(rest.len()));
    for (done, value) in begin.iter_mut().enumerate() {
        let mut sum = *value;
        for (time, below) in below.iter_mut().enumerate() {
            let next = if time <= done { sum + *below } else { sum };
            *below = sum;
            sum = next;
        }
        *value = sum;
    }
    for value in rest {
        let mut sum = *value;
        for below in &mut below {
            let next = sum + *below;
            *below = sum;
            sum = next;
        }
        *value = sum;
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
        fn sums_of_sizes_are_those_of_all_terms_and_of_those_after_the_leading(
            coefficients in proptest::collection::vec(-1.0_f64..1.0, 0..27),
            s in 0.0_f64..1.5,
        ) {
            let found = sizes(&coefficients, s);
            let all = magnitude(&coefficients, s);
            prop_assert!((found.all - all).abs() <= 1e-13 * all);
            let beyond = magnitude(coefficients.get(LEADING..).unwrap_or_default(), s);
            prop_assert!((found.beyond - beyond).abs() <= 1e-13 * beyond);
        }

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
