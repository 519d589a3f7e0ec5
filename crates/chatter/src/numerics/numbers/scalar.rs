//! The number a tape computes with.
//!
//! Everything above this floor is written once against [`Scalar`] and runs on one trajectory (`f64`), on SIMD lanes of
//! many ([`Lanes`](super::super::Lanes)), or to thirty digits ([`DoubleDouble`]). Branches that depend on a value are written
//! as masks and selections there; code that must decide (the mode machine, root isolation) asks for [`Real`].
//!
//! Results are the same on every machine: arithmetic is IEEE 754, fused multiply-add happens only where `mul_add` is
//! called, elementary functions come from the portable `libm` crate.

use super::super::DoubleDouble;
use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// One truth value for each lane of a [`Scalar`].
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Whether every lane is true.
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// A number, or several side by side, that series arithmetic runs on.
pub trait Scalar:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Send
    + Sync
    + 'static
{
    /// Truth values, one a lane.
    type Mask: Mask;

    /// Unit roundoff: half the distance from one to the next number.
    const ROUNDOFF: f64;
    /// Orders of a Taylor expansion to choose from, ascending: short flights take a low one, long steps the highest.
    const ORDERS: [usize; 6];

    /// The double nearest to nothing lost: every lane is `value` exactly.
    fn splat(value: f64) -> Self;
    /// Every lane is `value`, rounded to this number's precision.
    fn from_double_double(value: DoubleDouble) -> Self;
    /// `self * factor + addend`, fused where the hardware number is an `f64`.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// `self + other` exactly, as rounded sum and remainder.
    #[inline(always)]
    fn two_sum(self, other: Self) -> (Self, Self) {
        let sum = self + other;
        let shadow = sum - self;
        (sum, (self - (sum - shadow)) + (other - shadow))
    }
    /// `self + a * b` where more of these follow: the sum is a number as others once it is [`summed`](Self::summed).
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        a.mul_add(b, self)
    }
    /// What has been summed by [`plus_product`](Self::plus_product).
    #[inline(always)]
    fn summed(self) -> Self {
        self
    }
    /// sum_i a_i b_{n-1-i} of two sequences of n: a coefficient of a product of series.
    ///
    /// The outermost products come last: one of them holds the coefficient that was computed just before, and the rest of
    /// the sum need not wait for it.
    #[inline(always)]
    fn convolve(a: &[Self], b: &[Self]) -> Self {
        let n = a.len();
        let (Some(&first), Some(&last)) = (a.first(), b.get(n.wrapping_sub(1))) else {
            return Self::splat(0.0);
        };
        if n == 1 {
            return first * last;
        }
        let mut even = Self::splat(0.0);
        let mut odd = Self::splat(0.0);
        let mut left = a[1..n - 1].chunks_exact(2);
        let mut right = b[1..n - 1].rchunks_exact(2);
        for (pair, mirrored) in left.by_ref().zip(right.by_ref()) {
            even = pair[0].mul_add(mirrored[1], even);
            odd = pair[1].mul_add(mirrored[0], odd);
        }
        if let ([middle], [mirrored]) = (left.remainder(), right.remainder()) {
            even = middle.mul_add(*mirrored, even);
        }
        let sum = a[n - 1].mul_add(b[0], even + odd);
        first.mul_add(last, sum)
    }
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Natural logarithm; NaN below zero, minus infinity at zero.
    fn ln(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);
    /// Tangent.
    fn tan(self) -> Self;
    /// Inverse sine, in [-pi/2, pi/2]; NaN outside [-1, 1].
    fn asin(self) -> Self;
    /// Inverse cosine, in [0, pi]; NaN outside [-1, 1].
    fn acos(self) -> Self;
    /// Inverse tangent, in (-pi/2, pi/2).
    fn atan(self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// `self` to the power `exponent`, for a positive base.
    fn powf(self, exponent: Self) -> Self;

    /// Lane by lane `self < other`; false where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Lane by lane `self <= other`; false where either is NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Lane by lane: neither NaN nor infinite.
    fn is_finite(self) -> Self::Mask;
    /// Lane by lane: an integer.
    fn is_whole(self) -> Self::Mask;
    /// Lane by lane `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The smaller of two; `other` where `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }
    /// The larger of two; `other` where `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    /// A crude base-two logarithm of a positive number, off by at most 0.09: enough to choose an order or a step, and
    /// free of any call. Zero gives about -1023.
    fn coarse_log2(self) -> Self;
    /// Inverse of [`coarse_log2`](Self::coarse_log2); arguments below -1000 give a number that is as good as zero.
    fn coarse_exp2(self) -> Self;
    /// The nearest number of 24 binary digits, so that products with other short ones are exact.
    fn short(self) -> Self;
}

