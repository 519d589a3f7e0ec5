//! Border orbits.

use crate::errors::{raised, unreadable};
use crate::interruptible::{Listener, interruptible};
use crate::model::Core;
use chatter::analysis::border::BorderSpec;
use chatter::analysis::universal::Argument;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use chatter_work::border::{Place, Question, Subject, document, find};
use chatter_work::numbers::Digits;
use chatter_work::options::{Counts, Precision, Quantity, SectionOption};
use chatter_work::{Observer, Refusal};
use pyo3::prelude::*;
use std::str::FromStr;
use std::sync::Arc;

/// What was asked, but for the digits.
struct Asked {
    model: Arc<Model>,
    source: String,
    question: Question,
    windows: Option<Counts>,
    digits: Digits,
}

/// The document of the border near a value, or of those of a range.
#[pyfunction]
#[pyo3(signature = (core, parameter, *, near=None, range=None, samples=None, excursions=None, section=None, windows=None,
                    digits=17, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn border(
    py: Python<'_>,
    core: &Core,
    parameter: &str,
    near: Option<String>,
    range: Option<(String, String)>,
    samples: Option<usize>,
    excursions: Option<usize>,
    section: Option<String>,
    windows: Option<(i64, i64)>,
    digits: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let digits = Precision::from_str(&digits.to_string())
        .map_err(|error| unreadable("digits", error))?
        .0;
    let mut model = (*core.model).clone();
    let mut spec = BorderSpec::new(parameter);
    if let Some(samples) = samples {
        spec.samples = samples;
    }
    if let Some(excursions) = excursions {
        spec.excursions = excursions;
    }
    if let Some(section) = section {
        let section = SectionOption::from_str(&section);
        let section = section.map_err(|error| unreadable("section", error))?;
        spec.section = Some(section.section(&mut model).map_err(raised)?);
    }
    let mut number = |text: String, what: &str| Quantity(text).value(&mut model, what);
    let place = match (near, range) {
        (Some(near), None) => Place::Near(number(near, "--near").map_err(raised)?.to_f64()),
        (None, Some((low, high))) => {
            let low = number(low, "--range").map_err(raised)?.to_f64();
            Place::Range(low, number(high, "--range").map_err(raised)?.to_f64())
        }
        _ => {
            let message = "expected --near or --range, one of them";
            return Err(raised(Refusal::input(message)));
        }
    };
    if let Some((first, last)) = windows
        && (first < 0 || last < first)
    {
        let message = format!("--windows {first} to {last}: expected 0 <= first <= last");
        return Err(raised(Refusal::input(message)));
    }
    let asked = Asked {
        model: Arc::clone(&core.model),
        source: core.name.clone(),
        question: Question { spec, place },
        windows: windows.map(|(first, last)| Counts { first, last }),
        digits,
    };
    let found = interruptible(py, progress, move |listener| {
        if asked.digits.fit_double() {
            answer::<f64>(&asked, listener)
        } else {
            answer::<DoubleDouble>(&asked, listener)
        }
    })?;
    found.map_err(raised)
}

fn answer<R: Real + Argument<Real = R>>(
    asked: &Asked,
    listener: &Listener,
) -> Result<String, Refusal> {
    let (model, spec) = (&*asked.model, &asked.question.spec);
    let subject = Subject {
        model,
        source: &asked.source,
        parameter: &spec.parameter,
        digits: asked.digits,
        text_digits: asked.digits,
        samples: spec.samples,
        excursions: spec.excursions,
        windows: asked.windows,
    };
    let found = find::<R>(&subject, &asked.question, listener)?;
    if listener.going_on().is_break() {
        return Err(Refusal::Interrupted);
    }
    let document = document(&subject, &found);
    serde_json::to_string(&document).map_err(|error| Refusal::Output(error.to_string()))
}
