//! Periodic orbits and curves of special points, as documents.

use crate::errors::{raised, unreadable};
use crate::interruptible::interruptible;
use crate::model::Core;
use chatter::analysis::periodic::{End, Known, Record, SpecialKind};
use chatter::model::Model;
use chatter_work::Refusal;
use chatter_work::numbers::Digits;
use chatter_work::options::{Precision, Quantity};
use chatter_work::periodic::{
    Curve, Orbits, Reach, Subject, curves_document, find_curve, find_orbits, free_parameter,
    orbit_document, search, specification,
};
use pyo3::prelude::*;
use std::str::FromStr;
use std::sync::Arc;

fn subject<'a>(
    core: &'a (Arc<Model>, String),
    monitors: &'a [String],
    free: Vec<usize>,
    digits: Digits,
) -> Subject<'a> {
    Subject {
        model: &core.0,
        source: &core.1,
        text: "",
        monitors,
        free,
        digits,
    }
}

pub fn written(document: &impl serde::Serialize) -> Result<String, Refusal> {
    serde_json::to_string(document).map_err(|error| Refusal::Output(error.to_string()))
}

/// The document of the orbit that the motion settles to, or of all that are found from `starts` starts.
#[pyfunction]
#[pyo3(signature = (core, *, period=None, section=None, periods=None, starts=None, seed=0, digits=17, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn orbit(
    py: Python<'_>,
    core: &Core,
    period: Option<String>,
    section: Option<String>,
    periods: Option<u64>,
    starts: Option<u64>,
    seed: u64,
    digits: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let digits = Precision::from_str(&digits.to_string());
    let digits = digits.map_err(|error| unreadable("digits", error))?.0;
    let about = (Arc::clone(&core.model), core.name.clone());
    let found = interruptible(py, progress, move |listener| {
        let mut model = (*about.0).clone();
        let spec = specification(&mut model, period.as_deref(), (section.as_deref(), &[]))?;
        let search = match periods {
            Some(periods) => Some(search(periods, starts, Some(seed))?),
            None => None,
        };
        let orbits = find_orbits(&model, &Orbits { spec, search }, listener)?;
        let subject = subject(&about, &[], Vec::new(), digits);
        written(&orbit_document(&subject, &orbits, periods.is_some())?)
    })?;
    found.map_err(raised)
}

/// The document of the curve of a special point in two parameters: the first, which is left free, and the second, which is
/// followed over a range. The model is at the values of the point; `state` has all its states in order; of a zero of a function
/// of the user's `monitor` is that function.
#[pyfunction]
#[pyo3(signature = (core, kind, state, orbit_period, parameters, low, high, *, period=None, section=None, monitor=None,
                    impacts=None, points=None, step=None, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn curve(
    py: Python<'_>,
    core: &Core,
    kind: &str,
    state: Vec<f64>,
    orbit_period: f64,
    parameters: (String, String),
    low: String,
    high: String,
    period: Option<String>,
    section: Option<String>,
    monitor: Option<String>,
    impacts: Option<u64>,
    points: Option<u64>,
    step: Option<f64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let reach = Reach {
        impacts,
        points,
        step,
    };
    let kind = SpecialKind::named(kind)
        .ok_or_else(|| unreadable("kind", "no special point is called so".to_owned()))?;
    let known = Known {
        kind,
        monitor: monitor.as_ref().map(|_| 0),
        state,
        period: orbit_period,
    };
    let about = (Arc::clone(&core.model), core.name.clone());
    let found = interruptible(py, progress, move |listener| {
        let mut model = (*about.0).clone();
        let monitors: Vec<String> = monitor.into_iter().collect();
        let spec = specification(
            &mut model,
            period.as_deref(),
            (section.as_deref(), &monitors),
        )?;
        let free = [
            free_parameter(&model, &parameters.0)?,
            free_parameter(&model, &parameters.1)?,
        ];
        if free[0] == free[1] {
            let message = format!("`{}` is named twice: expected two parameters", parameters.0);
            return Err(Refusal::input(message));
        }
        let wanted = Curve {
            spec,
            free,
            known,
            limits: reach.over(ends(&mut model, (low, high))?)?,
        };
        let mut keep = |_: &Record| Ok(());
        let curve = find_curve(&model, &wanted, (Vec::new(), &mut keep), listener)?;
        if curve.1.ends.contains(&End::Interrupted) {
            return Err(Refusal::Interrupted);
        }
        let subject = subject(&about, &monitors, free.to_vec(), Digits::DOUBLE);
        written(&curves_document(&subject, &[curve]))
    })?;
    found.map_err(raised)
}

fn ends(model: &mut Model, (low, high): (String, String)) -> Result<(f64, f64), Refusal> {
    let mut end = |text: String| Quantity(text).value(model, "--sweep");
    Ok((end(low)?.high(), end(high)?.high()))
}
