//! Numbers inside expressions, and their exact or nearly exact arithmetic.

use super::eval::{LARGEST_MULTIPLIED_EXPONENT, integer_power};
use crate::numerics::{DoubleDouble, Real, Scalar};
use core::hash::{Hash, Hasher};

/// A constant of an expression, held to about 32 digits so that folding `1/3` loses nothing a verification run sees.
/// Two numbers are equal when their bits are.
#[derive(Clone, Copy, Debug)]
pub struct Number(DoubleDouble);

/// Folding rounds at about 2^-104; a trailing part below this share of the leading one is that rounding, so `6 * (1/3)`
/// is 2 and nothing else.
const FOLDING_NOISE: f64 = 1.0 / (1_u128 << 102) as f64;

impl Number {
    /// Wraps a value. Minus zero becomes zero.
    pub fn new(value: DoubleDouble) -> Self {
        if value.high() == 0.0 {
            return Self(DoubleDouble::ZERO);
        }
        Self(value)
    }

    /// The value.
    pub const fn value(self) -> DoubleDouble {
        self.0
    }

    /// The value as an integer, where it is one that fits.
    pub fn as_integer(self) -> Option<i32> {
        let high = self.0.high();
        let is_integer = self.0.low() == 0.0 && libm::rint(high) == high;
        (is_integer && high.abs() <= f64::from(i32::MAX)).then_some(high as i32)
    }

    fn bits(self) -> (u64, u64) {
        (self.0.high().to_bits(), self.0.low().to_bits())
    }
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Number {}

impl Hash for Number {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}

fn settled(value: DoubleDouble) -> DoubleDouble {
    if value.low().abs() <= FOLDING_NOISE * value.high().abs() {
        return DoubleDouble::from(value.high());
    }
    value
}

/// `a + b`, unless it leaves the range of numbers. What is left where they cancel but for rounding is nothing: `0.73*0.3*x`
/// and `0.219*x` are one.
pub(in crate::expressions) fn folded_sum(a: DoubleDouble, b: DoubleDouble) -> Option<DoubleDouble> {
    let sum = a + b;
    let greatest = a.high().abs().max(b.high().abs());
    if sum.high().abs() <= FOLDING_NOISE * greatest {
        return greatest.is_finite().then_some(DoubleDouble::ZERO);
    }
    sum.is_finite().then(|| settled(sum))
}

/// Whether a result that should not be zero has lost digits at the lower end of the range.
fn vanished(value: DoubleDouble) -> bool {
    value.high().abs() < f64::MIN_POSITIVE
}

/// `a * b`, unless it leaves the range of numbers on either end.
pub(in crate::expressions) fn folded_product(
    a: DoubleDouble,
    b: DoubleDouble,
) -> Option<DoubleDouble> {
    let product = a * b;
    let trivial = [a, b].iter().any(|factor| {
        let size = factor.high().abs();
        factor.low() == 0.0 && (size == 0.0 || size == 1.0)
    });
    (product.is_finite() && (trivial || !vanished(product))).then(|| settled(product))
}

/// `a / b`, unless it is undefined or leaves the range of numbers on either end.
pub(in crate::expressions) fn folded_quotient(
    a: DoubleDouble,
    b: DoubleDouble,
) -> Option<DoubleDouble> {
    let quotient = a / b;
    let trivial = a.high() == 0.0 || (b.low() == 0.0 && b.high().abs() == 1.0);
    let lost = !trivial && vanished(quotient);
    (quotient.is_finite() && !lost && b.is_finite()).then(|| settled(quotient))
}

/// `base ^ exponent` where that is an integer power, or a half-integer power of a perfect square, and stays in range.
pub(in crate::expressions) fn folded_power(
    base: DoubleDouble,
    exponent: DoubleDouble,
) -> Option<DoubleDouble> {
    if !base.is_finite() {
        return None;
    }
    if base.high() == 0.0 {
        return (exponent.high() > 0.0).then_some(DoubleDouble::ZERO);
    }
    if let Some(integer) = Number(exponent).as_integer() {
        return folded_integer_power(base, integer);
    }
    let twice = Number(exponent + exponent).as_integer()?;
    let root = base.high().sqrt();
    let perfect_square = base.low() == 0.0 && root.mul_add(root, -base.high()) == 0.0;
    if !perfect_square {
        return None;
    }
    folded_integer_power(DoubleDouble::from(root), twice)
}

fn folded_integer_power(base: DoubleDouble, exponent: i32) -> Option<DoubleDouble> {
    if exponent.unsigned_abs() > LARGEST_MULTIPLIED_EXPONENT.unsigned_abs() {
        return None;
    }
    let power = integer_power(base, exponent.abs());
    if vanished(power) || !power.is_finite() {
        return None;
    }
    if exponent < 0 {
        folded_quotient(DoubleDouble::ONE, power)
    } else {
        Some(settled(power))
    }
}
