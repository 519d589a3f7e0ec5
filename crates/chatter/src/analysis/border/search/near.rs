//! The border nearest to a value of the parameter.

use super::super::coordinate::Verdict;
use super::super::error::{BorderError, Break};
use super::super::orbit::{Border, complete};
use super::super::problem::Problem;
use super::super::spec::BorderSpec;
use super::closing_in::Found;
use super::samples::{Sample, unwatched};
use crate::model::Model;
use crate::numerics::Real;
use core::ops::ControlFlow;

/// `parts` + 1 values from `low` to `high`.
fn even(low: f64, high: f64, parts: usize) -> Vec<f64> {
    let parts = parts.max(1);
    (0..=parts)
        .map(|i| low + (high - low) * (i as f64 / parts as f64))
        .collect()
}

/// The verdicts that [`borders_in`](super::super::borders_in) starts from: at `spec.samples` + 1 parameter values from `low` to `high`, a list for
/// each release point.
///
/// # Errors
/// As for [`borders_in`](super::super::borders_in).
pub fn verdicts_in(
    model: &Model,
    spec: &BorderSpec,
    low: f64,
    high: f64,
) -> Result<Vec<Vec<(f64, Verdict)>>, BorderError> {
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Err(BorderError::Range { low, high });
    }
    let problem = Problem::new(model, spec)?;
    let branches = problem.scan(&even(low, high, spec.samples), &mut unwatched)?;
    let branches = branches.unwrap_or_default();
    let verdicts = |samples: &Vec<Sample>| samples.iter().map(|s| (s.value, s.verdict)).collect();
    Ok(branches.iter().map(verdicts).collect())
}

/// Distances from the value asked for are searched by stretches, each twice as long as the one before, to as much as the
/// value itself.
const STRETCHES: u32 = 8;

/// Parts of each stretch on either side.
const STRETCH_SAMPLES: usize = 12;

/// Where the value asked for is zero, the last stretch ends here.
const UNIT: f64 = 1.0;

/// Values from 0 to 1, the denser the nearer to 0.
fn graded() -> Vec<f64> {
    let mut values = vec![0.0];
    for stretch in 0..=STRETCHES {
        let end = 1.0 / f64::from(1 << (STRETCHES - stretch));
        let begin = if stretch == 0 { 0.0 } else { end * 0.5 };
        values.extend_from_slice(&even(begin, end, STRETCH_SAMPLES)[1..]);
    }
    values
}

/// The border nearest to a parameter value: of those between half of it and twice as much, around zero of those from -1
/// to 1.
///
/// # Errors
/// [`BorderError::NoBorder`] if there is none, else as for [`borders_in`](super::super::borders_in).
pub fn border_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
) -> Result<Border<R>, BorderError> {
    let found = search_near(model, spec, value, &mut unwatched)?;
    Ok(found.expect("nobody breaks off what is unwatched"))
}

/// Like [`border_near`], with a watcher that hears what part of the search is done and may break it off; nothing is found
/// then.
///
/// # Errors
/// As for [`border_near`].
pub fn search_near<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: f64,
    watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Option<Border<R>>, BorderError> {
    if !value.is_finite() {
        return Err(BorderError::Range {
            low: value,
            high: value,
        });
    }
    let problem = Problem::new(model, spec)?;
    let (low, high) = match value {
        0.0 => (-UNIT, UNIT),
        _ if value > 0.0 => (value * 0.5, value * 2.0),
        _ => (value * 2.0, value * 0.5),
    };
    let towards = |end: f64| graded().into_iter().map(move |g| value + (end - value) * g);
    let mut values: Vec<f64> = towards(low).collect();
    values.reverse();
    values.extend(towards(high).skip(1));
    let Some(samples) = problem.scan(&values, watch)? else {
        return Ok(None);
    };
    let changes = problem.changes(&samples, spec.extrapolation);
    let nearest = changes.nearest(value, |root, breaks| {
        if !(low..=high).contains(&root.point.value) {
            return Ok(None);
        }
        Ok(match complete(&problem, spec, root)? {
            Ok(border) => Some(border),
            Err(cause) => {
                breaks.push(Break {
                    value: root.point.value,
                    cause,
                });
                None
            }
        })
    })?;
    let breaks = match nearest {
        Ok(border) => return Ok(Some(border)),
        Err(Found { breaks, .. }) => breaks,
    };
    Err(BorderError::NoBorder { low, high, breaks })
}
