//! Sixteen doubles in two registers of AVX-512, one trajectory each.
//!
//! The same operations as those of [`Lanes`](super::super::Lanes), lane by lane, to the bit. Arrays the compiler takes to pieces where it does
//! not see them whole: sums that a loop hands on become registers of eight, four and two numbers and single ones, and truth values
//! words of memory. Here a number is two registers and a truth value two masks, whatever is made of them. (With AVX2 a number is four
//! registers of sixteen, and arrays are as fast.)
//!
//! # Safety
//! Instructions of AVX-512 are sound where a processor has them. Nothing but a fleet makes numbers of this type, and it does so where
//! [`InstructionSet::detected`] has found AVX-512 (`splat` asserts it where assertions are checked): all others are made of such.
//! Intrinsics are inlined into kernels that are compiled for it; anywhere else they are calls. Two registers and sixteen doubles are
//! of one size, and each is made of any bits.

#[cfg(test)]
mod tests;

use super::super::DoubleDouble;
use super::dispatch::{InstructionSet, Kernel, dispatch_avx512};
use super::lanes::{LaneSet, Wide, WideMask, number_by_number};
use super::scalar::{BIAS, DROPPED, Mask, Scalar, TWO_40, TWO_52, TWO_52_BITS};
use core::arch::x86_64::*;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

const LANES: usize = 16;

/// Sixteen doubles that go through the same operations.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Registers([__m512d; 2]);

/// Truth values of as many lanes, a bit each.
#[derive(Clone, Copy, Debug)]
pub struct RegisterMask([__mmask8; 2]);

/// What intrinsics make of each register. A macro, as those of [`Lanes`](super::super::Lanes) are.
macro_rules! each {
    ($kind:ident, |$k:ident| $value:expr) => {
        // SAFETY: see the module's documentation.
        unsafe {
            $kind([
                {
                    let $k = 0;
                    $value
                },
                {
                    let $k = 1;
                    $value
                },
            ])
        }
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident $(, $assign_trait:ident, $assign:ident)?) => {
        impl $trait for Registers {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each!(Self, |k| $intrinsic(self.0[k], other.0[k]))
            }
        }
        $(impl $assign_trait for Registers {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                *self = $trait::$method(*self, other);
            }
        })?
    };
}

operator!(Add, add, _mm512_add_pd, AddAssign, add_assign);
operator!(Sub, sub, _mm512_sub_pd, SubAssign, sub_assign);
operator!(Mul, mul, _mm512_mul_pd, MulAssign, mul_assign);
operator!(Div, div, _mm512_div_pd);

impl Neg for Registers {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(Self, |k| _mm512_xor_pd(self.0[k], _mm512_set1_pd(-0.0)))
    }
}

impl Scalar for Registers {
    type Mask = RegisterMask;
    const ROUNDOFF: f64 = f64::ROUNDOFF;
    const ORDERS: [usize; 6] = f64::ORDERS;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        debug_assert_eq!(InstructionSet::detected(), InstructionSet::Avx512);
        each!(Self, |_k| _mm512_set1_pd(value))
    }
    #[inline(always)]
    fn from_double_double(value: DoubleDouble) -> Self {
        Self::splat(value.high())
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        each!(Self, |k| _mm512_fmadd_pd(
            self.0[k],
            factor.0[k],
            addend.0[k]
        ))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        each!(Self, |k| _mm512_abs_pd(self.0[k]))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each!(Self, |k| _mm512_sqrt_pd(self.0[k]))
    }
    number_by_number!();
    #[inline(always)]
    fn less(self, other: Self) -> RegisterMask {
        each!(RegisterMask, |k| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(
            self.0[k], other.0[k]
        ))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> RegisterMask {
        each!(RegisterMask, |k| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(
            self.0[k], other.0[k]
        ))
    }
    #[inline(always)]
    fn is_finite(self) -> RegisterMask {
        self.abs().less(Self::splat(f64::INFINITY))
    }
    #[inline(always)]
    fn is_whole(self) -> RegisterMask {
        each!(RegisterMask, |k| {
            let nearest = _mm512_roundscale_pd::<_MM_FROUND_NO_EXC>(self.0[k]);
            _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(nearest, self.0[k])
        })
    }
    #[inline(always)]
    fn select(mask: RegisterMask, yes: Self, no: Self) -> Self {
        each!(Self, |k| _mm512_mask_blend_pd(mask.0[k], no.0[k], yes.0[k]))
    }
    // What the instructions give where one is NaN, or both are zero, is what a selection gives.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        each!(Self, |k| _mm512_min_pd(self.0[k], other.0[k]))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        each!(Self, |k| _mm512_max_pd(self.0[k], other.0[k]))
    }
    #[inline(always)]
    fn coarse_log2(self) -> Self {
        let glued = each!(Self, |k| {
            let shifted = _mm512_srli_epi64::<12>(_mm512_castpd_si512(self.0[k]));
            let glue = _mm512_set1_epi64(TWO_52_BITS.cast_signed());
            _mm512_castsi512_pd(_mm512_or_si512(shifted, glue))
        });
        (glued - Self::splat(TWO_52)) * Self::splat(1.0 / TWO_40) - Self::splat(BIAS)
    }
    #[inline(always)]
    fn coarse_exp2(self) -> Self {
        let clamped = self.max(Self::splat(-1000.0)).min(Self::splat(1000.0));
        let biased = clamped + Self::splat(BIAS);
        let glued = biased.mul_add(Self::splat(TWO_40), Self::splat(TWO_52));
        each!(Self, |k| {
            let bits = _mm512_castpd_si512(glued.0[k]);
            _mm512_castsi512_pd(_mm512_slli_epi64::<12>(bits))
        })
    }
    #[inline(always)]
    fn short(self) -> Self {
        each!(Self, |k| {
            let half = _mm512_set1_epi64((DROPPED / 2).cast_signed());
            let kept = _mm512_set1_epi64((!(DROPPED - 1)).cast_signed());
            let bits = _mm512_add_epi64(_mm512_castpd_si512(self.0[k]), half);
            _mm512_castsi512_pd(_mm512_and_si512(bits, kept))
        })
    }
}

impl Wide for Registers {
    const LANES: usize = LANES;

    #[inline(always)]
    fn lanes(&self) -> &[f64] {
        let all: *const [f64; LANES] = (&raw const self.0).cast();
        // SAFETY: see the module's documentation.
        unsafe { &*all }
    }
    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f64] {
        let all: *mut [f64; LANES] = (&raw mut self.0).cast();
        // SAFETY: as above.
        unsafe { &mut *all }
    }
    fn run<K: Kernel>(kernel: K) -> Option<K::Output> {
        dispatch_avx512(kernel)
    }
}

macro_rules! of_masks {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for RegisterMask {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self([self.0[0] $operator other.0[0], self.0[1] $operator other.0[1]])
            }
        }
    };
}

of_masks!(BitAnd, bitand, &);
of_masks!(BitOr, bitor, |);

impl Not for RegisterMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self([!self.0[0], !self.0[1]])
    }
}

impl Mask for RegisterMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([if value { __mmask8::MAX } else { 0 }; 2])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0[0] | self.0[1] != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0[0] & self.0[1] == __mmask8::MAX
    }
}

impl WideMask for RegisterMask {
    #[inline(always)]
    fn lane(&self, lane: usize) -> bool {
        self.set().has(lane)
    }
    #[inline(always)]
    fn set(&self) -> LaneSet {
        LaneSet::of_bits(u64::from(self.0[0]) | u64::from(self.0[1]) << 8)
    }
}
