//! Several doubles side by side, one trajectory each.
//!
//! Plain arrays: inside a function compiled for AVX2 or AVX-512 the loops below become vector instructions. Every
//! operation is the scalar one lane by lane, so a lane holds exactly the bits a scalar run would.

use super::DoubleDouble;
use super::scalar::{Mask, Scalar, coarse_exp2, coarse_log2};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// An array by index. Unlike `core::array::from_fn` it is always inlined, and so compiled for the features of the kernel
/// that it stands in.
#[inline(always)]
fn lanes<T: Copy, const L: usize>(first: T, function: impl Fn(usize) -> T) -> [T; L] {
    let mut all = [first; L];
    for (i, lane) in all.iter_mut().enumerate() {
        *lane = function(i);
    }
    all
}

/// `L` doubles that go through the same operations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const L: usize>(pub [f64; L]);

/// Truth values of `L` lanes, all bits or none: what a comparison of AVX2 gives and a selection takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct LaneMask<const L: usize>([u64; L]);

const TRUE: u64 = u64::MAX;

impl<const L: usize> LaneMask<L> {
    #[inline(always)]
    fn of(function: impl Fn(usize) -> bool) -> Self {
        Self(lanes(0, |i| if function(i) { TRUE } else { 0 }))
    }

    /// Whether a lane is true.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> bool {
        self.0[lane] != 0
    }
}

impl<const L: usize> BitAnd for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(lanes(0, |i| self.0[i] & other.0[i]))
    }
}

impl<const L: usize> BitOr for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(lanes(0, |i| self.0[i] | other.0[i]))
    }
}

impl<const L: usize> Not for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(lanes(0, |i| !self.0[i]))
    }
}

impl<const L: usize> Mask for LaneMask<L> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([if value { TRUE } else { 0 }; L])
    }
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = 0;
        for lane in self.0 {
            any |= lane;
        }
        any != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        let mut all = TRUE;
        for lane in self.0 {
            all &= lane;
        }
        all == TRUE
    }
}

impl<const L: usize> Lanes<L> {
    #[inline(always)]
    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        Self(lanes(0.0, |i| function(self.0[i])))
    }
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        Self(lanes(0.0, |i| function(self.0[i], other.0[i])))
    }
}

macro_rules! lane_operator {
    ($trait:ident, $method:ident, $assign_trait:ident, $assign:ident, $operator:tt) => {
        impl<const L: usize> $trait for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }
        impl<const L: usize> $assign_trait for Lanes<L> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    };
}

lane_operator!(Add, add, AddAssign, add_assign, +);
lane_operator!(Sub, sub, SubAssign, sub_assign, -);
lane_operator!(Mul, mul, MulAssign, mul_assign, *);

impl<const L: usize> Div for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}

impl<const L: usize> Scalar for Lanes<L> {
    type Mask = LaneMask<L>;
    const ROUNDOFF: f64 = f64::ROUNDOFF;
    const ORDERS: [usize; 6] = f64::ORDERS;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; L])
    }
    #[inline(always)]
    fn from_double_double(value: DoubleDouble) -> Self {
        Self([value.high(); L])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(lanes(0.0, |i| {
            f64::mul_add(self.0[i], factor.0[i], addend.0[i])
        }))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(f64::abs)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(f64::sqrt)
    }
    fn exp(self) -> Self {
        self.each(Scalar::exp)
    }
    fn ln(self) -> Self {
        self.each(Scalar::ln)
    }
    fn sin_cos(self) -> (Self, Self) {
        let mut sine = self;
        let mut cosine = self;
        for i in 0..L {
            (sine.0[i], cosine.0[i]) = Scalar::sin_cos(self.0[i]);
        }
        (sine, cosine)
    }
    fn tan(self) -> Self {
        self.each(Scalar::tan)
    }
    fn asin(self) -> Self {
        self.each(Scalar::asin)
    }
    fn acos(self) -> Self {
        self.each(Scalar::acos)
    }
    fn atan(self) -> Self {
        self.each(Scalar::atan)
    }
    fn sinh(self) -> Self {
        self.each(Scalar::sinh)
    }
    fn cosh(self) -> Self {
        self.each(Scalar::cosh)
    }
    fn tanh(self) -> Self {
        self.each(Scalar::tanh)
    }
    fn powf(self, exponent: Self) -> Self {
        self.zip(exponent, Scalar::powf)
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        LaneMask::of(|i| self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        LaneMask::of(|i| self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        LaneMask::of(|i| self.0[i].abs() < f64::INFINITY)
    }
    #[inline(always)]
    fn is_whole(self) -> Self::Mask {
        LaneMask::of(|i| libm::rint(self.0[i]) == self.0[i])
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(lanes(
            0.0,
            |i| {
                if mask.0[i] != 0 { yes.0[i] } else { no.0[i] }
            },
        ))
    }
    /// Eight lanes at a time: four running sums of sixteen lanes each are more than there are registers.
    #[inline(always)]
    fn horner_with_slope(coefficients: &[Self], at: Self) -> (Self, Self) {
        const CHUNK: usize = 8;
        let mut value = Self::splat(0.0);
        let mut slope = Self::splat(0.0);
        for first in (0..L).step_by(CHUNK) {
            let count = CHUNK.min(L - first);
            let mut square = [0.0; CHUNK];
            let (mut even, mut even_slope) = ([0.0; CHUNK], [0.0; CHUNK]);
            let (mut odd, mut odd_slope) = ([0.0; CHUNK], [0.0; CHUNK]);
            for (square, &s) in square.iter_mut().zip(&at.0[first..first + count]) {
                *square = s * s;
            }
            let pairs = coefficients.chunks_exact(2);
            if let [last] = pairs.remainder() {
                even[..count].copy_from_slice(&last.0[first..first + count]);
            }
            for pair in pairs.rev() {
                for i in 0..count {
                    even_slope[i] = f64::mul_add(even_slope[i], square[i], even[i]);
                    odd_slope[i] = f64::mul_add(odd_slope[i], square[i], odd[i]);
                    even[i] = f64::mul_add(even[i], square[i], pair[0].0[first + i]);
                    odd[i] = f64::mul_add(odd[i], square[i], pair[1].0[first + i]);
                }
            }
            for i in 0..count {
                let s = at.0[first + i];
                value.0[first + i] = f64::mul_add(odd[i], s, even[i]);
                let both = f64::mul_add(odd_slope[i], s, even_slope[i]);
                slope.0[first + i] = f64::mul_add(s + s, both, odd[i]);
            }
        }
        (value, slope)
    }
    #[inline(always)]
    fn coarse_log2(self) -> Self {
        self.each(coarse_log2)
    }
    #[inline(always)]
    fn coarse_exp2(self) -> Self {
        self.each(coarse_exp2)
    }
}
