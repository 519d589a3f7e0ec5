//! The first root of a polynomial in an interval, isolated with certainty.
//!
//! Descartes' rule on Bernstein coefficients says how many roots an interval can hold: none without a change of sign,
//! exactly one with one. Anything else is halved and asked again, from the left, until the answer is certain or the
//! polynomial cannot be told from zero: a touching root. Nothing is missed or invented above the stated noise.

use super::Real;
use super::numbers::dispatch::{Kernel, dispatch_narrow};
use super::polynomial::{bernstein, horner, horner_with_slope, split};

/// Which sign changes count as roots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// From positive to negative.
    Falling,
    /// Both.
    Either,
}

/// How a polynomial meets zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RootKind {
    /// It changes sign.
    Crossing,
    /// It comes within the noise of zero and may or may not cross: a graze.
    Touching,
}

/// A located root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root<R> {
    /// Where, in (0, width].
    pub at: R,
    /// How.
    pub kind: RootKind,
}

/// An interval is not halved more often than this: a double root is as wide as the square root of the roundoff.
const fn most_halvings<R: Real>() -> u32 {
    // Half the binary places, from the exponent's bits: a logarithm would be computed anew for every root.
    const BIAS: u64 = 1023;
    const FRACTION_BITS: u32 = 52;
    ((BIAS - (R::ROUNDOFF.to_bits() >> FRACTION_BITS)) / 2) as u32
}

/// Newton's steps from within such an interval to the digits of any number.
const POLISHING_STEPS: usize = 3;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sign {
    Negative,
    Unclear,
    Positive,
}

#[inline(always)]
fn sign<R: Real>(value: R, noise: R) -> Sign {
    if value > noise {
        Sign::Positive
    } else if value < -noise {
        Sign::Negative
    } else {
        Sign::Unclear
    }
}

/// What the signs of the Bernstein coefficients say of one interval.
enum Verdict {
    None,
    One,
    Unclear,
}

#[inline(always)]
fn verdict<R: Real>(values: &[R], noise: R) -> Verdict {
    let mut changes = 0;
    let mut unclear_run = 0;
    let mut last = sign(values[0], noise);
    let clear_ends =
        last != Sign::Unclear && sign(values[values.len() - 1], noise) != Sign::Unclear;
    if !clear_ends {
        return Verdict::Unclear;
    }
    for &value in &values[1..] {
        match sign(value, noise) {
            Sign::Unclear => unclear_run += 1,
            clear => {
                // One unclear value between opposite signs leaves exactly one change whatever its sign; between equal
                // signs, or in a run, it does not.
                let harmless = unclear_run == 0 || (unclear_run == 1 && clear != last);
                if !harmless {
                    return Verdict::Unclear;
                }
                changes += u32::from(clear != last);
                last = clear;
                unclear_run = 0;
            }
        }
    }
    match changes {
        0 => Verdict::None,
        1 => Verdict::One,
        _ => Verdict::Unclear,
    }
}

/// The root in a bracket with opposite signs at its ends: Newton's method, kept inside by bisection.
#[inline(always)]
pub fn bracketed_root<R: Real>(coefficients: &[R], mut low: R, mut high: R) -> R {
    let half = R::splat(0.5);
    let rising = horner(coefficients, low) < R::ZERO;
    let mut at = (low + high) * half;
    let mut last_step = high - low;
    for _ in 0..200 {
        let (value, slope) = horner_with_slope(coefficients, at);
        if value == R::ZERO {
            return at;
        }
        if (value < R::ZERO) == rising {
            low = at;
        } else {
            high = at;
        }
        let newton = at - value / slope;
        let inside = newton > low && newton < high;
        let next = if inside && (newton - at).abs() < last_step * half {
            newton
        } else {
            (low + high) * half
        };
        last_step = (next - at).abs();
        if next == at || last_step <= R::splat(2.0 * R::ROUNDOFF) * at.abs() {
            return next;
        }
        at = next;
    }
    at
}

/// The first root of p in (0, width] that crosses as asked, or touches.
///
/// Values within `noise` of zero cannot be told from zero. A p that starts below zero has to rise first where only
/// falling roots count.
pub fn first_root<R: Real>(
    coefficients: &[R],
    width: R,
    crossing: Crossing,
    noise: R,
) -> Option<Root<R>> {
    dispatch_narrow(FirstRoot {
        coefficients,
        width,
        crossing,
        noise,
    })
}

struct FirstRoot<'a, R> {
    coefficients: &'a [R],
    width: R,
    crossing: Crossing,
    noise: R,
}

