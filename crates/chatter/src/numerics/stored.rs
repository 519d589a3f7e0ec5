//! Double-double numbers in stored specifications and results: a plain number where that is exact, else the pair of its
//! parts, so that reading gives back every bit.

use super::DoubleDouble;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

impl Serialize for DoubleDouble {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.low() == 0.0 {
            self.high().serialize(serializer)
        } else {
            [self.high(), self.low()].serialize(serializer)
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Stored {
    Double(f64),
    Parts([f64; 2]),
}

impl<'de> Deserialize<'de> for DoubleDouble {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Stored::deserialize(deserializer)? {
            Stored::Double(value) => Ok(Self::from(value)),
            Stored::Parts([high, low]) => {
                let value = Self::sum(high, low);
                if value.high() == high {
                    Ok(value)
                } else {
                    Err(D::Error::custom(format!(
                        "{high} and {low} are no double-double number: the second must be a rounding remainder"
                    )))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Scalar;

    #[test]
    fn storing_keeps_every_bit() {
        for value in [
            DoubleDouble::PI,
            DoubleDouble::from(0.1),
            -DoubleDouble::PI.sqrt(),
        ] {
            let text = serde_json::to_string(&value).unwrap();
            assert_eq!(serde_json::from_str::<DoubleDouble>(&text).unwrap(), value);
        }
        assert!(serde_json::from_str::<DoubleDouble>("[1.0, 1.0]").is_err());
    }
}
