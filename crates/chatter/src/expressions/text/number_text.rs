//! Numbers as a person would write them.

use crate::numerics::{DoubleDouble, Real, Scalar};

/// The text of a number that is not negative.
#[derive(Clone, PartialEq, Debug)]
pub(in crate::expressions) enum NumberText {
    /// Digits, perhaps with a point and an exponent.
    Decimal(String),
    /// One integer over another, where no short decimal says the same.
    Ratio(i64, i64),
}

/// Relative difference below which a text says the same as the number: folding rounds at about 2^-104 a step.
const DISPLAY_NOISE: f64 = 1.0 / (1_u128 << 99) as f64;

/// Largest denominator and numerator that are tried before giving all digits.
const LARGEST_DENOMINATOR: i64 = 1000;
const LARGEST_NUMERATOR: f64 = 1e6;

/// Digits that a double-double needs to be told from its neighbours.
const FULL_DIGITS: usize = 33;

/// The shortest text that says `value`: all of a double's digits for a double, all 32 for what is none.
pub(in crate::expressions) fn number_text(value: DoubleDouble) -> NumberText {
    let short = shortest(value.to_f64());
    if value.low() == 0.0 || says(&short, value) {
        return NumberText::Decimal(short);
    }
    for denominator in 2..=LARGEST_DENOMINATOR {
        let below = DoubleDouble::from(denominator as f64);
        let above = libm::rint((value * below).to_f64());
        if (1.0..=LARGEST_NUMERATOR).contains(&above)
            && same(DoubleDouble::from(above) / below, value)
        {
            return NumberText::Ratio(above as i64, denominator);
        }
    }
    let all = (17..FULL_DIGITS)
        .map(|decimals| format!("{value:.decimals$}"))
        .find(|text| says(text, value))
        .unwrap_or_else(|| format!("{value:.FULL_DIGITS$}"));
    NumberText::Decimal(all)
}

fn shortest(value: f64) -> String {
    let text = format!("{value:?}");
    match text.strip_suffix(".0") {
        Some(integer) => integer.to_string(),
        None => text,
    }
}

fn says(text: &str, value: DoubleDouble) -> bool {
    text.parse().is_ok_and(|read| same(read, value))
}

fn same(a: DoubleDouble, b: DoubleDouble) -> bool {
    (a - b).abs().to_f64() <= DISPLAY_NOISE * b.abs().to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        let decimal = |text: &str| NumberText::Decimal(text.to_string());
        let read = |text: &str| text.parse::<DoubleDouble>().unwrap();
        let one = DoubleDouble::from(1.0);
        let check = |value: DoubleDouble, expected: NumberText| {
            assert_eq!(number_text(value), expected);
        };
        check(one, decimal("1"));
        check(read("0.1"), decimal("0.1"));
        check(DoubleDouble::from(0.1), decimal("0.1"));
        check(read("0.1") * read("0.3"), decimal("0.03"));
        check(read("1e300"), decimal("1e300"));
        check(read("0.00001"), decimal("1e-5"));
        check(one / read("3"), NumberText::Ratio(1, 3));
        check(read("22") / read("7"), NumberText::Ratio(22, 7));
        check(one / read("1009"), {
            decimal("9.91080277502477700693756194252e-4")
        });
        check(read("0.1234567890123456789012"), {
            decimal("1.234567890123456789012e-1")
        });
    }
}