impl<R: Real> Kernel for FirstRoot<'_, R> {
    type Output = Option<Root<R>>;
    #[inline(always)]
    fn run(self) -> Option<Root<R>> {
        isolate(self.coefficients, self.width, self.crossing, self.noise)
    }
}

#[inline(always)]
fn isolate<R: Real>(coefficients: &[R], width: R, crossing: Crossing, noise: R) -> Option<Root<R>> {
    let mut values = vec![R::ZERO; coefficients.len()];
    bernstein(coefficients, width, &mut values);
    let most_halvings = most_halvings::<R>();
    let mut stack = vec![(R::ZERO, width, 0_u32, values)];
    while let Some((low, high, depth, mut values)) = stack.pop() {
        match verdict(&values, noise) {
            Verdict::None => {}
            Verdict::One => {
                if crossing == Crossing::Either || values[0] > R::ZERO {
                    return Some(Root {
                        at: bracketed_root(coefficients, low, high),
                        kind: RootKind::Crossing,
                    });
                }
            }
            Verdict::Unclear if is_passed(&values, crossing, noise) => {}
            Verdict::Unclear if depth < most_halvings => {
                let middle = (low + high) * R::splat(0.5);
                let right = split(&mut values);
                stack.push((middle, high, depth + 1, right));
                stack.push((low, middle, depth + 1, values));
            }
            Verdict::Unclear => {
                if let Some(root) = indistinct(coefficients, low, high, width, crossing, noise) {
                    return Some(root);
                }
            }
        }
    }
    None
}

/// Whether p lies within the noise of zero on the whole of an interval, and rises or falls there without a zero that counts: to halve
/// that until each part is tiny would take for ever where it is wide.
#[inline(always)]
fn is_passed<R: Real>(values: &[R], crossing: Crossing, noise: R) -> bool {
    let (mut rises, mut falls) = (false, false);
    for pair in values.windows(2) {
        rises |= pair[1] > pair[0];
        falls |= pair[1] < pair[0];
    }
    let last = values[values.len() - 1];
    let crosses = (values[0] > R::ZERO) != (last > R::ZERO);
    let counts = crosses && (falls || crossing == Crossing::Either);
    rises != falls && !counts && values.iter().all(|value| value.abs() <= noise)
}

/// Decides a tiny interval in which p is within the noise of zero.
#[inline(always)]
fn indistinct<R: Real>(
    coefficients: &[R],
    low: R,
    high: R,
    width: R,
    crossing: Crossing,
    noise: R,
) -> Option<Root<R>> {
    let at = (low + high) * R::splat(0.5);
    let (value, slope) = horner_with_slope(coefficients, at);
    let size = high - low;
    if let Some(turn) = nearby_turn(coefficients, at, width)
        && horner(coefficients, turn).abs() <= noise
    {
        return Some(Root {
            at: turn,
            kind: RootKind::Touching,
        });
    }
    // No turning point in the noise: an ordinary crossing close to a joint of intervals. A neighbour that holds the
    // root reports it; the half-open interval excludes its left end.
    let mut root = at - value / slope;
    for _ in 0..POLISHING_STEPS {
        let (value, slope) = horner_with_slope(coefficients, root);
        let step = value / slope;
        if step.abs() < size {
            root -= step;
        }
    }
    let counts = crossing == Crossing::Either || slope < R::ZERO;
    let here = root > R::ZERO && root > low - size && root <= high + size && root <= width;
    (counts && here).then_some(Root {
        at: root,
        kind: RootKind::Crossing,
    })
}

