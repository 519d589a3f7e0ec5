//! Plain numbers, to as many digits as are given.

use chatter::numerics::{DoubleDouble, Real};

/// A decimal number. One half of a sum such as `0.05` is not rounded to a double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal(pub DoubleDouble);

impl std::str::FromStr for Decimal {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let expected = || format!("`{text}` is no number: expected one such as 0.8 or 1e-3");
        // What a double cannot read is no number, or not finite; say which.
        let double: f64 = text.parse().map_err(|_| expected())?;
        if !double.is_finite() {
            return Err(format!("`{text}` is not finite"));
        }
        let number = text.parse().unwrap_or_else(|_| DoubleDouble::from(double));
        if number.is_lost_of(text) {
            return Err(format!(
                "`{text}` is too small to be told from zero: sizes down to 5e-324 can be held"
            ));
        }
        Ok(Self(number))
    }
}

impl Decimal {
    /// In the number type of the computation.
    pub fn get<R: Real>(self) -> R {
        R::from_double_double(self.0)
    }

    /// As a double: of what was written, not of a rounded sum.
    pub fn to_f64(self) -> f64 {
        self.0.to_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_with_all_their_digits() {
        let read = |text: &str| text.parse::<Decimal>();
        let tenth = read("0.1").unwrap().0;
        assert_ne!(tenth, DoubleDouble::from(0.1));
        assert_eq!(tenth.to_f64(), 0.1);
        assert!(read("nan").unwrap_err().contains("not finite"));
        assert!(read("1e999").unwrap_err().contains("not finite"));
        assert!(read("-1e-400").unwrap_err().contains("from zero"));
        assert_eq!(read("0.0e-400").unwrap().to_f64(), 0.0);
        assert!(read("1,5").unwrap_err().contains("no number"));
        assert_eq!(read("-2e-5").unwrap().to_f64(), -2e-5);
    }
}
