//! What is certain of a guard's polynomial along a step: that it has no zero that matters, that it falls, that it changes its sign once.
//!
//! By bounds, cheapest first; in lanes each by its own numbers.

use super::NOISE_ROUNDOFFS;
use crate::expressions::MAX_ORDER;
use crate::flow::modes::guard::Guard;
use crate::numerics::polynomial::{
    bernstein, bernstein_from, horner, horner_with_slope, magnitude,
};
use crate::numerics::roots::Crossing;
use crate::numerics::{Mask, Scalar};

/// A coefficient of p, or zero beyond the last. No closure: one need not be inlined, and then it is compiled for the baseline.
#[inline(always)]
pub(super) fn coefficient<S: Scalar>(p: &[S], k: usize) -> S {
    match p.get(k) {
        Some(&coefficient) => coefficient,
        None => S::splat(0.0),
    }
}

/// The whole numbers that a derivative multiplies coefficients by.
static FACTORS: [f64; MAX_ORDER + 1] = {
    let mut factors = [0.0; MAX_ORDER + 1];
    let mut k = 0;
    while k <= MAX_ORDER {
        factors[k] = k as f64;
        k += 1;
    }
    factors
};

/// The slopes at 0 and s of the quadratic that p begins with, and by how much that of p differs from one between them on
/// [0, s], at most. `beyond` is that of the [`sizes`] of what follows the constant term, at s or further on: the terms after the
/// fourth, of which none has a higher degree than the last, are bounded as a whole.
#[inline(always)]
fn leading_slopes<S: Scalar>(p: &[S], s: S, beyond: S) -> ([S; 2], S) {
    let (first, degree) = (p[1], S::splat((p.len() - 1) as f64));
    let (second, third, fourth) = (S::splat(2.0), S::splat(3.0), S::splat(4.0));
    let last = (coefficient(p, 2) * second).mul_add(s, first);
    let square = s * s;
    let high = (beyond * degree).mul_add(s, (coefficient(p, 4) * fourth).abs());
    let rest = high.mul_add(s, (coefficient(p, 3) * third).abs()) * square;
    ([first, last], rest)
}

/// [`falls_steadily`], by the leading terms.
#[inline(always)]
pub(super) fn falls_by_leading<S: Scalar>(p: &[S], s: S, beyond: S) -> S::Mask {
    let ([first, last], rest) = leading_slopes(p, s, beyond);
    (first.max(last) + rest).less(S::splat(0.0))
}

/// What a guard's polynomial p has ahead on [0, `end`].
#[derive(Clone, Copy)]
pub(super) struct Ahead<S> {
    /// Its value at 0.
    pub start: S,
    pub end: S,
    /// Below this a value is no value.
    pub noise: S,
    /// As for [`leading_slopes`].
    pub beyond: S,
}

impl<S: Scalar> Ahead<S> {
    /// Where nothing happens: p keeps its sign, or changes it in the direction that is none of the guard's. Certificates, cheapest
    /// first, until all lanes beside those `settled` have one. A section's function that keeps its sign is beyond noise everywhere.
    /// With the value of p at the end.
    #[inline(always)]
    pub(super) fn has_no_event(
        &self,
        p: &[S],
        guard: &Guard,
        settled: S::Mask,
        scratch: &mut [S],
    ) -> (S::Mask, S) {
        let Self { end, noise, .. } = *self;
        let value = horner(p, end);
        let mut settled = settled | self.runs_steadily((p, value), guard.crossing);
        if !settled.all() {
            settled = settled | keeps_sign(p, end, noise, scratch);
        }
        if !settled.all() && guard.section().is_none() {
            settled = settled | rises(p, end, noise, NOISE_ROUNDOFFS * S::ROUNDOFF, scratch);
        }
        (settled, value)
    }

