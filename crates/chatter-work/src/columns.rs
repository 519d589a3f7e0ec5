//! Answers as columns: names and arrays in memory.

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers.
    Floats(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i64>),
    /// Words of a small vocabulary.
    Words(Vec<&'static str>),
}

/// Values under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The name.
    pub name: String,
    /// The values.
    pub values: Values,
}

impl Column {
    /// Numbers.
    pub fn floats(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            values: Values::Floats(values),
        }
    }

    /// Whole numbers.
    pub fn integers(name: impl Into<String>, values: Vec<i64>) -> Self {
        Self {
            name: name.into(),
            values: Values::Integers(values),
        }
    }

    /// Words.
    pub fn words(name: impl Into<String>, values: Vec<&'static str>) -> Self {
        Self {
            name: name.into(),
            values: Values::Words(values),
        }
    }
}
