//! What the evaluation of Upsilon asks of a number beyond arithmetic: its binary exponent, floor and table look-up.

use crate::numerics::{DoubleDouble, Lanes, Real, Scalar};
use core::array::from_fn;

/// A number, or several side by side, at which Upsilon can be evaluated.
pub trait Argument: Scalar {
    /// One lane.
    type Real: Real;

    /// The largest integer that is not above it.
    fn floor(self) -> Self;
    /// `(e, m)` with `self = m 2^e` and m in [sqrt(1/2), sqrt(2)), for a positive normal number.
    fn split_binary(self) -> (Self, Self);
    /// Lane by lane the entry at `index`, an integer from 0 to N - 1; N is a power of two.
    fn look_up<const N: usize>(table: &[Self::Real; N], index: Self) -> Self;
}

/// Adding it to an integer below 2^51 puts that integer into the low bits of the pattern.
const INTEGER_BITS: f64 = 4_503_599_627_370_496.0;

#[inline(always)]
fn table_index<const N: usize>(index: f64) -> usize {
    const { assert!(N.is_power_of_two()) };
    (index + INTEGER_BITS).to_bits() as usize & (N - 1)
}

#[inline(always)]
fn split_binary(value: f64) -> (f64, f64) {
    let bits = value.to_bits();
    // Moves [sqrt(1/2), sqrt(2)) onto one binade of the exponent field.
    const SQRT_HALF: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    const FIELD: u64 = 0xFFF << 52;
    let offset = bits.wrapping_sub(SQRT_HALF) & FIELD;
    let mantissa = f64::from_bits(bits.wrapping_sub(offset));
    // The field is a signed multiple of 2^52; the trick of INTEGER_BITS again, with a bias that makes it positive.
    const BIAS: u64 = 2048;
    let biased = (offset >> 52).wrapping_add(BIAS) & 0xFFF;
    let exponent = f64::from_bits(biased | INTEGER_BITS.to_bits()) - (INTEGER_BITS + BIAS as f64);
    (exponent, mantissa)
}

impl Argument for f64 {
    type Real = f64;
    #[inline(always)]
    fn floor(self) -> Self {
        f64::floor(self)
    }
    #[inline(always)]
    fn split_binary(self) -> (Self, Self) {
        split_binary(self)
    }
    #[inline(always)]
    fn look_up<const N: usize>(table: &[f64; N], index: Self) -> Self {
        table[table_index::<N>(index)]
    }
}

impl<const L: usize> Argument for Lanes<L> {
    type Real = f64;
    #[inline(always)]
    fn floor(self) -> Self {
        Self(from_fn(|i| self.0[i].floor()))
    }
    #[inline(always)]
    fn split_binary(self) -> (Self, Self) {
        (
            Self(from_fn(|i| split_binary(self.0[i]).0)),
            Self(from_fn(|i| split_binary(self.0[i]).1)),
        )
    }
    #[inline(always)]
    fn look_up<const N: usize>(table: &[f64; N], index: Self) -> Self {
        Self(from_fn(|i| table[table_index::<N>(index.0[i])]))
    }
}

impl Argument for DoubleDouble {
    type Real = DoubleDouble;
    fn floor(self) -> Self {
        let high = self.high().floor();
        if high < self.high() {
            Self::from(high)
        } else {
            Self::sum(high, self.low().floor())
        }
    }
    fn split_binary(self) -> (Self, Self) {
        let (exponent, _) = split_binary(self.high());
        let by = |value: f64| libm::scalbn(value, -exponent as i32);
        (
            Self::from(exponent),
            Self::sum(by(self.high()), by(self.low())),
        )
    }
    fn look_up<const N: usize>(table: &[DoubleDouble; N], index: Self) -> Self {
        table[table_index::<N>(index.high())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_split_number_is_whole_again(bits in 0x0010_0000_0000_0000_u64..0x7FF0_0000_0000_0000) {
            let x = f64::from_bits(bits);
            let (exponent, mantissa) = split_binary(x);
            prop_assert_eq!(libm::scalbn(mantissa, exponent as i32), x);
            prop_assert!((core::f64::consts::FRAC_1_SQRT_2..core::f64::consts::SQRT_2).contains(&mantissa), "{mantissa}");
            let (same, double) = DoubleDouble::sum(x, x * 1e-17).split_binary();
            prop_assert_eq!(same.high(), exponent);
            prop_assert_eq!(double.high(), mantissa);
        }
    }
}