    /// [`has_no_event`](Self::has_no_event) by the leading terms: p runs steadily from its value at 0 to that at the end, which both
    /// are beyond noise, on one side of zero or from below to above.
    #[inline(always)]
    fn runs_steadily(&self, (p, value): (&[S], S), crossing: Crossing) -> S::Mask {
        let Self {
            start,
            end,
            noise,
            beyond,
        } = *self;
        let ([first, last], rest) = leading_slopes(p, end, beyond);
        let (rises, falls) = (rest.less(first.min(last)), first.max(last).less(-rest));
        let is_steady = rises | falls;
        let stays = noise.less(start.min(value)) | start.max(value).less(-noise);
        let only_rises = rises & start.less(-noise) & noise.less(value);
        let is_none = S::Mask::splat(crossing == Crossing::Falling);
        is_steady & (stays | (only_rises & is_none))
    }
}

/// Whether p' < 0 on all of [0, s], by bounding what follows the quadratic: then p has no other root there.
#[inline(always)]
pub(super) fn falls_steadily<S: Scalar>(p: &[S], s: S) -> S::Mask {
    let zero = S::splat(0.0);
    let first = p[1];
    let bend = match p.get(2) {
        Some(&c) => c + c,
        None => zero,
    };
    // Even and odd powers need not wait for each other.
    let square = s * s;
    let (mut even, mut odd) = (zero, zero);
    let high = p.get(3..).unwrap_or_default();
    let factors = &FACTORS[3..3 + high.len()];
    let (fours, factors) = (high.chunks_exact(4), factors.chunks_exact(4));
    let pairs = fours.remainder().chunks_exact(2);
    let of_pairs = factors.remainder().chunks_exact(2);
    if let ([c], &[k]) = (pairs.remainder(), of_pairs.remainder()) {
        odd = c.abs() * S::splat(k);
    }
    for (pair, k) in pairs.rev().zip(of_pairs.rev()) {
        even = even.mul_add(square, pair[1].abs() * S::splat(k[1]));
        odd = odd.mul_add(square, pair[0].abs() * S::splat(k[0]));
    }
    for (four, k) in fours.rev().zip(factors.rev()) {
        even = even.mul_add(square, four[3].abs() * S::splat(k[3]));
        odd = odd.mul_add(square, four[2].abs() * S::splat(k[2]));
        even = even.mul_add(square, four[1].abs() * S::splat(k[1]));
        odd = odd.mul_add(square, four[0].abs() * S::splat(k[0]));
    }
    let rest = even.mul_add(s, odd) * square;
    let last = bend.mul_add(s, first);
    (first.max(last) + rest).less(zero)
}

/// Whether p has one sign on all of [0, s] by its leading terms: the Bernstein coefficients of these enclose them, and what
/// follows is at most as large as the sum of its terms' sizes.
///
/// Terms fall by a factor of five and more from one to the next, so that few of them say nearly as much as all, and they
/// cost a tenth.
#[inline(always)]
fn keeps_sign<S: Scalar>(p: &[S], s: S, noise: S, scratch: &mut [S]) -> S::Mask {
    const LEADING: usize = 6;
    if p.len() <= LEADING {
        return S::Mask::splat(false);
    }
    let square = s * s;
    let beyond = square * square * square;
    let level = magnitude(&p[LEADING..], s).mul_add(beyond, noise);
    let leading = &mut scratch[..LEADING];
    bernstein(&p[..LEADING], s, leading);
    let (mut least, mut greatest) = (leading[0], leading[0]);
    for &value in &leading[1..] {
        least = value.min(least);
        greatest = value.max(greatest);
    }
    level.less(least) | greatest.less(-level)
}

