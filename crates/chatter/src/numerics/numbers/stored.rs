//! Numbers in stored specifications and results, so that reading gives back every bit. A double-double number is a plain one
//! where that is exact, else the pair of its parts; a double that is not finite, for which JSON has no number, is a word.

use super::super::{Complex, DoubleDouble};
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

/// A double, finite or not.
#[derive(Clone, Copy)]
struct Any(f64);

impl Serialize for Any {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() {
            self.0.serialize(serializer)
        } else {
            // What Rust writes for it, it reads.
            self.0.to_string().serialize(serializer)
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Word(String),
}

impl<'de> Deserialize<'de> for Any {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::Number(value) => Ok(Self(value)),
            Written::Word(word) => word.parse().map(Self).map_err(D::Error::custom),
        }
    }
}

/// A field that is a double.
pub(crate) mod number {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Any(*value).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Any::deserialize(deserializer).map(|value| value.0)
    }
}

/// A field that is a list of doubles.
pub(crate) mod list {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(
        values: &[f64],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().copied().map(Any))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<f64>, D::Error> {
        let values = Vec::<Any>::deserialize(deserializer)?;
        Ok(values.into_iter().map(|value| value.0).collect())
    }
}

/// A field that is a list of complex numbers: real and imaginary parts in turn.
pub(crate) mod pairs {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(
        values: &[Complex],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let parts: Vec<f64> = values.iter().flat_map(|z| [z.re, z.im]).collect();
        list::serialize(&parts, serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<Complex>, D::Error> {
        let parts = list::deserialize(deserializer)?;
        let (pairs, rest) = parts.as_chunks();
        if !rest.is_empty() {
            return Err(D::Error::custom("a real part without an imaginary one"));
        }
        Ok(pairs.iter().map(|&[re, im]| Complex { re, im }).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Scalar;

    #[test]
    fn doubles_come_back_as_they_were() {
        #[derive(Serialize, Deserialize)]
        struct Kept {
            #[serde(with = "number")]
            one: f64,
            #[serde(with = "list")]
            many: Vec<f64>,
            #[serde(with = "pairs")]
            complex: Vec<Complex>,
        }
        let (re, im) = (f64::NAN, -0.1);
        let kept = Kept {
            one: f64::NEG_INFINITY,
            many: vec![-0.0, 0.1, 5e-324, f64::INFINITY, 1.0, f64::MAX],
            complex: vec![Complex { re, im }],
        };
        let text = serde_json::to_string(&kept).unwrap();
        let back: Kept = serde_json::from_str(&text).unwrap();
        assert_eq!(back.one, kept.one);
        let bits = |values: &[f64]| -> Vec<u64> { values.iter().map(|x| x.to_bits()).collect() };
        assert_eq!(bits(&back.many), bits(&kept.many), "{text}");
        assert!(back.complex[0].re.is_nan() && back.complex[0].im == im);
        let short = text.replace("\"NaN\",", "");
        assert!(serde_json::from_str::<Kept>(&short).is_err());
    }

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
