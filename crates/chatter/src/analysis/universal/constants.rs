//! Constants of the chatter map: its fixed point, the multipliers there, and the exponent of Upsilon.

use super::error::UniversalError;
use crate::flow::{fixed_point, multiplier};
use crate::numerics::{DoubleDouble, Real, Scalar, with_rounding};
use serde::{Deserialize, Serialize};

with_rounding! {
    /// What the restitution alone determines in closed form (MATH.md 2, (M6)).
    ///
    /// Every value, and the complements `1 - lambda` and `1 - eta` too, is accurate to rounding relative to itself for all
    /// restitutions in (0, 1), however near to either end.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Constants<R> {
        /// Coefficient of restitution r.
        pub restitution: R,
        /// The fixed point u* of g in (0, 1/3): the border between complete and incomplete chatter.
        pub chatter_fixed_point: R,
        /// s* = sqrt(1 - 8 u* / 3).
        pub flight_root: R,
        /// lambda = h(u*): the factor of nu from one impact to the next along the border orbit.
        pub lambda: R,
        /// eta = 1 / g'(u*): the factor of u - u* from one impact to the one before it.
        pub eta: R,
        /// 1 - lambda, without cancellation.
        pub one_minus_lambda: R,
        /// 1 - eta, without cancellation.
        pub one_minus_eta: R,
        /// ln lambda.
        pub ln_lambda: R,
        /// ln eta.
        pub ln_eta: R,
        /// ln lambda^2 / ln eta: Upsilon(x) is of the order of x to this power.
        pub exponent: R,
    }
}

/// ln(1 + x), to rounding relative to itself.
pub(super) fn ln_1p(x: DoubleDouble) -> DoubleDouble {
    const SERIES_BELOW: f64 = 0.6;
    if x.abs() > DoubleDouble::from(SERIES_BELOW) {
        return (DoubleDouble::ONE + x).ln();
    }
    // ln(1 + x) = 2 artanh(x / (2 + x)).
    let ratio = x / (DoubleDouble::from(2.0) + x);
    let square = ratio * ratio;
    let mut power = ratio;
    let mut sum = ratio;
    let mut odd = 1.0;
    while power.abs().to_f64() > sum.abs().to_f64() * DoubleDouble::ROUNDOFF {
        power *= square;
        odd += 2.0;
        sum += power / DoubleDouble::from(odd);
    }
    sum + sum
}

impl Constants<DoubleDouble> {
    fn in_double_double(r: DoubleDouble) -> Self {
        let number = DoubleDouble::from;
        let one = DoubleDouble::ONE;
        let (lambda, one_minus_lambda) = multiplier(r);
        // (M6): eta = lambda q^2 with q = (1 + 2 lambda) / (2 + lambda) = 1 - (1 - lambda) / (2 + lambda).
        let shortfall = one_minus_lambda / (number(2.0) + lambda);
        let quotient = (one + number(2.0) * lambda) / (number(2.0) + lambda);
        let ln_lambda = if lambda.to_f64() < 0.5 {
            lambda.ln()
        } else {
            ln_1p(-one_minus_lambda)
        };
        let ln_eta = ln_lambda + number(2.0) * ln_1p(-shortfall);
        Self {
            restitution: r,
            chatter_fixed_point: fixed_point((lambda, one_minus_lambda)),
            flight_root: (one + number(2.0) * lambda) / number(3.0),
            lambda,
            eta: lambda * quotient * quotient,
            one_minus_lambda,
            one_minus_eta: one_minus_lambda + lambda * shortfall * (number(2.0) - shortfall),
            ln_lambda,
            ln_eta,
            exponent: number(2.0) * ln_lambda / ln_eta,
        }
    }
}