/// Where p' vanishes within (0, width], if that is close to `at`: a double root and its noise are no wider than the
/// square root of the roundoff, give or take a curvature.
#[inline(always)]
fn nearby_turn<R: Real>(coefficients: &[R], at: R, width: R) -> Option<R> {
    const NEAR: f64 = 1e-5;
    let derivative: Vec<R> = coefficients
        .iter()
        .enumerate()
        .skip(1)
        .map(|(k, &c)| c * R::splat(k as f64))
        .collect();
    let mut turn = at;
    for _ in 0..8 {
        let (slope, bend) = horner_with_slope(&derivative, turn);
        if bend == R::ZERO {
            break;
        }
        turn -= slope / bend;
    }
    let near = (turn - at).abs() < R::splat(NEAR) * width;
    (near && turn > R::ZERO && turn <= width).then_some(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::polynomial::magnitude;
    use crate::numerics::{DoubleDouble, Scalar};
    use proptest::prelude::*;

    fn from_roots(roots: &[f64]) -> Vec<f64> {
        let mut exact = vec![DoubleDouble::from(1.0)];
        for &root in roots {
            exact.push(DoubleDouble::from(0.0));
            for k in (0..exact.len()).rev() {
                let below = if k > 0 {
                    exact[k - 1]
                } else {
                    DoubleDouble::from(0.0)
                };
                exact[k] = below - exact[k] * DoubleDouble::from(root);
            }
        }
        let sign = if exact[0].high() < 0.0 { -1.0 } else { 1.0 };
        exact.iter().map(|c| c.high() * sign).collect()
    }

    fn first(roots: &[f64], width: f64) -> Option<Root<f64>> {
        let p = from_roots(roots);
        let noise = 32.0 * f64::ROUNDOFF * magnitude(&p, width);
        first_root(&p, width, Crossing::Falling, noise)
    }

    #[test]
    fn exact_cases() {
        let root = first(&[0.25, 0.75], 1.0).unwrap();
        assert_eq!(root.kind, RootKind::Crossing);
        assert!((root.at - 0.25).abs() < 1e-15);
        assert_eq!(first(&[1.5, 2.0], 1.0), None);
        assert_eq!(first(&[-0.5, -0.1], 1.0), None);
    }

    #[test]
    fn double_root_is_touching() {
        let root = first(&[0.3, 0.3, 2.0], 1.0).unwrap();
        assert_eq!(root.kind, RootKind::Touching);
        assert!((root.at - 0.3).abs() < 1e-7, "{root:?}");
    }

    /// Where rounding is told by what a polynomial comes to, most of the way there may be within it.
    #[test]
    fn a_long_rise_within_the_noise_is_no_root() {
        for order in [9, 20, 26] {
            let mut p = vec![0.0; order + 1];
            (p[0], p[1], p[order]) = (1e-22, 1e-20, 1.0);
            assert_eq!(first_root(&p, 1.0, Crossing::Falling, 1e-14), None);
            assert_eq!(first_root(&p, 1.0, Crossing::Either, 1e-14), None);
            // A double-double's intervals are halved twice as often.
            let wide: Vec<DoubleDouble> = p.iter().map(|&c| DoubleDouble::from(c)).collect();
            let (width, noise) = (DoubleDouble::from(1.0), DoubleDouble::from(1e-14));
            assert_eq!(first_root(&wide, width, Crossing::Falling, noise), None);
        }
    }

    #[test]
    fn near_graze_on_either_side() {
        // (s - 0.4)^2 + d: no root for d > 0, two for d < 0.
        let shifted = |d: f64| vec![0.16 + d, -0.8, 1.0];
        for d in [1e-4, 1e-8, 1e-12] {
            let noise = 1e-15;
            assert_eq!(
                first_root(&shifted(d), 1.0, Crossing::Falling, noise),
                None,
                "{d}"
            );
            let root = first_root(&shifted(-d), 1.0, Crossing::Falling, noise).unwrap();
            assert_eq!(root.kind, RootKind::Crossing, "{d}");
            assert!((root.at - (0.4 - d.sqrt())).abs() < 1e-9, "{d} {root:?}");
        }
    }

    #[test]
    fn falling_only_skips_a_rise() {
        let p = [-0.2 * 0.6, 0.8, -1.0]; // rises at 0.2, falls at 0.6
        let falling = first_root(&p, 1.0, Crossing::Falling, 1e-16).unwrap();
        let either = first_root(&p, 1.0, Crossing::Either, 1e-16).unwrap();
        assert!((falling.at - 0.6).abs() < 1e-15);
        assert!((either.at - 0.2).abs() < 1e-15);
        assert_eq!(first_root(&p, 0.5, Crossing::Falling, 1e-16), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        #[test]
        fn finds_the_first_of_separated_roots(
            mut roots in proptest::collection::vec(0.02_f64..2.0, 1..7),
            width in 0.2_f64..1.5,
        ) {
            roots.sort_by(f64::total_cmp);
            prop_assume!(roots.windows(2).all(|pair| pair[1] - pair[0] > 0.02));
            prop_assume!(roots.iter().all(|root| (root - width).abs() > 1e-6));
            let found = first(&roots, width);
            if roots[0] < width {
                let found = found.expect("a root inside");
                prop_assert_eq!(found.kind, RootKind::Crossing);
                prop_assert!((found.at - roots[0]).abs() < 1e-9, "{} {}", found.at, roots[0]);
            } else {
                prop_assert_eq!(found, None);
            }
        }
    }
}