/// Whether p > 0 on all of [0, s] although it may first dip, as the gap does after the last impact before release.
///
/// Up to e = c |p_1| / p_2 the dip is a quadratic's, whose coefficient p_2 the higher terms lessen a little, or where that says too
/// little p lies above its tangent near the lowest place; beyond e the leading terms exceed (1 - 1/c) p_2 s^2, and what that leaves
/// of p / s^2 is positive by its Bernstein coefficients.
#[inline(always)]
fn rises<S: Scalar>(p: &[S], s: S, noise: S, noise_factor: f64, scratch: &mut [S]) -> S::Mask {
    const MARGIN: f64 = 1.001;
    const FAR: f64 = 3.0;
    let n = p.len();
    if n < 4 {
        return S::Mask::splat(false);
    }
    let zero = S::splat(0.0);
    let dip = S::select(p[1].less(zero), -p[1], zero);
    let near = (S::splat(FAR) * dip / p[2]).min(s);
    let least_bend = p[2] - near * magnitude(&p[3..], near);
    let may_rise = zero.less(p[2]) & noise.less(p[0]);
    let mut rootless = (S::splat(MARGIN / 4.0) * dip * dip).less(p[0] * least_bend);
    if (may_rise & !rootless).any() {
        rootless = rootless | stays_above_tangent(p, near, noise);
    }
    let candidate = rootless & may_rise;
    if !candidate.any() {
        return candidate;
    }
    let g = &mut scratch[..n - 2];
    let level = magnitude(&p[2..], s) * S::splat(noise_factor);
    bernstein_from(p[2] * S::splat(1.0 - 1.0 / FAR), &p[3..], s, g);
    let mut least = g[0];
    for &value in &g[1..] {
        least = value.min(least);
    }
    candidate & level.less(least)
}

/// Whether p > 0 on all of [0, s] since it bends upwards there, and so lies above its tangent at a place, which is near the lowest.
#[inline(always)]
fn stays_above_tangent<S: Scalar>(p: &[S], s: S, noise: S) -> S::Mask {
    let (zero, two, three) = (S::splat(0.0), S::splat(2.0), S::splat(3.0));
    let mut bend = zero;
    for (k, &c) in p.iter().enumerate().skip(3).rev() {
        bend = bend.mul_add(s, c.abs() * S::splat((k * (k - 1)) as f64));
    }
    let twice = p[2] * two;
    let bends = (bend * s).less(twice);
    if !bends.any() {
        return bends;
    }
    // That of the leading quadratic, and a step of Newton's method from there for the leading cubic.
    let lowest = -p[1] / twice;
    let square = lowest * lowest;
    let lowest = lowest - p[3] * three * square / (p[3] * two * three).mul_add(lowest, twice);
    let at = lowest.max(zero).min(s);
    let (value, slope) = horner_with_slope(p, at);
    bends & noise.less(value - slope.abs() * s)
}

/// Sign changes among Bernstein coefficients.
pub(super) struct SignCount<S: Scalar> {
    pub none: S::Mask,
    pub one: S::Mask,
    /// Index, with its fraction, where the control polygon first changes sign.
    pub first_change: S,
}

