//! A number with the size of the terms that it is the sum of: what tells a small value from a rounding error.
//!
//! Every operation carries the first-order bound of running error analysis along: an input counts with its own size, a sum
//! with those of its terms, a function with its slope times that of its argument. A value is told from zero where it
//! exceeds some roundoffs of its terms, whatever units it is measured in.

use super::double_double::DoubleDouble;
use super::scalar::{Real, Scalar};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A value and the size of its terms; with `SERIES` one that expansions in time may be computed with, and else values at a point alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithTerms<R, const SERIES: bool = false> {
    /// The number.
    pub value: R,
    /// How large the terms are that it is the sum of, in its own units.
    pub terms: f64,
}

/// A value is told from zero if it exceeds so many roundoffs of its terms: sums and products leave a few, and the inputs
/// had some already.
const TOLD_ROUNDOFFS: f64 = 32.0;

impl<R: Real> WithTerms<R> {
    /// A number that is one term itself.
    pub fn exact(value: R) -> Self {
        Self {
            value,
            terms: value.to_f64().abs(),
        }
    }

    /// Numbers that are one term each.
    pub fn all(values: &[R]) -> Vec<Self> {
        values.iter().copied().map(Self::exact).collect()
    }

    /// Numbers that are one term each, and rounding remainders whose terms are counted there, for series.
    pub(crate) fn for_series(
        values: &[R],
        remainders: &[R],
    ) -> (Vec<WithTerms<R, true>>, Vec<WithTerms<R, true>>) {
        let value = |&value: &R| WithTerms::single(value);
        let remainder = |&value: &R| WithTerms { value, terms: 0.0 };
        let remainders = remainders.iter().map(remainder).collect();
        (values.iter().map(value).collect(), remainders)
    }

    /// Without what makes it one of a series.
    pub(crate) fn of_series(value: WithTerms<R, true>) -> Self {
        let WithTerms { value, terms } = value;
        Self { value, terms }
    }

    /// Rounding remainders of numbers: terms of theirs are counted there.
    pub fn remainders(values: &[R]) -> Vec<Self> {
        let remainder = |&value: &R| Self { value, terms: 0.0 };
        values.iter().map(remainder).collect()
    }
}

impl<R: Real, const SERIES: bool> WithTerms<R, SERIES> {
    /// The same of either kind.
    fn single(value: R) -> Self {
        Self {
            value,
            terms: value.to_f64().abs(),
        }
    }

    /// Below this size the value cannot be told from zero.
    pub fn level(self) -> R {
        R::splat(TOLD_ROUNDOFFS * R::ROUNDOFF * self.terms)
    }

    fn sloped(self, value: R, slope: f64) -> Self {
        let inherited = if self.terms == 0.0 {
            0.0
        } else {
            slope.abs() * self.terms
        };
        Self {
            value,
            terms: inherited + value.to_f64().abs(),
        }
    }

    /// A power of the number, of this value and slope, whose slope is infinite at zero: how far it may be off as long as the number
    /// cannot be told from zero is the power of that.
    fn steep(self, value: R, slope: f64, exponent: f64) -> Self {
        let level = self.level().to_f64();
        let secant = libm::pow(level, exponent) / level;
        let is_within = self.value.to_f64().abs() <= level && secant.is_finite();
        let slope = if is_within && (slope.is_nan() || slope.abs() > secant) {
            secant
        } else {
            slope
        };
        self.sloped(value, slope)
    }

    fn size(self) -> f64 {
        self.value.to_f64().abs()
    }
}

impl<R: Real, const SERIES: bool> Add for WithTerms<R, SERIES> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            terms: self.terms + other.terms,
        }
    }
}

impl<R: Real, const SERIES: bool> Sub for WithTerms<R, SERIES> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<R: Real, const SERIES: bool> Mul for WithTerms<R, SERIES> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            terms: self.size().mul_add(other.terms, other.size() * self.terms),
        }
    }
}

impl<R: Real, const SERIES: bool> Div for WithTerms<R, SERIES> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let share = other.terms / other.size();
        Self {
            value,
            terms: (self.terms / other.size()) + value.to_f64().abs() * share,
        }
    }
}

impl<R: Real, const SERIES: bool> Neg for WithTerms<R, SERIES> {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            terms: self.terms,
        }
    }
}

impl<R: Real, const SERIES: bool> AddAssign for WithTerms<R, SERIES> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real, const SERIES: bool> SubAssign for WithTerms<R, SERIES> {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<R: Real, const SERIES: bool> MulAssign for WithTerms<R, SERIES> {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<R: Real, const SERIES: bool> Scalar for WithTerms<R, SERIES> {
    type Mask = bool;
    const ROUNDOFF: f64 = R::ROUNDOFF;
    /// Values at a point are all that it is for, unless it says that it is for series.
    const ORDERS: [usize; 6] = if SERIES { R::ORDERS } else { [0; 6] };

