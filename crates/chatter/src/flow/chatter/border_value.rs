//! Where complete chatter ends: the fixed point u* of eq. (5), from the multiplier lambda of nu there.

use crate::numerics::Real;

/// Newton's steps that exhaust the digits of any number type, from the starts below.
const STEPS: usize = 60;

/// lambda and 1 - lambda, each to rounding relative to itself: the positive root of lambda^2 (2 + lambda) =
/// r (1 + 2 lambda), which is the cubic for s* of MATH.md 2 under s* = (1 + 2 lambda) / 3.
pub(crate) fn multiplier<R: Real>(r: R) -> (R, R) {
    let number = R::splat;
    let (one, two, five) = (R::ONE, number(2.0), number(5.0));
    if r <= number(0.5) {
        // In lambda / sqrt(r), of order one however small r is. The cubic is convex there and positive at one, so that
        // Newton descends to the root until rounding errors stop it.
        let root = r.sqrt();
        let mut scaled = one;
        for _ in 0..STEPS {
            let value = scaled * scaled * (two + root * scaled) - (one + two * root * scaled);
            let slope = scaled * (number(4.0) + number(3.0) * root * scaled) - two * root;
            let next = scaled - value / slope;
            let descends = next < scaled;
            if !descends {
                break;
            }
            scaled = next;
        }
        let lambda = scaled * root;
        (lambda, one - lambda)
    } else {
        // In d = 1 - lambda: d (5 - 5 d + d^2) = (1 - r) (3 - 2 d). Concave and negative at zero: Newton ascends.
        let rest = one - r;
        let mut d = R::ZERO;
        for _ in 0..STEPS {
            let value = d * (five - five * d + d * d) - rest * (number(3.0) - two * d);
            let slope = five - number(10.0) * d + number(3.0) * d * d + two * rest;
            let next = d - value / slope;
            let ascends = next > d;
            if !ascends {
                break;
            }
            d = next;
        }
        (one - d, d)
    }
}

/// u* from lambda and 1 - lambda.
pub(crate) fn fixed_point<R: Real>((lambda, one_minus_lambda): (R, R)) -> R {
    one_minus_lambda * (R::splat(2.0) + lambda) / R::splat(6.0)
}

/// The border value u* of u = j w / nu^2.
pub(crate) fn border_value(restitution: f64) -> f64 {
    fixed_point(multiplier(restitution))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::DoubleDouble;

    #[test]
    fn border_value_is_the_fixed_point() {
        assert!((border_value(0.8) - 0.060_023_838_139_441_6).abs() < 1e-16);
        for r in [
            0.0,
            1e-300,
            1e-9,
            0.1,
            0.5,
            0.51,
            0.99,
            1.0 - 1e-9,
            1.0 - 2e-16,
        ] {
            let fine = fixed_point(multiplier(DoubleDouble::from(r))).to_f64();
            let off = (border_value(r) - fine).abs();
            assert!(off <= 4e-16 * fine, "{r}: {off:e}");
            if r < 1.0 - 1e-8 {
                let s = (1.0 - 8.0 * fine / 3.0).sqrt();
                // (5) without its pole, which the fixed point nears as r -> 0.
                let (up, down) = (3.0 * r * s * (1.0 - s), (1.0 - 3.0 * s) * (1.0 - 3.0 * s));
                assert!((up - fine * down).abs() < 1e-15, "{r}: {up} {down}");
            }
        }
    }
}
