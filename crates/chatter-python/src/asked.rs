//! What is asked, from a dictionary.

use crate::errors::unreadable;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::str::FromStr;

/// What a text or number means, by its name in the dictionary of what is asked.
pub struct Asked<'a, 'py>(pub &'a Bound<'py, PyDict>);

impl<'py> Asked<'_, 'py> {
    /// What was given, as what it is.
    pub fn get<T: for<'a> FromPyObject<'a, 'py, Error = PyErr>>(
        &self,
        name: &str,
    ) -> PyResult<Option<T>> {
        match self.0.get_item(name)? {
            Some(value) if !value.is_none() => value.extract().map(Some),
            _ => Ok(None),
        }
    }

    /// Each of some texts.
    pub fn texts<T: FromStr<Err: ToString>>(&self, name: &str) -> PyResult<Vec<T>> {
        let texts: Vec<String> = self.get(name)?.unwrap_or_default();
        let read = |text: &String| {
            text.parse()
                .map_err(|error: T::Err| unreadable(name, error.to_string()))
        };
        texts.iter().map(read).collect()
    }

    /// A text.
    pub fn text<T: FromStr<Err: ToString>>(&self, name: &str) -> PyResult<Option<T>> {
        let text: Option<String> = self.get(name)?;
        let read = |text: String| {
            text.parse()
                .map_err(|error: T::Err| unreadable(name, error.to_string()))
        };
        text.map(read).transpose()
    }
}