    fn splat(value: f64) -> Self {
        Self::single(R::splat(value))
    }
    fn from_double_double(value: DoubleDouble) -> Self {
        Self::single(R::from_double_double(value))
    }
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self {
            value: self.value.mul_add(factor.value, addend.value),
            terms: (self * factor).terms + addend.terms,
        }
    }
    /// The terms of the remainder are in the sum already.
    fn two_sum(self, other: Self) -> (Self, Self) {
        let (value, rest) = self.value.two_sum(other.value);
        let terms = self.terms + other.terms;
        let rest = Self {
            value: rest,
            terms: 0.0,
        };
        (Self { value, terms }, rest)
    }
    fn abs(self) -> Self {
        Self {
            value: self.value.abs(),
            terms: self.terms,
        }
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.steep(root, 0.5 / root.to_f64(), 0.5)
    }
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.sloped(value, value.to_f64())
    }
    fn ln(self) -> Self {
        self.sloped(self.value.ln(), 1.0 / self.value.to_f64())
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sin_cos();
        (
            self.sloped(sine, cosine.to_f64()),
            self.sloped(cosine, sine.to_f64()),
        )
    }
    fn tan(self) -> Self {
        let value = self.value.tan();
        self.sloped(value, value.to_f64().mul_add(value.to_f64(), 1.0))
    }
    fn asin(self) -> Self {
        self.sloped(self.value.asin(), 1.0 / co_sine(self.value))
    }
    fn acos(self) -> Self {
        self.sloped(self.value.acos(), 1.0 / co_sine(self.value))
    }
    fn atan(self) -> Self {
        let x = self.value.to_f64();
        self.sloped(self.value.atan(), 1.0 / x.mul_add(x, 1.0))
    }
    fn sinh(self) -> Self {
        self.sloped(self.value.sinh(), self.value.cosh().to_f64())
    }
    fn cosh(self) -> Self {
        self.sloped(self.value.cosh(), self.value.sinh().to_f64())
    }
    fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.sloped(value, (1.0 - value.to_f64()) * (1.0 + value.to_f64()))
    }
    fn powf(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let by_base = value.to_f64() * exponent.value.to_f64() / self.value.to_f64();
        // A negative base has powers with whole exponents.
        let by_exponent = value.to_f64() * libm::log(self.value.to_f64().abs());
        let along = self.steep(value, by_base, exponent.value.to_f64());
        let across = if value == R::ZERO {
            0.0
        } else {
            exponent.sloped(R::ZERO, by_exponent).terms
        };
        Self {
            value,
            terms: along.terms + across,
        }
    }
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    fn at_most(self, other: Self) -> bool {
        self.value <= other.value
    }
    fn is_whole(self) -> bool {
        self.value.is_whole()
    }
    fn is_finite(self) -> bool {
        self.value.is_finite()
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    fn coarse_log2(self) -> Self {
        Self::single(self.value.coarse_log2())
    }
    fn coarse_exp2(self) -> Self {
        Self::single(self.value.coarse_exp2())
    }
    fn short(self) -> Self {
        Self::single(self.value.short())
    }
}

/// sqrt(1 - x^2).
fn co_sine<R: Real>(x: R) -> f64 {
    let x = x.to_f64();
    ((1.0 - x) * (1.0 + x)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(value: f64) -> WithTerms<f64> {
        WithTerms::exact(value)
    }

    #[test]
    fn a_difference_is_told_from_zero_by_its_terms() {
        let (a, b) = (at(0.1) + at(0.2), at(0.3));
        assert!((a - b).value != 0.0 && (a - b).value.abs() < (a - b).level());
        let far = (at(1e9) + at(1e-3)) - at(1e9);
        assert!(far.value > far.level());
        let lost = (at(1e9) + at(1e-7)) - at(1e9);
        assert!(lost.value.abs() < lost.level());
        assert_eq!(at(1e-300).level(), 32.0 * f64::ROUNDOFF * 1e-300);
        assert!(at(0.0).value.abs() <= at(0.0).level());
    }

    #[test]
    fn functions_hand_on_what_their_argument_has() {
        let small = (at(1.0) + at(1e-12)) - at(1.0);
        for (image, slope) in [
            (small.sin_cos().0, 1.0),
            (small.tan(), 1.0),
            (small.atan(), 1.0),
            (small.asin(), 1.0),
            (small.sinh(), 1.0),
            (small.tanh(), 1.0),
            (small * at(3.0), 3.0),
            (small / at(4.0), 0.25),
            (small.exp() - at(1.0), 1.0),
        ] {
            let told = image.terms / (2.0 * slope);
            assert!((0.99..2.6).contains(&told), "{image:?} {slope}");
        }
        let root = (at(4.0) - at(3.0)).sqrt();
        assert!((root.terms - 4.5).abs() < 1e-12, "{root:?}");
    }

    #[test]
    fn a_root_of_what_is_zero_is_off_by_the_root_of_rounding() {
        let nothing = at(1.1) - at(1.1);
        for (root, exponent) in [
            (nothing.sqrt(), 0.5),
            (nothing.powf(at(0.25)), 0.25),
            (nothing.powf(at(1.5)), 1.5),
        ] {
            let level = nothing.level().powf(exponent);
            assert!((root.level() / level - 1.0).abs() < 1e-12, "{root:?}");
            let force = at(-1.0) + root;
            assert!(force.value < -force.level(), "{force:?}");
        }
    }
}
