//! Newton's method for the first root of a guard, and where it begins.

use super::certificates::coefficient;
use crate::numerics::polynomial::{horner_with_slope, leading_with_slope};
use crate::numerics::{Mask, Scalar};

/// Newton's method stops once a correction is this small relative to the root: the next would be its square.
const NEWTON_DONE: f64 = 1e-8;
const NEWTON_STEPS: usize = 6;

/// It begins with a step on so many leading terms and one on twice as many, where there are these.
const NEWTON_LEADING: usize = 6;

/// The quadratic that p begins with, at s.
#[inline(always)]
pub(super) fn leading_quadratic<S: Scalar>(p: &[S], s: S) -> S {
    coefficient(p, 2).mul_add(s, p[1]).mul_add(s, p[0])
}

/// The smaller positive root of the leading quadratic, the next impact in the flight of eq. (3), and where it is one; elsewhere
/// any number.
#[inline(always)]
pub(super) fn quadratic_root<S: Scalar>(p: &[S]) -> (S, S::Mask) {
    let zero = S::splat(0.0);
    let (c, b) = (p[0], p[1]);
    let a = coefficient(p, 2);
    let radicand = b.mul_add(b, S::splat(-4.0) * a * c);
    let two_c = c + c;
    let root = two_c / (radicand.max(zero).sqrt() - b);
    (root, zero.at_most(radicand))
}

/// Whether a place is on (0, end].
#[inline(always)]
pub(super) fn is_inside<S: Scalar>(place: S, end: S) -> S::Mask {
    S::splat(0.0).less(place) & place.at_most(end)
}

/// Newton's method from a guess; each lane stops when its own correction is small, whatever the others do. Also tells the
/// slope at the root.
#[inline(always)]
pub(super) fn newton<S: Scalar>(p: &[S], guess: S, end: S) -> (S, S::Mask, S) {
    let zero = S::splat(0.0);
    let far = end + end;
    let usable = is_inside(guess, far);
    let mut at = S::select(usable, guess, end);
    let mut done = !usable;
    // The leading terms bring the guess close at a part of the cost: a few of them where it may be far, more when it is near.
    let mut inverse = zero;
    if let (Some(few), Some(more)) = (p.first_chunk(), p.first_chunk::<{ 2 * NEWTON_LEADING }>()) {
        let next;
        (next, inverse) = chebyshev(few, at);
        at = S::select(usable & is_inside(next, far), next, at);
        let (value, slope) = leading_with_slope(more, at);
        // From where the step of Chebyshev's began: twice, since it was a long one. What comes of slopes that differ more is mended below.
        for _ in 0..2 {
            inverse = nearer_inverse(inverse, slope).0;
        }
        let next = at - value * inverse;
        at = S::select(usable & is_inside(next, far), next, at);
    }
    let mut last_slope = zero;
    // The square of what double-double has to reach is not reached by what suffices for a double; nor is that of the error of an
    // inverse by more than its root.
    let least = NEWTON_DONE * (S::ROUNDOFF * 1e16).sqrt();
    let (least, close) = (S::splat(least), S::splat(least.sqrt()));
    for _ in 0..NEWTON_STEPS {
        let (value, slope) = horner_with_slope(p, at);
        let (nearer, miss) = nearer_inverse(inverse, slope);
        let is_close = miss.abs().at_most(close);
        inverse = nearer;
        if !is_close.all() {
            inverse = S::select(is_close, nearer, S::splat(1.0) / slope);
        }
        let correction = value * inverse;
        last_slope = S::select(done, last_slope, slope);
        at = S::select(done, at, at - correction);
        let small = correction.abs().at_most(at.abs() * least);
        done = done | small;
        if done.all() {
            break;
        }
    }
    (at, done & usable, last_slope)
}

/// The inverse of a slope from that of one nearby, and by what part that was off, of which the square is left.
#[inline(always)]
fn nearer_inverse<S: Scalar>(nearby: S, slope: S) -> (S, S) {
    let miss = (-slope).mul_add(nearby, S::splat(1.0));
    (nearby.mul_add(miss, nearby), miss)
}

/// A step of Chebyshev's method on a few terms: it triples the digits where Newton's doubles them. With the inverse of the slope.
#[inline(always)]
fn chebyshev<S: Scalar>(p: &[S; NEWTON_LEADING], at: S) -> (S, S) {
    const LAST: usize = NEWTON_LEADING - 1;
    let mut half_bend = p[LAST] * S::splat((LAST * (LAST - 1) / 2) as f64);
    for k in (2..LAST).rev() {
        half_bend = half_bend.mul_add(at, p[k] * S::splat((k * (k - 1) / 2) as f64));
    }
    let (value, slope) = leading_with_slope(p, at);
    let inverse = S::splat(1.0) / slope;
    let (newton, bend) = (value * inverse, half_bend * inverse);
    (at - (newton * newton).mul_add(bend, newton), inverse)
}
