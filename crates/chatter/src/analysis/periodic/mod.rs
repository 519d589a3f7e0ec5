//! Periodic orbits, stable or not, through impacts, complete chatter, contact and release.
//!
//! ```text
//! cycle/       what is read off the motion
//!   trace      a trajectory as instants and the modes between them
//!   settle     the latest return of a trajectory to where it was: a cycle, nearly closed
//!   events     what happens at one instant
//!   itinerary  the cycle as legs of smooth flow, and stretches that are followed through complete chatter
//! closure      what a state is after one period: the same, but for turns of phases and distance covered
//! shooting/    the equations of an itinerary: nodes after events and the times between them
//!   workshop   a model with its compiled legs
//!   equations  residual and Jacobian
//!   monodromy  multipliers
//!   along      what there is to see on the way of an orbit
//! special_curve  special points in two parameters
//! crossing     where an orbit crosses the section, which is no part of its equations
//! condition    what is held at zero at special points and along their curves
//! solved       solutions with that, and how well they are known
//! multipliers  functions that change their sign where something happens to an orbit
//! aside        orbits beside one whose equations are singular: once or twice around
//! search       all that Newton's method finds from many starts
//! distinct     of branches from several orbits, each once
//! arc          orbits with one number of impacts, and what ends the stable ones of them
//! diary        what a survey tells of, and what it goes on from
//! survey       a branch with those beyond its borders, and those that leave it
//! branch       orbits over a parameter, from one sequence of events to the next
//! orbit        Newton's solution in double-double; multipliers
//! margins      how near it is to losing its sequence of events
//! ```

pub(in crate::analysis) mod arc;
mod aside;
mod branch;
pub(in crate::analysis) mod closure;
mod condition;
mod crossing;
mod cycle;
mod diary;
mod distinct;
mod error;
mod margins;
mod multipliers;
mod orbit;
mod search;
pub(in crate::analysis) mod shooting;
mod solved;
mod special_curve;
mod survey;

pub use branch::{
    Branch, End, Growth, Law, Limits, Point, Record, Saddle, Shrunk, Special, SpecialKind,
    Unbounded,
};
pub use cycle::settle::Patience;
pub use diary::Told;
pub use distinct::{Distinct, Start};
pub use error::PeriodicError;
pub use margins::{Margin, MarginKind};
pub use orbit::Orbit;
pub use search::{Search, Searched};
pub use special_curve::{Known, SpecialCurve};
pub use survey::Beside;

use crate::model::Model;
use closure::Closure;
use core::ops::ControlFlow;
use diary::Diary;
use serde::{Deserialize, Serialize};
use shooting::Workshop;
use std::sync::Arc;

/// Which periodic orbit is asked for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Spec {
    /// Period of the forcing, an expression in parameters, where the equations do not tell it.
    pub period: Option<String>,
    /// The section at which states are told, by its position in the model; where it is not crossed, and without it, just
    /// after an event.
    pub section: Option<usize>,
    /// Functions of the state that orbits are told from, and of parameters, whose zeros are special points: expressions.
    pub monitors: Vec<String>,
    /// How long the trajectory may take to settle.
    pub patience: Patience,
    /// The orbit that a branch is followed from, at the model's value of the parameter: a state on it, and its period. Without
    /// it the one that the motion settles to.
    pub through: Option<(Vec<f64>, f64)>,
}

/// A model with these free parameters, and what is asked of its orbits.
pub(in crate::analysis) fn workshop(
    model: &Model,
    spec: &Spec,
    (free, sizes): (&[usize], &[f64]),
) -> Result<Arc<Workshop>, PeriodicError> {
    let mut model = model.with_telling_numbers(free);
    let given = match &spec.period {
        Some(text) => {
            let expr = (model.parse_expression(text)).map_err(|_| PeriodicError::NoPeriod)?;
            let parameters = model.parameter_values::<f64>(&[]);
            let value = model.graph.evaluate(expr, &[], &parameters);
            if !(value > 0.0 && value.is_finite()) {
                return Err(PeriodicError::BadPeriod { value });
            }
            Some(expr)
        }
        None => None,
    };
    let mut monitors = Vec::new();
    for text in &spec.monitors {
        let parsed = model.parse_expression(text);
        let what = |_| PeriodicError::BadMonitor { text: text.clone() };
        let value = parsed.map_err(what)?;
        if model.graph.symbols(value).is_empty() {
            return Err(PeriodicError::ConstantMonitor { text: text.clone() });
        }
        monitors.push(value);
    }
    let sections = &model.sections;
    let plain = |index: &usize| sections.get(*index).is_some_and(|s| s.reset.is_none());
    let section = spec
        .section
        .or_else(|| (0..sections.len()).find(plain))
        .filter(plain);
    let (closure, section) = Closure::with_section(&model, free, given, section)?;
    let workshop = Workshop::new(&model, (free, sizes), closure, (section, &monitors))?;
    Ok(Arc::new(workshop))
}

