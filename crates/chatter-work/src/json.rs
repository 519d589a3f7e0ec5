//! JSON objects that are put together member by member.

use crate::numbers::{Digits, significant};
use chatter::numerics::Real;
use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

/// A JSON value. Numbers that are not finite are null.
#[derive(Clone, Debug, PartialEq)]
pub enum Json {
    /// No value.
    Null,
    /// Yes or no.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
    /// Values in order.
    List(Vec<Json>),
    /// Members in order.
    Object(Object),
}

/// Members in the order in which they were added. Where doubles do not hold the digits asked for, each number has a twin
/// in decimals as text, under its name with `_digits` at the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    digits: Digits,
    members: Vec<(String, Json)>,
}

impl Object {
    /// An object without members.
    pub fn new(digits: Digits) -> Self {
        Self {
            digits,
            members: Vec::new(),
        }
    }

    /// With another member.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Json>) -> Self {
        self.members.push((name.to_owned(), value.into()));
        self
    }

    /// With a number.
    #[must_use]
    pub fn number<R: Real>(self, name: &str, value: R) -> Self {
        let with = self.with(name, value.to_f64());
        with.twin(name, |digits| Json::Text(significant(value, digits)))
    }

    /// With a number or null.
    #[must_use]
    pub fn maybe<R: Real>(self, name: &str, value: Option<R>) -> Self {
        match value {
            Some(value) => self.number(name, value),
            None => self.with(name, Json::Null),
        }
    }

    /// With a list of numbers.
    #[must_use]
    pub fn numbers<R: Real>(self, name: &str, values: &[R]) -> Self {
        let with = self.with(name, list(values, |value| Json::Number(value.to_f64())));
        with.twin(name, |digits| {
            list(values, |value| Json::Text(significant(value, digits)))
        })
    }

    /// With a list of rows of numbers.
    #[must_use]
    pub fn rows<R: Real, V: AsRef<[R]>>(self, name: &str, rows: &[V]) -> Self {
        let numbers = |row: &V| list(row.as_ref(), |value| Json::Number(value.to_f64()));
        let texts =
            |row: &V, digits| list(row.as_ref(), |value| Json::Text(significant(value, digits)));
        let with = self.with(name, Json::List(rows.iter().map(numbers).collect()));
        with.twin(name, |digits| {
            Json::List(rows.iter().map(|row| texts(row, digits)).collect())
        })
    }

    /// With an object of named numbers.
    #[must_use]
    pub fn named<R: Real>(self, name: &str, names: &[&str], values: &[R]) -> Self {
        let object = |value: &dyn Fn(R) -> Json| {
            let mut object = Object::new(self.digits);
            for (name, &number) in names.iter().zip(values) {
                object = object.with(name, value(number));
            }
            Json::Object(object)
        };
        let numbers = object(&|value| Json::Number(value.to_f64()));
        let texts = object(&|value| Json::Text(significant(value, self.digits.0)));
        self.with(name, numbers).twin(name, |_| texts)
    }

    fn twin(self, name: &str, value: impl FnOnce(u32) -> Json) -> Self {
        if self.digits.fit_double() {
            return self;
        }
        let digits = self.digits.0;
        self.with(&format!("{name}_digits"), value(digits))
    }
}

fn list<R: Real>(values: &[R], json: impl Fn(R) -> Json) -> Json {
    Json::List(values.iter().map(|&value| json(value)).collect())
}

impl Json {
    /// Whatever can be written as JSON; members are then in the order of their names.
    pub fn of(value: &impl Serialize) -> Self {
        fn taken(value: serde_json::Value) -> Json {
            match value {
                serde_json::Value::Null => Json::Null,
                serde_json::Value::Bool(value) => Json::Bool(value),
                serde_json::Value::Number(number) => match number.as_i64() {
                    Some(whole) => Json::Integer(whole),
                    None => Json::Number(number.as_f64().unwrap_or(f64::NAN)),
                },
                serde_json::Value::String(text) => Json::Text(text),
                serde_json::Value::Array(values) => {
                    Json::List(values.into_iter().map(taken).collect())
                }
                serde_json::Value::Object(members) => {
                    let object = Object::new(Digits::DOUBLE);
                    let add = |object: Object, (name, value): (String, serde_json::Value)| {
                        object.with(&name, taken(value))
                    };
                    Json::Object(members.into_iter().fold(object, add))
                }
            }
        }
        serde_json::to_value(value).map_or(Self::Null, taken)
    }
}

impl From<f64> for Json {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<i64> for Json {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<&str> for Json {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Json {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<Vec<Json>> for Json {
    fn from(values: Vec<Json>) -> Self {
        Self::List(values)
    }
}

impl From<Object> for Json {
    fn from(object: Object) -> Self {
        Self::Object(object)
    }
}

impl Serialize for Object {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.members.len()))?;
        for (name, value) in &self.members {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Null => serializer.serialize_none(),
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Integer(value) => serializer.serialize_i64(*value),
            Self::Number(value) if value.is_finite() => serializer.serialize_f64(*value),
            Self::Number(_) => serializer.serialize_none(),
            Self::Text(text) => serializer.serialize_str(text),
            Self::List(values) => {
                let mut sequence = serializer.serialize_seq(Some(values.len()))?;
                for value in values {
                    sequence.serialize_element(value)?;
                }
                sequence.end()
            }
            Self::Object(object) => object.serialize(serializer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chatter::numerics::DoubleDouble;

    #[test]
    fn members_keep_their_order_and_have_twins_where_doubles_end() {
        let object = |digits| {
            Object::new(Digits(digits))
                .number("b", DoubleDouble::PI)
                .maybe::<f64>("a", None)
                .with("n", 3)
                .numbers("list", &[0.5, f64::NAN])
        };
        let text = serde_json::to_string(&Json::Object(object(17))).unwrap();
        assert_eq!(
            text,
            r#"{"b":3.141592653589793,"a":null,"n":3,"list":[0.5,null]}"#
        );
        let text = serde_json::to_string(&Json::Object(object(20))).unwrap();
        assert!(text.contains(r#""b_digits":"3.1415926535897932385","a":null"#));
    }
}
