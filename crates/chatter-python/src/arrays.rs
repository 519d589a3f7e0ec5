//! Columns as NumPy arrays, without a copy.

use chatter_work::columns::{Column, Values};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// An array.
pub fn floats(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyAny> {
    PyArray1::from_vec(py, values).into_any()
}

/// So many rows of equal length, one after the other, as an array of two dimensions.
pub fn matrix<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let array = PyArray1::from_vec(py, values);
    Ok(array.reshape([rows, columns])?.into_any())
}

/// Columns by name, in order.
pub fn columns<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = Column>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for column in columns {
        let values = match column.values {
            Values::Floats(values) => floats(py, values),
            Values::Integers(values) => PyArray1::from_vec(py, values).into_any(),
            Values::Words(words) => PyList::new(py, words)?.into_any(),
        };
        dict.set_item(column.name, values)?;
    }
    Ok(dict)
}