/// The period of a model's forcing, as its equations tell it: of time, or of a phase that turns by itself.
pub fn forcing(model: &Model) -> Option<f64> {
    let (closure, _) = Closure::with_section(model, &[], None, None).ok()?;
    closure.forcing(&model.parameter_values(&[]))
}

/// The orbit that the trajectory from the model's initial state settles to; in chaos, where it settles to none, an unstable one that it
/// comes near to, of a single period if there is one. The observer hears of the time that it has come to.
///
/// # Errors
/// There is none, or none was found.
pub fn settled(
    model: &Model,
    spec: &Spec,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Orbit, PeriodicError> {
    let workshop = workshop(model, spec, (&[], &[]))?;
    let parameters = model.parameter_values::<f64>(&[]);
    let state = model.initial_state(&parameters);
    let found = orbit::settled(&workshop, &[], &state, spec.patience, observer);
    search::simplest(&workshop, found, &state, &[]).map(orbit::as_told)
}

/// All periodic orbits found from many starts, those of short period first.
///
/// # Errors
/// Nothing tells where a period begins, or the observer broke off.
pub fn all(
    model: &Model,
    spec: &Spec,
    what: &Search,
    observer: &mut dyn FnMut(Searched) -> ControlFlow<()>,
) -> Result<Vec<Orbit>, PeriodicError> {
    let workshop = workshop(model, spec, (&[], &[]))?;
    let parameters = model.parameter_values::<f64>(&[]);
    let state = model.initial_state(&parameters);
    search::search(&workshop, &state, what, observer)
}

/// Where branches of periodic orbits are looked for.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct BranchSpec {
    /// Position of the parameter that is varied.
    pub parameter: usize,
    /// Within what branches are followed.
    pub limits: Limits,
    /// What else than the first branch is followed.
    pub beside: Beside,
}

