//! Numbers for people: as many digits as mean something.

use chatter::numerics::Real;

/// Decimal exponents between which a number is written without one.
const PLAIN: core::ops::Range<i32> = -4..15;

/// How many digits the user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digits(pub u32);

impl Digits {
    /// What a double holds.
    pub const DOUBLE: Self = Self(17);
    /// What the longer numbers hold with certainty.
    pub const MOST: Self = Self(30);

    /// Whether doubles do.
    pub fn fit_double(self) -> bool {
        self <= Self::DOUBLE
    }
}

impl PartialOrd for Digits {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        self.0.partial_cmp(&other.0)
    }
}

/// With so many significant digits, zeros at the end included.
pub fn significant<R: Real>(value: R, digits: u32) -> String {
    let wide = value.to_double_double();
    if wide.high() == 0.0 || !wide.high().is_finite() {
        return format!("{}", wide.high());
    }
    let decimals = digits.max(1) as usize - 1;
    let scientific = format!("{wide:.decimals$}");
    let (mantissa, exponent) = match scientific.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, exponent.parse().unwrap_or(0)),
        None => (scientific.as_str(), 0),
    };
    if !PLAIN.contains(&exponent) || exponent >= digits as i32 {
        return scientific;
    }
    let (sign, mantissa) = match mantissa.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", mantissa),
    };
    let figures: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    if exponent < 0 {
        let zeros = "0".repeat((-exponent - 1) as usize);
        return format!("{sign}0.{zeros}{figures}");
    }
    let (whole, rest) = figures.split_at(exponent as usize + 1);
    if rest.is_empty() {
        format!("{sign}{whole}")
    } else {
        format!("{sign}{whole}.{rest}")
    }
}

/// With at most so many significant digits: zeros at the end are left out.
pub fn concise<R: Real>(value: R, digits: u32) -> String {
    let text = significant(value, digits);
    let (number, exponent) = match text.find('e') {
        Some(place) => text.split_at(place),
        None => (text.as_str(), ""),
    };
    if !number.contains('.') {
        return text;
    }
    let number = number.trim_end_matches('0').trim_end_matches('.');
    format!("{number}{exponent}")
}

/// All that is known: the shortest text that gives back the double, or as many digits as asked for beyond that.
pub fn full<R: Real>(value: R, digits: Digits) -> String {
    if !digits.fit_double() {
        return significant(value, digits.0);
    }
    let double = value.to_f64();
    if digits == Digits::DOUBLE {
        let exponent = if double == 0.0 {
            0.0
        } else {
            double.abs().log10().floor()
        };
        if PLAIN.contains(&(exponent as i32)) {
            return format!("{double}");
        }
        return format!("{double:e}");
    }
    concise(double, digits.0)
}

/// With so many decimals, for columns whose points stand below each other.
pub fn fixed<R: Real>(value: R, decimals: u32) -> String {
    let wide = value.to_double_double();
    let plain = format!("{:.*}", decimals as usize, wide.high());
    let before_point = plain.find('.').unwrap_or(plain.len());
    if wide.low() == 0.0 || !wide.high().is_finite() {
        return plain;
    }
    // Digits from the first one that is not zero.
    let leading = wide.high().abs().log10().floor() as i32 + 1;
    let text = significant(value, (leading + decimals as i32).max(1) as u32);
    // A number too small for the column, or one that rounding gave another digit, is good as a double.
    if text.find('.') == Some(before_point) && text.len() == plain.len() {
        text
    } else {
        plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chatter::numerics::DoubleDouble;

    #[test]
    fn digits_are_those_asked_for() {
        assert_eq!(significant(1234.5678, 6), "1234.57");
        assert_eq!(significant(-0.001_234, 3), "-0.00123");
        assert_eq!(significant(9.999, 3), "10.0");
        assert_eq!(significant(1e-20, 3), "1.00e-20");
        assert_eq!(significant(123_456.0, 3), "1.23e5");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(
            significant(DoubleDouble::PI, 30),
            "3.14159265358979323846264338328"
        );
        assert_eq!(concise(0.5, 17), "0.5");
        assert_eq!(concise(40.0, 12), "40");
        assert_eq!(full(0.1, Digits::DOUBLE), "0.1");
        assert_eq!(full(1e-300, Digits::DOUBLE), "1e-300");
        assert_eq!(fixed(4.5, 4), "4.5000");
        assert_eq!(fixed(0.000_012, 4), "0.0000");
        assert_eq!(fixed(12.000_049_9, 4), "12.0000");
        assert_eq!(fixed(9.999_96, 4), "10.0000");
        assert_eq!(fixed(0.0, 4), "0.0000");
    }
}
