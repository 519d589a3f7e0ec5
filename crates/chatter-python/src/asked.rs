//! What is asked, from a dictionary.

use crate::errors::{raised, unreadable};
use chatter_files::Format;
use chatter_work::Refusal;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
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

    /// The table that is to be written: one of a known format, before anything is begun for it.
    pub fn table(&self) -> PyResult<Option<PathBuf>> {
        let out: Option<PathBuf> = self.get("out")?;
        if let Some(path) = &out {
            Format::of_table(path).map_err(|error| raised(Refusal::input(error)))?;
        }
        Ok(out)
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