/// The branch through the orbit that the trajectory from the model's initial state settles to, those beyond the borders at
/// its ends, and others that leave it. Where nothing settles at the model's value of the parameter, others are tried. With the
/// records `before` of a survey of the same that was broken off it goes on from there; the result is the same, to the bit.
///
/// # Errors
/// There is no such orbit, none was found, or the records are of another survey.
pub fn branches(
    model: &Model,
    spec: &Spec,
    what: &BranchSpec,
    before: Vec<Record>,
    observer: &mut dyn FnMut(Told<'_>) -> ControlFlow<()>,
) -> Result<Vec<Branch>, PeriodicError> {
    let mut diary = Diary::new(before, observer);
    let (low, high) = what.limits.range;
    let workshop = workshop(model, spec, (&[what.parameter], &[high - low]))?;
    let own = model.parameter_values::<f64>(&[])[what.parameter];
    if let Some((state, period)) = &spec.through {
        let cycle = cycle::reread::reread(&workshop, &[own], (state, *period))?;
        let orbit = orbit::close(&workshop, cycle, &[own])?;
        return survey::survey(
            &workshop,
            (&orbit.shooting, &orbit.at),
            (&what.limits, what.beside),
            (state, spec.patience),
            &mut diary,
        );
    }
    let inside = (low..=high).contains(&own).then_some(own);
    let others = STARTS.iter().map(|part| low + part * (high - low));
    let mut failed = None;
    for here in inside.into_iter().chain(others) {
        let parameters = model.parameter_values::<f64>(&[(what.parameter, here)]);
        let state = model.initial_state(&parameters);
        let mut settling = |_: f64| diary.tell(Told::Settling);
        let found = orbit::settled(&workshop, &[here], &state, spec.patience, &mut settling);
        let orbit = match search::simplest(&workshop, found, &state, &[here]) {
            Ok(orbit) => orbit,
            Err(PeriodicError::Interrupted) => return Err(PeriodicError::Interrupted),
            Err(error) => {
                failed.get_or_insert(error);
                continue;
            }
        };
        if let (Some(own), Some(why)) = (inside, &failed) {
            let elsewhere = Told::Elsewhere { own, at: here, why };
            if diary.tell(elsewhere).is_break() {
                return Err(PeriodicError::Interrupted);
            }
        }
        return survey::survey(
            &workshop,
            (&orbit.shooting, &orbit.at),
            (&what.limits, what.beside),
            (&state, spec.patience),
            &mut diary,
        );
    }
    Err(failed.unwrap_or(PeriodicError::Interrupted))
}

/// The curve of a special point in two parameters.
///
/// `free` are the positions of both, the second of which is varied over `limits`' range; the model has their values at the
/// point. With the records `before` of a curve of the same that was broken off it goes on from there; the result is the same,
/// to the bit.
///
/// # Errors
/// The point cannot be found again, or is of a kind that has no curve.
pub fn special_curve(
    model: &Model,
    spec: &Spec,
    (free, known): ([usize; 2], &Known),
    limits: &Limits,
    before: Vec<Record>,
    observer: &mut dyn FnMut(Told<'_>) -> ControlFlow<()>,
) -> Result<SpecialCurve, PeriodicError> {
    let mut diary = Diary::new(before, observer);
    let parameters = model.parameter_values::<f64>(&[]);
    let values = free.map(|index| parameters[index]);
    let (low, high) = limits.range;
    let slack = EDGE * (high - low);
    if !(low - slack..=high + slack).contains(&values[1]) {
        return Err(PeriodicError::OutOfRange {
            value: values[1],
            range: limits.range,
        });
    }
    if let Some(range) = limits.other
        && limits.beyond_other(values[0]).is_some()
    {
        return Err(PeriodicError::OutOfRange {
            value: values[0],
            range,
        });
    }
    if known.kind == SpecialKind::ChatterBorder {
        let monitors = spec.monitors.len();
        return special_curve::border::follow(model, (free, monitors), limits, &mut diary);
    }
    let workshop = in_plane(model, spec, (free, &values), limits)?;
    special_curve::follow(&workshop, (&values, known), limits, &mut diary)
}

/// A model with two free parameters at these values, within limits of the second.
fn in_plane(
    model: &Model,
    spec: &Spec,
    (free, values): ([usize; 2], &[f64; 2]),
    limits: &Limits,
) -> Result<Arc<Workshop>, PeriodicError> {
    let size = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
    let sizes = [size(values[0]), limits.range.1 - limits.range.0];
    workshop(model, spec, (&free, &sizes))
}

/// Whether a curve of special points, of a kind and with these orbits in order, goes through another special point as it was told: both
/// are then on one curve. `free` and `limits` are those that it was followed with; the model has the values of the point.
///
/// # Errors
/// The point cannot be found again.
pub fn goes_through(
    model: &Model,
    spec: &Spec,
    (free, known): ([usize; 2], &Known),
    limits: &Limits,
    (kind, points): (SpecialKind, &[Point]),
) -> Result<bool, PeriodicError> {
    let parameters = model.parameter_values::<f64>(&[]);
    let values = free.map(|index| parameters[index]);
    if known.kind == SpecialKind::ChatterBorder || !kind.shares_curves(known.kind) {
        return Ok(false);
    }
    let workshop = in_plane(model, spec, (free, &values), limits)?;
    special_curve::passes::passes(&workshop, (&values, known), limits, points)
}

/// A point is in a range up to so small a part of it.
const EDGE: f64 = 1e-9;

/// Where a settled orbit is looked for, in parts of the range.
const STARTS: [f64; 9] = [0.5, 0.02, 0.98, 0.25, 0.75, 0.1, 0.9, 0.4, 0.6];

#[cfg(test)]
mod tests;