impl<S: Scalar> SignCount<S> {
    #[inline(always)]
    pub(super) fn of(values: &[S], noise: S) -> Self {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        let mut changes = zero;
        let mut clear = noise.less(values[0].abs());
        // The two values about the first change, and the place of the first of them.
        let (mut place, mut before, mut after) = (zero, one, zero);
        for (i, pair) in values.windows(2).enumerate() {
            clear = clear & noise.less(pair[1].abs());
            let turned = (pair[0].less(zero) & zero.at_most(pair[1]))
                | (zero.at_most(pair[0]) & pair[1].less(zero));
            let is_first = turned & changes.less(S::splat(0.5));
            place = S::select(is_first, S::splat(i as f64), place);
            before = S::select(is_first, pair[0], before);
            after = S::select(is_first, pair[1], after);
            changes = S::select(turned, changes + one, changes);
        }
        let first_change = place + before / (before - after);
        Self {
            none: clear & changes.less(S::splat(0.5)),
            one: clear & S::splat(0.5).less(changes) & changes.less(S::splat(1.5)),
            first_change,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::step::Workspace;
    use crate::numerics::polynomial::{LEADING, sizes};
    use proptest::prelude::*;

    fn ahead(p: &[f64], end: f64) -> Ahead<f64> {
        let sizes = sizes(&p[1..], end);
        Ahead {
            start: p[0],
            end,
            noise: Workspace::<f64>::NOISE * sizes.all.mul_add(end, p[0].abs()),
            beyond: sizes.beyond,
        }
    }

    #[test]
    fn a_dip_that_stays_little_above_zero_is_told_from_one_that_does_not() {
        // Of the valve, after the last impact before a release.
        let rises = |start: f64| {
            let p = [start, -3.75e-4, 2.90e-3, -3.07e-4, -2e-5];
            let noise = Workspace::<f64>::NOISE * magnitude(&p, 1.1);
            rises(&p, 1.1, noise, Workspace::<f64>::NOISE, &mut [0.0; 8])
        };
        // The lowest values are 3e-6, 5e-7, 3e-8 and -2e-8.
        assert!(rises(1.52e-5));
        assert!(rises(1.27e-5));
        assert!(rises(1.224e-5));
        assert!(!rises(1.219e-5));
    }

    #[test]
    fn steady_runs_are_told_by_their_ends() {
        let runs = |p: &[f64], crossing| ahead(p, 1.0).runs_steadily((p, horner(p, 1.0)), crossing);
        for crossing in [Crossing::Falling, Crossing::Either] {
            assert!(runs(&[1.0, -0.5, 0.01, 0.02, -0.01, 0.001], crossing));
            assert!(runs(&[-1.0, 0.5], crossing));
            // Through zero, to zero, and with a dip.
            assert!(!runs(&[1.0, -1.5], crossing));
            assert!(!runs(&[1.0, -1.0], crossing));
            assert!(!runs(&[0.2, -1.0, 1.0], crossing));
        }
        // A rise through zero is none of the events of what falls.
        assert!(runs(&[-1.0, 1.5], Crossing::Falling));
        assert!(!runs(&[-1.0, 1.5], Crossing::Either));
    }

    proptest! {
        #[test]
        fn what_is_certain_by_the_leading_terms_holds_at_every_place(
            factors in proptest::collection::vec(-1.0_f64..1.0, 2..27),
            falls_off in 0.1_f64..0.9,
            end in 0.1_f64..2.0,
        ) {
            let mut size = 1.0;
            let p: Vec<f64> = factors
                .iter()
                .map(|factor| {
                    size *= falls_off;
                    factor * size
                })
                .collect();
            let ahead = ahead(&p, end);
            let places = (0..=200).map(|i| end * f64::from(i) / 200.0);
            let at: Vec<(f64, f64)> = places.map(|s| horner_with_slope(&p, s)).collect();
            if falls_by_leading(&p, end, ahead.beyond) {
                prop_assert!(at.iter().all(|&(_, slope)| slope < 0.0));
            }
            if ahead.runs_steadily((&p, horner(&p, end)), Crossing::Either) {
                prop_assert!(at.iter().all(|&(value, _)| value * p[0] > 0.0));
            }
            if ahead.runs_steadily((&p, horner(&p, end)), Crossing::Falling) {
                prop_assert!(at.windows(2).all(|w| !(w[0].0 > 0.0 && w[1].0 <= 0.0)));
            }
            let mut scratch = vec![0.0; p.len()];
            if rises(&p, end, ahead.noise, Workspace::<f64>::NOISE, &mut scratch) {
                prop_assert!(at.iter().all(|&(value, _)| value > 0.0));
            }
            // The bound is that of all terms but for those that are bounded as a whole.
            if p.len() <= LEADING + 1 && falls_steadily(&p, end) {
                prop_assert!(falls_by_leading(&p, end, ahead.beyond));
            }
        }
    }
}
