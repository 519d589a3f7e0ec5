//! Numbers of about 32 decimal digits: the unevaluated sum of two doubles.
//!
//! Error-free transformations after Dekker and Knuth; the product by fused multiply-add. Used to verify the double
//! runs, and where the user asks for more digits.

use super::scalar::{Real, Scalar, coarse_exp2, coarse_log2, short};
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use core::str::FromStr;

/// `high + low` with `|low|` at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// `a + b` exactly, as rounded sum and remainder, for any `a` and `b`.
#[inline(always)]
pub(crate) fn two_sum<S: Scalar>(a: S, b: S) -> (S, S) {
    a.two_sum(b)
}

#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

#[inline(always)]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl DoubleDouble {
    /// pi / 2 in three parts, so that angles of a few million turns still reduce to full precision.
    const HALF_PI: [f64; 3] = [
        core::f64::consts::FRAC_PI_2,
        6.123_233_995_736_766e-17,
        -1.497_384_904_859_169_8e-33,
    ];
    /// The circle constant.
    pub const PI: Self = Self {
        high: core::f64::consts::PI,
        low: 1.224_646_799_147_353_2e-16,
    };
    const LN_2: Self = Self {
        high: core::f64::consts::LN_2,
        low: 2.319_046_813_846_299_6e-17,
    };

    /// The sum of two doubles, exactly.
    pub fn sum(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self { high, low }
    }

    /// The leading part: the nearest double.
    #[inline(always)]
    pub const fn high(self) -> f64 {
        self.high
    }

    /// The trailing part.
    #[inline(always)]
    pub const fn low(self) -> f64 {
        self.low
    }

    fn renormalised(high: f64, low: f64) -> Self {
        let (high, low) = quick_two_sum(high, low);
        // An overflowed or undefined leading part has no meaningful trailing one.
        Self {
            high,
            low: if high.is_finite() { low } else { 0.0 },
        }
    }

    fn times_power_of_two(self, exponent: i32) -> Self {
        Self {
            high: libm::scalbn(self.high, exponent),
            low: libm::scalbn(self.low, exponent),
        }
    }

    /// Integer power by repeated squaring.
    pub fn powi(self, exponent: i32) -> Self {
        let mut result = Self::ONE;
        let mut base = if exponent < 0 { Self::ONE / self } else { self };
        let mut left = exponent.unsigned_abs();
        while left > 0 {
            if left & 1 == 1 {
                result *= base;
            }
            base *= base;
            left >>= 1;
        }
        result
    }

    /// `exp(x) - 1` for |x| below about 0.4, by a scaled series that loses nothing near zero.
    fn expm1_small(self) -> Self {
        // exp(x) - 1 = e: doubling x turns e into e (2 + e).
        const DOUBLINGS: i32 = 6;
        let x = self.times_power_of_two(-DOUBLINGS);
        let mut term = x;
        let mut sum = x;
        let mut k = 2.0;
        while term.high.abs() > sum.high.abs() * 1e-34 {
            term = term * x / Self::from(k);
            sum += term;
            k += 1.0;
        }
        for _ in 0..DOUBLINGS {
            sum = sum * (sum + Self::from(2.0));
        }
        sum
    }

    fn sin_cos_small(self) -> (Self, Self) {
        let square = self * self;
        let mut term = self;
        let mut sine = self;
        let mut k = 1.0;
        while term.high.abs() > sine.high.abs() * 1e-34 {
            term = -(term * square) / Self::from((k + 1.0) * (k + 2.0));
            sine += term;
            k += 2.0;
        }
        let cosine = (Self::ONE - sine * sine).sqrt();
        (sine, cosine)
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let (high, error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let (high, error) = quick_two_sum(high, error + low);
        Self::renormalised(high, error + low_error)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high.mul_add(other.low, self.low * other.high);
        Self::renormalised(high, error + cross)
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() || !other.high.is_finite() {
            return Self::from(first);
        }
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        let third = rest.high / other.high;
        let (high, low) = quick_two_sum(first, second);
        Self { high, low } + Self::from(third)
    }
}

