//! Periodic orbits and their branches, as documents.

use crate::errors::{raised, unreadable};
use crate::interruptible::interruptible;
use crate::model::Core;
use chatter::analysis::periodic::{
    Beside, Branch, BranchSpec, End, Known, Limits, Point, Search, SpecialKind, all,
    branches as follow, settled, special_curve,
};
use chatter::model::Model;
use chatter_work::numbers::Digits;
use chatter_work::options::{Precision, Quantity};
use chatter_work::periodic::{
    IMPACTS, POINTS, STEP, Subject, branch_document, curves_document, free_parameter,
    orbit_document, refused, specification,
};
use chatter_work::{Observer, Refusal};
use pyo3::prelude::*;
use std::str::FromStr;
use std::sync::Arc;

fn subject<'a>(core: &'a (Arc<Model>, String), free: Vec<usize>, digits: Digits) -> Subject<'a> {
    Subject {
        model: &core.0,
        source: &core.1,
        text: "",
        monitors: &[],
        free,
        digits,
    }
}

fn written(document: &impl serde::Serialize) -> Result<String, Refusal> {
    serde_json::to_string(document).map_err(|error| Refusal::Output(error.to_string()))
}

/// The document of the orbit that the motion settles to, or of all that are found from `starts` starts.
#[pyfunction]
#[pyo3(signature = (core, *, period=None, section=None, periods=None, starts=200, seed=0, digits=17, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn orbit(
    py: Python<'_>,
    core: &Core,
    period: Option<String>,
    section: Option<String>,
    periods: Option<usize>,
    starts: u64,
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
        let orbits = match periods {
            None => settled(&model, &spec, &mut |_| listener.going_on()).map(|orbit| vec![orbit]),
            Some(periods) => {
                let what = Search {
                    periods,
                    starts,
                    seed,
                };
                all(&model, &spec, &what, &mut |reached| {
                    let done = reached.starts as f64 / starts as f64;
                    listener.progress(done, &|| format!("{} orbits", reached.orbits));
                    listener.going_on()
                })
            }
        };
        let orbits = orbits.map_err(|error| refused(&error, &model))?;
        let subject = subject(&about, Vec::new(), digits);
        written(&orbit_document(&subject, &orbits, periods.is_some())?)
    })?;
    found.map_err(raised)
}

/// The document of the branches of periodic orbits over a range of a parameter.
#[pyfunction]
#[pyo3(signature = (core, parameter, low, high, *, period=None, section=None, doublings=0, branch_points=0, impacts=IMPACTS,
                    points=POINTS, step=STEP, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn branches(
    py: Python<'_>,
    core: &Core,
    parameter: String,
    low: String,
    high: String,
    period: Option<String>,
    section: Option<String>,
    doublings: usize,
    branch_points: usize,
    impacts: u64,
    points: u64,
    step: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    check_step(step)?;
    let about = (Arc::clone(&core.model), core.name.clone());
    let found = interruptible(py, progress, move |listener| {
        let mut model = (*about.0).clone();
        let spec = specification(&mut model, period.as_deref(), (section.as_deref(), &[]))?;
        let parameter = free_parameter(&model, &parameter)?;
        let limits = limits(&mut model, (low, high), impacts, points, step)?;
        let range = limits.range;
        let what = BranchSpec {
            parameter,
            limits,
            beside: Beside {
                doublings,
                branch_points,
            },
        };
        let found = follow(&model, &spec, &what, &mut |point: Option<&Point>| {
            if let Some(at) = point.map(Point::parameter) {
                let done = ((at - range.0) / (range.1 - range.0)).clamp(0.0, 1.0);
                listener.progress(done, &|| format!("{at}"));
            }
            listener.going_on()
        });
        let found = found.map_err(|error| refused(&error, &model))?;
        if (found.iter()).any(|branch| branch.ends.contains(&End::Interrupted)) {
            return Err(Refusal::Interrupted);
        }
        written(&branch_document(
            &subject(&about, vec![parameter], Digits::DOUBLE),
            &found,
        ))
    })?;
    found.map_err(raised)
}

/// The document of the curve of a special point in two parameters: the first, which is left free, and the second, which is
/// followed over a range. The model is at the values of the point; `state` has all its states in order.
#[pyfunction]
#[pyo3(signature = (core, kind, state, orbit_period, parameters, low, high, *, period=None, section=None, impacts=IMPACTS,
                    points=POINTS, step=STEP, progress=None))]
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
    impacts: u64,
    points: u64,
    step: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    check_step(step)?;
    let mut kinds = SpecialKind::ALL.into_iter();
    let kind = kinds.find(|known| known.name() == kind);
    let kind =
        kind.ok_or_else(|| unreadable("kind", "no special point is called so".to_owned()))?;
    let known = Known {
        kind,
        monitor: None,
        state,
        period: orbit_period,
    };
    let about = (Arc::clone(&core.model), core.name.clone());
    let found = interruptible(py, progress, move |listener| {
        let mut model = (*about.0).clone();
        let spec = specification(&mut model, period.as_deref(), (section.as_deref(), &[]))?;
        let free = [
            free_parameter(&model, &parameters.0)?,
            free_parameter(&model, &parameters.1)?,
        ];
        if free[0] == free[1] {
            let message = format!("`{}` is named twice: expected two parameters", parameters.0);
            return Err(Refusal::input(message));
        }
        let limits = limits(&mut model, (low, high), impacts, points, step)?;
        let (low, high) = limits.range;
        let curve = special_curve(&model, &spec, (free, &known), &limits, &mut |point| {
            let at = point.parameter();
            listener.progress(((at - low) / (high - low)).clamp(0.0, 1.0), &|| {
                format!("{at}")
            });
            listener.going_on()
        });
        let curve = curve.map_err(|error| refused(&error, &model))?;
        if curve.ends.contains(&End::Interrupted) {
            return Err(Refusal::Interrupted);
        }
        let branch = Branch {
            points: curve.points,
            special: curve.special,
            ends: curve.ends,
        };
        let subject = subject(&about, free.to_vec(), Digits::DOUBLE);
        written(&curves_document(&subject, &[(kind, branch)]))
    })?;
    found.map_err(raised)
}

fn check_step(step: f64) -> PyResult<()> {
    if step > 0.0 && step <= 1.0 {
        return Ok(());
    }
    Err(unreadable(
        "step",
        format!("{step} is no part of the range, above 0 and at most 1"),
    ))
}

fn limits(
    model: &mut Model,
    (low, high): (String, String),
    impacts: u64,
    points: u64,
    longest_step: f64,
) -> Result<Limits, Refusal> {
    let mut end = |text: String| Quantity(text).value(model, "--sweep");
    Ok(Limits {
        range: (end(low)?.high(), end(high)?.high()),
        impacts,
        points: usize::try_from(points).unwrap_or(usize::MAX),
        longest_step,
    })
}