/// A [`Scalar`] with a single lane: values can be compared and decided upon.
pub trait Real: Scalar<Mask = bool> + PartialOrd + PartialEq + Display {
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// Exact, or rounded to about 106 bits.
    fn to_double_double(self) -> DoubleDouble;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
}

/// Twelve bits of a mantissa are dropped so that the rest, an integer below 2^51, turns into a double by gluing it below
/// the leading bit of 2^52: the processor's integer conversions, missing in AVX2, are never needed.
pub(super) const TWO_52: f64 = 4_503_599_627_370_496.0;
pub(super) const TWO_52_BITS: u64 = 0x4330_0000_0000_0000;
pub(super) const TWO_40: f64 = 1_099_511_627_776.0;
pub(super) const BIAS: f64 = 1023.0;

/// A whole number, not negative and below 2^32, as an index: the processor's conversions come with questions whether it is one.
#[inline(always)]
pub(crate) fn index_of(whole: f64) -> usize {
    ((whole + TWO_52).to_bits() & u64::from(u32::MAX)) as usize
}

#[inline(always)]
pub(super) fn coarse_log2(value: f64) -> f64 {
    let glued = f64::from_bits((value.to_bits() >> 12) | TWO_52_BITS);
    (glued - TWO_52) * (1.0 / TWO_40) - BIAS
}

#[inline(always)]
pub(super) fn coarse_exp2(value: f64) -> f64 {
    let clamped = if value > -1000.0 { value } else { -1000.0 };
    let clamped = if clamped < 1000.0 { clamped } else { 1000.0 };
    f64::from_bits(((clamped + BIAS).mul_add(TWO_40, TWO_52)).to_bits() << 12)
}

/// Binary digits of a [`short`](Scalar::short) number.
const SHORT_DIGITS: u32 = 24;

/// The bit above those that it lacks.
pub(super) const DROPPED: u64 = 1 << (f64::MANTISSA_DIGITS - SHORT_DIGITS);

#[inline(always)]
pub(super) fn short(value: f64) -> f64 {
    f64::from_bits(value.to_bits().wrapping_add(DROPPED / 2) & !(DROPPED - 1))
}

impl Scalar for f64 {
    type Mask = bool;
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    const ORDERS: [usize; 6] = [8, 10, 13, 16, 20, 26];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn from_double_double(value: DoubleDouble) -> Self {
        value.high()
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        f64::mul_add(self, factor, addend)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn exp(self) -> Self {
        libm::exp(self)
    }
    fn ln(self) -> Self {
        libm::log(self)
    }
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    fn tan(self) -> Self {
        libm::tan(self)
    }
    fn asin(self) -> Self {
        libm::asin(self)
    }
    fn acos(self) -> Self {
        libm::acos(self)
    }
    fn atan(self) -> Self {
        libm::atan(self)
    }
    fn sinh(self) -> Self {
        libm::sinh(self)
    }
    fn cosh(self) -> Self {
        libm::cosh(self)
    }
    fn tanh(self) -> Self {
        libm::tanh(self)
    }
    fn powf(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }
    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    #[inline(always)]
    fn is_whole(self) -> bool {
        libm::rint(self) == self
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn coarse_log2(self) -> Self {
        coarse_log2(self)
    }
    #[inline(always)]
    fn coarse_exp2(self) -> Self {
        coarse_exp2(self)
    }
    #[inline(always)]
    fn short(self) -> Self {
        short(self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    fn to_double_double(self) -> DoubleDouble {
        DoubleDouble::from(self)
    }
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
}