impl AddAssign for DoubleDouble {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for DoubleDouble {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            decided => decided,
        }
    }
}

impl Scalar for DoubleDouble {
    type Mask = bool;
    const ROUNDOFF: f64 = 6.162_975_822_039_155e-33; // 2^-107
    const ORDERS: [usize; 6] = [14, 18, 24, 32, 40, 50];

    fn splat(value: f64) -> Self {
        Self::from(value)
    }
    fn from_double_double(value: DoubleDouble) -> Self {
        value
    }
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    /// Products, and sums of what is greatest in them, are exact; what these leave is summed as doubles. That is what a sum of rounded
    /// products is good for (Ogita, Rump & Oishi 2005), while from one product to the next nothing waits but an addition.
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        let (product, lost) = two_product(a.high, b.high);
        let cross = a.high.mul_add(b.low, a.low * b.high);
        let (high, more) = two_sum(self.high, product);
        Self {
            high,
            low: self.low + ((lost + cross) + more),
        }
    }
    #[inline(always)]
    fn summed(self) -> Self {
        let (high, low) = two_sum(self.high, self.low);
        Self::renormalised(high, low)
    }
    #[inline(always)]
    fn convolve(a: &[Self], b: &[Self]) -> Self {
        let mut sum = Self::ZERO;
        for (&a, &b) in a.iter().zip(b.iter().rev()) {
            sum = sum.plus_product(a, b);
        }
        sum.summed()
    }
    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }
    fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 || !root.is_finite() {
            return Self::from(root);
        }
        // One Newton step from the double root doubles its digits.
        let root = Self::from(root);
        let rest = self - root * root;
        root + Self::from(rest.high / (2.0 * root.high))
    }
    fn exp(self) -> Self {
        if self.high.is_nan() || self.high > 709.0 || self.high < -740.0 {
            return Self::from(libm::exp(self.high));
        }
        let turns = libm::rint(self.high * core::f64::consts::LOG2_E);
        let rest = self - Self::LN_2 * Self::from(turns);
        (rest.expm1_small() + Self::ONE).times_power_of_two(turns as i32)
    }
    fn ln(self) -> Self {
        let guess = libm::log(self.high);
        if !guess.is_finite() {
            return Self::from(guess);
        }
        // Newton on exp(y) = x, y' = y + x exp(-y) - 1, in powers of two so that exp(-y) cannot overflow; a second
        // step where the first guess is a poor relative one, near x = 1.
        let exponent = libm::ilogb(self.high);
        let mantissa = self.times_power_of_two(-exponent);
        let mut y = Self::from(libm::log(mantissa.high));
        for _ in 0..2 {
            y = y + (mantissa * (-y).exp() - Self::ONE);
        }
        y + Self::LN_2 * Self::from(f64::from(exponent))
    }
    fn sin_cos(self) -> (Self, Self) {
        let quarter_turns = libm::rint(self.high * core::f64::consts::FRAC_2_PI);
        if !quarter_turns.is_finite() {
            return (Self::from(f64::NAN), Self::from(f64::NAN));
        }
        let count = Self::from(quarter_turns);
        let mut rest = self;
        for part in Self::HALF_PI {
            rest -= count * Self::from(part);
        }
        let (sine, cosine) = rest.sin_cos_small();
        match libm::fmod(quarter_turns, 4.0) as i64 {
            0 => (sine, cosine),
            1 | -3 => (cosine, -sine),
            2 | -2 => (-sine, -cosine),
            _ => (-cosine, sine),
        }
    }
    fn tan(self) -> Self {
        let (sine, cosine) = self.sin_cos();
        sine / cosine
    }
    fn asin(self) -> Self {
        (self / ((Self::ONE - self) * (Self::ONE + self)).sqrt()).atan()
    }
    fn acos(self) -> Self {
        let half = ((Self::ONE - self) / (Self::ONE + self)).sqrt().atan();
        half + half
    }
    fn atan(self) -> Self {
        let guess = Self::from(libm::atan(self.high));
        if self.high.is_infinite() {
            return Self::PI.times_power_of_two(-1) * Self::from(self.high.signum());
        }
        // tan(y - guess) = (x cos - sin) / (cos + x sin), and the difference is small.
        let (sine, cosine) = guess.sin_cos();
        let small = (self * cosine - sine) / (cosine + self * sine);
        guess + small
    }
    fn sinh(self) -> Self {
        if self.high.abs() < 0.35 {
            let e = self.expm1_small();
            return (e + e / (e + Self::ONE)).times_power_of_two(-1);
        }
        let e = self.exp();
        (e - Self::ONE / e).times_power_of_two(-1)
    }
    fn cosh(self) -> Self {
        let e = self.exp();
        (e + Self::ONE / e).times_power_of_two(-1)
    }
    fn tanh(self) -> Self {
        if self.high.abs() > 40.0 {
            return Self::from(self.high.signum());
        }
        self.sinh() / self.cosh()
    }
    fn powf(self, exponent: Self) -> Self {
        if self == Self::ZERO {
            // The logarithm of zero has no trailing part to work with.
            return match exponent.partial_cmp(&Self::ZERO) {
                Some(core::cmp::Ordering::Greater) => Self::ZERO,
                Some(core::cmp::Ordering::Equal) => Self::ONE,
                Some(core::cmp::Ordering::Less) => Self::from(f64::INFINITY),
                None => exponent,
            };
        }
        (exponent * self.ln()).exp()
    }
    fn less(self, other: Self) -> bool {
        self < other
    }
    fn at_most(self, other: Self) -> bool {
        self <= other
    }
    fn is_finite(self) -> bool {
        self.high.is_finite()
    }
    fn is_whole(self) -> bool {
        libm::rint(self.high) == self.high && libm::rint(self.low) == self.low
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    fn coarse_log2(self) -> Self {
        Self::from(coarse_log2(self.high))
    }
    fn coarse_exp2(self) -> Self {
        Self::from(coarse_exp2(self.high))
    }
    fn short(self) -> Self {
        Self::from(short(self.high))
    }
}

