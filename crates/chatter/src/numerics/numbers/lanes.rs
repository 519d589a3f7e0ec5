//! Several doubles side by side, one trajectory each.
//!
//! Plain arrays: inside a function compiled for AVX2 or AVX-512 the loops below become vector instructions. Every
//! operation is the scalar one lane by lane, so a lane holds exactly the bits a scalar run would.

use super::super::DoubleDouble;
use super::dispatch::{Kernel, dispatch_wide};
use super::scalar::{Mask, Scalar, coarse_exp2, coarse_log2, short};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// An array by index. A macro, since a closure is a function of its own, which need not be inlined and so compiled for the features of
/// the kernel that it stands in.
macro_rules! lanes {
    ($first:expr, |$i:ident| $value:expr) => {{
        let mut all = [$first; L];
        for ($i, lane) in all.iter_mut().enumerate() {
            *lane = $value;
        }
        all
    }};
}

/// Truth values by lane.
macro_rules! mask {
    (|$i:ident| $truth:expr) => {
        LaneMask(lanes!(0, |$i| if $truth { TRUE } else { 0 }))
    };
}

/// In the implementation of [`Scalar`] by [`Wide`] numbers, the functions that no instruction computes: of each number by itself.
macro_rules! number_by_number {
    () => {
        $crate::numerics::numbers::lanes::number_by_number!(exp ln tan asin acos atan sinh cosh tanh);

        fn sin_cos(self) -> (Self, Self) {
            let mut both = (self, self);
            for (sine, cosine) in (both.0.lanes_mut().iter_mut()).zip(both.1.lanes_mut()) {
                (*sine, *cosine) = Scalar::sin_cos(*sine);
            }
            both
        }
        fn powf(mut self, exponent: Self) -> Self {
            for (value, &exponent) in self.lanes_mut().iter_mut().zip(exponent.lanes()) {
                *value = Scalar::powf(*value, exponent);
            }
            self
        }
    };
    ($($function:ident)+) => {
        $(fn $function(mut self) -> Self {
            for value in self.lanes_mut() {
                *value = Scalar::$function(*value);
            }
            self
        })+
    };
}
pub(super) use number_by_number;

/// `L` doubles that go through the same operations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const L: usize>(pub [f64; L]);

/// Truth values of `L` lanes, all bits or none: what a comparison of AVX2 gives and a selection takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct LaneMask<const L: usize>([u64; L]);

const TRUE: u64 = u64::MAX;

/// Some of at most 64 lanes, by number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneSet(u64);

/// Numbers that are several side by side.
pub trait Wide: Scalar<Mask: WideMask> {
    /// How many.
    const LANES: usize;
    /// Each by itself.
    fn lanes(&self) -> &[f64];
    /// Each by itself, to be changed.
    fn lanes_mut(&mut self) -> &mut [f64];
    /// Runs a kernel with the instructions that such numbers are for; nothing where the processor has none of these.
    fn run<K: Kernel>(kernel: K) -> Option<K::Output>;
}

/// Truth values of such numbers.
pub trait WideMask: Mask {
    /// Whether a lane is true.
    fn lane(&self, lane: usize) -> bool;
    /// The lanes that are true.
    fn set(&self) -> LaneSet;
}

impl LaneSet {
    /// No lane.
    pub const NONE: Self = Self(0);

    /// By bit, the lowest for the first lane.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub(super) fn of_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// The first so many.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        Self(match count {
            64.. => u64::MAX,
            _ => (1 << count) - 1,
        })
    }

    /// How many there are.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether a lane is one of them.
    #[inline(always)]
    pub fn has(self, lane: usize) -> bool {
        self.0 >> lane & 1 != 0
    }

    /// With one more.
    #[inline(always)]
    pub fn with(self, lane: usize) -> Self {
        Self(self.0 | 1 << lane)
    }

    /// Those among so many from a first one on.
    #[inline(always)]
    pub fn among(self, first: usize, count: usize) -> Self {
        Self(self.0 & Self::first(count).0 << first)
    }

    /// Those that are not among others.
    #[inline(always)]
    pub fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }
}

impl BitAnd for LaneSet {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for LaneSet {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// From the first lane on.
impl Iterator for LaneSet {
    type Item = usize;
    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        let is_any = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        is_any.then_some(lane)
    }
}

impl<const L: usize> WideMask for LaneMask<L> {
    #[inline(always)]
    fn lane(&self, lane: usize) -> bool {
        self.0[lane] != 0
    }
    #[inline(always)]
    fn set(&self) -> LaneSet {
        let mut bits = 0;
        for (lane, &value) in self.0.iter().enumerate() {
            bits |= (value & 1) << lane;
        }
        LaneSet(bits)
    }
}

impl<const L: usize> Wide for Lanes<L> {
    const LANES: usize = L;
    #[inline(always)]
    fn lanes(&self) -> &[f64] {
        &self.0
    }
    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
    fn run<K: Kernel>(kernel: K) -> Option<K::Output> {
        dispatch_wide(kernel)
    }
}

impl<const L: usize> BitAnd for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(lanes!(0, |i| self.0[i] & other.0[i]))
    }
}

impl<const L: usize> BitOr for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(lanes!(0, |i| self.0[i] | other.0[i]))
    }
}

impl<const L: usize> Not for LaneMask<L> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(lanes!(0, |i| !self.0[i]))
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
        Self(lanes!(0.0, |i| function(self.0[i])))
    }
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        Self(lanes!(0.0, |i| function(self.0[i], other.0[i])))
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
        Self(lanes!(0.0, |i| {
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
    number_by_number!();
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        mask!(|i| self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        mask!(|i| self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        mask!(|i| self.0[i].abs() < f64::INFINITY)
    }
    #[inline(always)]
    fn is_whole(self) -> Self::Mask {
        mask!(|i| libm::rint(self.0[i]) == self.0[i])
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(lanes!(0.0, |i| if mask.0[i] != 0 {
            yes.0[i]
        } else {
            no.0[i]
        }))
    }
    #[inline(always)]
    fn coarse_log2(self) -> Self {
        self.each(coarse_log2)
    }
    #[inline(always)]
    fn coarse_exp2(self) -> Self {
        self.each(coarse_exp2)
    }
    #[inline(always)]
    fn short(self) -> Self {
        self.each(short)
    }
}
