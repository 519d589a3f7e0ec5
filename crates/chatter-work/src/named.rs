//! Values by name, in an order of their own.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// A JSON object whose members keep their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T>(pub Vec<(String, T)>);

impl<T> Named<T> {
    /// Pairs names with values.
    pub fn new<'a>(
        names: impl IntoIterator<Item = &'a str>,
        values: impl IntoIterator<Item = T>,
    ) -> Self {
        Self(names.into_iter().map(str::to_owned).zip(values).collect())
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}
