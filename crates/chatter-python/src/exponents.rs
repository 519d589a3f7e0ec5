//! Lyapunov exponents, as a document.

use crate::errors::{raised, unreadable};
use crate::interruptible::interruptible;
use crate::model::Core;
use chatter_work::exponents::{Request, document, find};
use chatter_work::options::{Count, Quantity};
use chatter_work::{Observer, Refusal};
use pyo3::prelude::*;
use std::str::FromStr;
use std::sync::Arc;

/// The document of all exponents.
#[pyfunction]
#[pyo3(signature = (core, *, interval=None, transient=None, intervals=None, progress=None))]
pub fn exponents(
    py: Python<'_>,
    core: &Core,
    interval: Option<String>,
    transient: Option<String>,
    intervals: Option<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let count = |name: &str, text: Option<String>| -> PyResult<Option<Count>> {
        let count = text.map(|text| Count::from_str(&text)).transpose();
        count.map_err(|error| unreadable(name, error))
    };
    let request = Request {
        interval: interval.map(Quantity),
        transient: count("transient", transient)?,
        intervals: count("intervals", intervals)?,
    };
    let (model, source) = (Arc::clone(&core.model), core.name.clone());
    let found = interruptible(py, progress, move |listener| {
        let mut model = (*model).clone();
        model.check_defined()?;
        let spec = request.spec(&mut model)?;
        let found = find(&model, &spec, listener)?;
        if listener.going_on().is_break() {
            return Err(Refusal::Interrupted);
        }
        let document = document(&model, &source, &spec, &found);
        serde_json::to_string(&document).map_err(|error| Refusal::Output(error.to_string()))
    })?;
    found.map_err(raised)
}