impl Real for DoubleDouble {
    fn to_f64(self) -> f64 {
        self.high
    }
    fn to_double_double(self) -> DoubleDouble {
        self
    }
    const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };
    const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };
}

/// Why a text is not a decimal number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotANumber(pub String);

impl fmt::Display for NotANumber {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "`{}` is not a decimal number", self.0)
    }
}

impl std::error::Error for NotANumber {}

impl DoubleDouble {
    /// Whether a decimal that was read as this number is too small to be told from zero.
    pub fn is_lost_of(self, decimal: &str) -> bool {
        let mantissa = decimal.split(['e', 'E']).next().unwrap_or_default();
        self.high == 0.0 && mantissa.contains(|c| ('1'..='9').contains(&c))
    }
}

impl FromStr for DoubleDouble {
    type Err = NotANumber;

    /// Reads a decimal number to full precision: `0.1` is a tenth, not the double nearest to it.
    fn from_str(text: &str) -> Result<Self, NotANumber> {
        let wrong = || NotANumber(text.to_string());
        let high: f64 = text.parse().map_err(|_| wrong())?;
        if high == 0.0 || !high.is_finite() {
            return Ok(Self::from(high));
        }
        let (digits, exponent) = match text.split_once(['e', 'E']) {
            Some((digits, exponent)) => (digits, exponent.parse::<i32>().map_err(|_| wrong())?),
            None => (text, 0),
        };
        let mut value = Self::ZERO;
        let mut scale = exponent;
        let mut after_point = false;
        // Digits past the 36th cannot matter to 32.
        let mut taken = 0;
        for character in digits.chars() {
            match character {
                '.' => after_point = true,
                '0'..='9' if taken < 36 => {
                    value = value * Self::from(10.0)
                        + Self::from(f64::from(character.to_digit(10).unwrap_or(0)));
                    scale -= i32::from(after_point);
                    taken += usize::from(taken > 0 || character != '0');
                }
                '0'..='9' => scale += i32::from(!after_point),
                _ => {}
            }
        }
        value = if scale < -290 {
            value / Self::from(10.0).powi(290) / Self::from(10.0).powi(-scale - 290)
        } else if scale < 0 {
            value / Self::from(10.0).powi(-scale)
        } else {
            value * Self::from(10.0).powi(scale)
        };
        if text.starts_with('-') {
            value = -value;
        }
        let low = (value - Self::from(high)).high;
        Ok(Self::renormalised(
            high,
            if low.is_finite() { low } else { 0.0 },
        ))
    }
}

