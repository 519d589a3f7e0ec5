//! Periodic orbits, stable or not, through impacts, complete chatter, contact and release.
//!
//! ```text
//! trace        a trajectory as instants and the modes between them
//! settle       the latest return of a trajectory to where it was: a cycle, nearly closed
//! itinerary    the cycle as legs of smooth flow, and stretches that are followed through complete chatter
//! closure      what a state is after one period: the same, but for turns of phases and distance covered
//! shooting     the equations of an itinerary: nodes after events and the times between them
//! branch       orbits over a parameter, from one sequence of events to the next
//! orbit        Newton's solution in double-double; multipliers, margins
//! ```

mod branch;
mod closure;
mod error;
mod itinerary;
mod orbit;
mod settle;
mod shooting;
mod trace;

pub use branch::{Branch, End, Limits, Point, Special, SpecialKind};
pub use error::PeriodicError;
pub use orbit::{Margin, MarginKind, Orbit};
pub use settle::Patience;

use crate::model::Model;
use closure::Closure;
use core::ops::ControlFlow;
use shooting::Workshop;
use std::sync::Arc;

/// Which periodic orbit is asked for.
#[derive(Clone, Debug, Default)]
pub struct Spec {
    /// Period of the forcing, an expression in parameters, where the equations do not tell it.
    pub period: Option<String>,
    /// The section at which states are told, by its position in the model; where it is not crossed, and without it, just
    /// after an event.
    pub section: Option<usize>,
    /// How long the trajectory may take to settle.
    pub patience: Patience,
}

fn workshop(model: &Model, spec: &Spec, (free, sizes): (&[usize], &[f64])) -> Result<Arc<Workshop>, PeriodicError> {
    let mut model = model.clone();
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
    let closure = Closure::new(&model, free, given)?;
    let sections = &model.sections;
    let plain = |index: &usize| sections.get(*index).is_some_and(|s| s.reset.is_none());
    let section = spec.section.or_else(|| (0..sections.len()).find(plain)).filter(plain);
    let workshop = Workshop::new(&model, (free, sizes), closure, section)?;
    Ok(Arc::new(workshop))
}

/// The orbit that the trajectory from the model's initial state settles to. The observer hears of the time that it has
/// come to.
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
    let cycle = settle::settle(&workshop, &[], &state, spec.patience, observer)?;
    orbit::close(&workshop, cycle, &[])
}

/// Where a branch of periodic orbits is looked for.
#[derive(Clone, Debug)]
pub struct BranchSpec {
    /// Position of the parameter that is varied.
    pub parameter: usize,
    /// Within what the branch is followed.
    pub limits: Limits,
}

/// The branch through the orbit that the trajectory from the model's initial state settles to. The observers hear of the time
/// that it has come to, and of each orbit found.
///
/// # Errors
/// There is no such orbit, or none was found.
pub fn branch(
    model: &Model,
    spec: &Spec,
    branch: &BranchSpec,
    observer: &mut dyn FnMut(Option<&Point>) -> ControlFlow<()>,
) -> Result<Branch, PeriodicError> {
    let (low, high) = branch.limits.range;
    let workshop = workshop(model, spec, (&[branch.parameter], &[high - low]))?;
    let parameters = model.parameter_values::<f64>(&[]);
    let here = parameters[branch.parameter].clamp(low, high);
    let parameters = model.parameter_values::<f64>(&[(branch.parameter, here)]);
    let state = model.initial_state(&parameters);
    let mut settling = |_: f64| observer(None);
    let cycle = settle::settle(&workshop, &[here], &state, spec.patience, &mut settling)?;
    let orbit = orbit::close(&workshop, cycle, &[here])?;
    branch::follow(&workshop, &orbit.shooting, &orbit.at, &branch.limits, &mut |point| {
        observer(Some(point))
    })
}

#[cfg(test)]
mod tests;