impl<R: Real> Constants<R> {
    /// The constants for a restitution in the open interval (0, 1).
    ///
    /// # Errors
    /// [`UniversalError::Restitution`] where it is outside, or NaN.
    pub fn new(restitution: R) -> Result<Self, UniversalError> {
        if !(restitution > R::ZERO && restitution < R::ONE) {
            return Err(UniversalError::Restitution {
                value: restitution.to_f64(),
            });
        }
        let exact = Constants::in_double_double(restitution.to_double_double());
        let round = R::from_double_double;
        Ok(Self {
            restitution,
            chatter_fixed_point: round(exact.chatter_fixed_point),
            flight_root: round(exact.flight_root),
            lambda: round(exact.lambda),
            eta: round(exact.eta),
            one_minus_lambda: round(exact.one_minus_lambda),
            one_minus_eta: round(exact.one_minus_eta),
            ln_lambda: round(exact.ln_lambda),
            ln_eta: round(exact.ln_eta),
            exponent: round(exact.exponent),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type D = DoubleDouble;

    fn off(a: D, b: &str) -> f64 {
        let b: D = b.parse().unwrap();
        ((a - b) / b).abs().to_f64()
    }

    #[test]
    fn known_values() {
        let c = Constants::new("0.8".parse::<D>().unwrap()).unwrap();
        assert!(
            off(
                c.chatter_fixed_point,
                "0.06002383813944160740865841254061424"
            ) < 1e-31
        );
        assert!(off(c.lambda, "0.87472068841759646937591686025499148") < 1e-31);
        assert!(off(c.eta, "0.80014190845508931666522477227928679") < 1e-31);
        let c = Constants::new(0.8).unwrap();
        assert!((c.lambda - 0.874_720_688_417_596_5).abs() < 2e-16);
    }

    fn satisfies_its_equations(r: D) {
        let number = D::from;
        let (one, c) = (D::ONE, Constants::new(r).unwrap());
        let same = |a: D, b: D| {
            let off = ((a - b) / b).abs().to_f64();
            assert!(off < 1e-30, "{r:e}: {off:e}", r = r.to_f64());
        };
        // The cubic for s*, in the form whose terms are positive: (s + 1)(3 s - 1)^2 = 8 r s.
        let s = c.flight_root;
        let twice_lambda = c.lambda + c.lambda;
        same((s + one) * twice_lambda * twice_lambda, number(8.0) * r * s);
        same(c.lambda + c.one_minus_lambda, one);
        same(c.eta + c.one_minus_eta, one);
        same(c.chatter_fixed_point, number(0.375) * (one - s * s));
        assert!(c.lambda * c.lambda < c.eta && c.eta < c.lambda && c.lambda < one);
    }

    #[test]
    fn equations_hold_over_the_interval() {
        for r in [1e-12, 1e-6, 0.01, 0.3, 0.5, 0.8, 0.95] {
            satisfies_its_equations(D::from(r));
        }
    }

    /// 1 / eta = g'(u*), against a difference of g itself.
    #[test]
    fn eta_is_the_multiplier_of_g() {
        use super::super::ChatterMap;
        for r in [0.01, 0.3, 0.8, 0.99] {
            let c = Constants::new(D::from(r)).unwrap();
            let map = ChatterMap::new(&c);
            let step = c.chatter_fixed_point
                * (D::ONE / D::from(3.0) - c.chatter_fixed_point)
                * D::from(1e-9);
            let u = c.chatter_fixed_point;
            let slope = (map.g(u + step) - map.g(u - step)) / (step + step);
            assert!((slope * c.eta - D::ONE).abs().to_f64() < 1e-13, "{r}");
            assert!(((map.g(u) - u) / u).abs().to_f64() < 1e-27);
            assert!((map.h(u) / c.lambda - D::ONE).abs().to_f64() < 1e-28);
        }
    }

    /// Towards the ends: lambda -> sqrt(r / 2), 1 - lambda -> (3/5)(1 - r), 1 - eta -> 1 - r, u* -> (3/10)(1 - r),
    /// exponent 2 -> 6/5; the next term of each is of relative order sqrt(r), or 1 - r.
    #[test]
    fn limits_at_both_ends() {
        for r in [1e-300, 1e-100, 1e-12] {
            let c = Constants::new(r).unwrap();
            let small = libm::sqrt(r / 2.0);
            assert!((c.lambda / small - 1.0).abs() < 2.0 * small + 1e-15);
            assert!((c.eta / (small / 4.0) - 1.0).abs() < 5.0 * small + 1e-15);
            // ln eta = ln lambda - ln 4 makes the exponent approach 2 slowly.
            let expected = 2.0 / (1.0 - libm::log(4.0) / libm::log(small));
            assert!((c.exponent - expected).abs() < small + 1e-15);
        }
        for rest in [1e-15_f64, 1e-12, 1e-8] {
            let r = 1.0 - rest;
            let rest = 1.0 - r;
            let c = Constants::new(r).unwrap();
            assert!((c.one_minus_lambda / rest - 0.6).abs() < rest + 1e-15);
            assert!((c.one_minus_eta / rest - 1.0).abs() < 2.0 * rest + 1e-15);
            assert!((c.chatter_fixed_point / rest - 0.3).abs() < rest + 1e-15);
            assert!((c.exponent - 1.2).abs() < rest + 1e-15);
        }
    }

    proptest! {
        #[test]
        fn doubles_are_rounded_double_doubles(exponent in -300.0_f64..0.0, near_one in prop::bool::ANY) {
            let small = libm::exp10(exponent);
            let r = if near_one { 1.0 - small.clamp(2e-16, 0.5) } else { small.min(0.999) };
            let (double, fine) = (Constants::new(r).unwrap(), Constants::new(D::from(r)).unwrap());
            for (a, b) in [
                (double.lambda, fine.lambda),
                (double.one_minus_lambda, fine.one_minus_lambda),
                (double.eta, fine.eta),
                (double.one_minus_eta, fine.one_minus_eta),
                (double.exponent, fine.exponent),
            ] {
                prop_assert_eq!(a, b.high());
                prop_assert!(a > 0.0);
            }
            // lambda^2 (2 + lambda) = r (1 + 2 lambda), down to where double-doubles lose their low part.
            if r < 1e-250 {
                return Ok(());
            }
            let l = fine.lambda;
            let left = l * (l / fine.restitution) * (D::from(2.0) + l);
            prop_assert!((left / (D::ONE + l + l) - D::ONE).abs().to_f64() < 1e-30);
        }
    }
}