impl fmt::Display for DoubleDouble {
    /// Scientific notation with the precision's count of decimals, 31 if none is given.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.high == 0.0 || !self.high.is_finite() {
            return fmt::Display::fmt(&self.high, out);
        }
        let decimals = out.precision().unwrap_or(31).min(40);
        let ten = Self::from(10.0);
        let magnitude = self.abs();
        let mut exponent = libm::floor(libm::log10(magnitude.high)) as i32;
        let mut rest = if exponent > 0 {
            magnitude / ten.powi(exponent)
        } else if exponent < -290 {
            magnitude * ten.powi(290) * ten.powi(-exponent - 290)
        } else {
            magnitude * ten.powi(-exponent)
        };
        if rest >= ten {
            rest = rest / ten;
            exponent += 1;
        }
        if rest < Self::ONE {
            rest *= ten;
            exponent -= 1;
        }
        // The leading digit may round up to 10: digits are carried from the right.
        let mut digits = Vec::with_capacity(decimals + 2);
        for _ in 0..decimals + 2 {
            let digit = libm::floor(rest.high).clamp(0.0, 9.0);
            digits.push(digit as u8);
            rest = (rest - Self::from(digit)) * ten;
        }
        let mut carry = u8::from(digits.pop().unwrap_or(0) >= 5);
        for digit in digits.iter_mut().rev() {
            *digit += carry;
            carry = *digit / 10;
            *digit %= 10;
        }
        if carry == 1 {
            digits.insert(0, 1);
            digits.pop();
            exponent += 1;
        }
        if self.high < 0.0 {
            out.write_str("-")?;
        } else if out.sign_plus() {
            out.write_str("+")?;
        }
        for (place, digit) in digits.iter().enumerate() {
            if place == 1 {
                out.write_str(".")?;
            }
            write!(out, "{digit}")?;
        }
        if exponent != 0 {
            write!(out, "e{exponent}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: DoubleDouble, b: DoubleDouble) -> bool {
        (a - b).abs().high() <= 2e-30 * b.abs().high().max(1e-290)
    }

    #[test]
    fn decimal_text_is_read_to_full_precision() {
        let tenth: DoubleDouble = "0.1".parse().unwrap();
        assert!(close(tenth * DoubleDouble::from(10.0), DoubleDouble::ONE));
        assert_eq!(tenth.high(), 0.1);
        let pi: DoubleDouble = "3.14159265358979323846264338327950288".parse().unwrap();
        assert!(close(pi, DoubleDouble::PI));
        assert_eq!(
            "1e3".parse::<DoubleDouble>().unwrap(),
            DoubleDouble::from(1000.0)
        );
        assert_eq!(
            "-2.50".parse::<DoubleDouble>().unwrap(),
            DoubleDouble::from(-2.5)
        );
        assert!("1.2.3".parse::<DoubleDouble>().is_err());
    }

    #[test]
    fn display_rounds_to_the_asked_decimals() {
        assert_eq!(
            format!("{:.30}", DoubleDouble::PI),
            "3.141592653589793238462643383280"
        );
        assert_eq!(format!("{:.3}", DoubleDouble::from(0.0009996)), "9.996e-4");
        assert_eq!(format!("{:.2}", DoubleDouble::from(0.0009996)), "1.00e-3");
        assert_eq!(format!("{}", DoubleDouble::ZERO), "0");
    }

    #[test]
    fn known_values_to_thirty_digits() {
        let check = |value: DoubleDouble, text: &str| {
            assert!(close(value, text.parse().unwrap()), "{value} is not {text}");
        };
        let two = DoubleDouble::from(2.0);
        check(two.sqrt(), "1.41421356237309504880168872420969807857");
        check(
            DoubleDouble::ONE.exp(),
            "2.71828182845904523536028747135266249776",
        );
        check(two.ln(), "0.693147180559945309417232121458176568076");
        check(
            DoubleDouble::ONE.sin_cos().0,
            "0.841470984807896506652502321630298999623",
        );
        check(
            DoubleDouble::from(100.0).sin_cos().1,
            "0.8623188722876839341019385139508425355",
        );
        check(
            DoubleDouble::ONE.atan() * DoubleDouble::from(4.0),
            "3.14159265358979323846264338327950288",
        );
        check(
            DoubleDouble::from(0.5).asin() * DoubleDouble::from(6.0),
            "3.14159265358979323846264338327950288",
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// What cancels in high parts is not lost.
        #[test]
        fn sums_of_products_of_whole_numbers_are_exact(
            pairs in prop::collection::vec((-1_i64 << 44..1 << 44, -1_i64 << 44..1 << 44), 0..50)
        ) {
            let (a, b): (Vec<i64>, Vec<i64>) = pairs.iter().copied().unzip();
            let mirrored = b.iter().rev();
            let exact: i128 = a.iter().zip(mirrored).map(|(&a, &b)| i128::from(a) * i128::from(b)).sum();
            let [a, b] = [a, b].map(|all| all.iter().map(|&x| DoubleDouble::from(x as f64)).collect::<Vec<_>>());
            let sum = DoubleDouble::convolve(&a, &b);
            prop_assert_eq!(sum.high as i128 + sum.low as i128, exact);
        }

        /// Of numbers with low parts they are those of rounded products, to roundoffs of the products' sizes.
        #[test]
        fn sums_of_products_are_as_good_as_one_by_one(
            all in prop::collection::vec((-1.0..1.0, -1e-17..1e-17, -1.0..1.0, -1e-17..1e-17), 1..50)
        ) {
            let pairs = all.iter().map(|&(a, b, c, d)| (DoubleDouble::sum(a, b), DoubleDouble::sum(c, d)));
            let (mut sum, mut rounded, mut size) = (DoubleDouble::ZERO, DoubleDouble::ZERO, 0.0);
            for (a, b) in pairs {
                sum = sum.plus_product(a, b);
                rounded = a.mul_add(b, rounded);
                size += (a * b).abs().high();
            }
            let off = (sum.summed() - rounded).abs().high();
            prop_assert!(off <= 16.0 * DoubleDouble::ROUNDOFF * size * all.len() as f64, "{off:e} {size}");
        }
        #[test]
        fn functions_obey_their_laws(x in -3.0_f64..3.0, y in 0.01_f64..9.0) {
            let x = DoubleDouble::sum(x, x * 1e-17);
            let y = DoubleDouble::sum(y, y * 1e-17);
            let (sine, cosine) = x.sin_cos();
            prop_assert!(close(sine * sine + cosine * cosine, DoubleDouble::ONE));
            prop_assert!(close(y.ln().exp(), y));
            prop_assert!(close(y.sqrt() * y.sqrt(), y));
            // Relative to one or more: near zero their difference would be compared with next to nothing.
            let off = (x.tanh() * x.cosh() - x.sinh()) / x.cosh();
            prop_assert!(close(off + DoubleDouble::ONE, DoubleDouble::ONE));
            prop_assert!(close(x / y * y, x));
            // Far enough from the poles that the tangent does not magnify the rounding of its argument.
            let angle = x * DoubleDouble::from(0.5);
            prop_assert!(close(angle.tan().atan(), angle));
            let text = format!("{y:.33}");
            prop_assert!(close(text.parse().unwrap(), y));
        }
    }
}
