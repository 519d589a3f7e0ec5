//! Curves of special points in two parameters, side by side.

use super::find::find_curve;
use super::job::{Plane, Ready};
use super::log::Log;
use super::restored::Restored;
use super::wanted::Curve;
use crate::observer::Observer;
use crate::parallel::{each, lock};
use crate::refusal::Refusal;
use chatter::analysis::periodic::{Branch, End, Known, Record, Spec, SpecialKind, goes_through};
use chatter::model::Model;
use std::sync::{Mutex, PoisonError};

/// Curves that were followed.
pub(super) struct Curves {
    /// Each of its kind of points.
    pub curves: Vec<(SpecialKind, Branch)>,
    /// The functions that are watched on them.
    pub monitors: Vec<String>,
    /// Whether the observer let the work come to its end.
    pub complete: bool,
}

/// The curves, side by side. With a log they go on from what it held, and how far they come is kept in it.
///
/// # Errors
/// A point cannot be found again, or is of a kind that has no curve, or the log cannot be written.
pub(super) fn find_curves(
    ready: &Ready,
    plane: &Plane,
    mut log: Option<&mut Log>,
    observer: &dyn Observer,
) -> Result<Curves, Refusal> {
    let mut spec = ready.wanted.spec.clone();
    let mut begun = log.as_mut().map(|log| log.before()).unwrap_or_default();
    let mut pieces = Vec::new();
    for (number, point) in plane.points.iter().enumerate() {
        let mut model = ready.model.clone();
        let known = known_point((&mut model, &mut spec), point)?;
        let before = begun.parts.remove(&number).unwrap_or_default();
        pieces.push((number, model, known, before));
    }
    let free = [ready.free[0], ready.wanted.over.parameter];
    let log = Mutex::new(log);
    let found: Vec<Mutex<Option<_>>> = pieces.iter().map(|_| Mutex::new(None)).collect();
    let refused: Mutex<Vec<(usize, Refusal)>> = Mutex::default();
    let filled = each(
        &pieces,
        observer.stop(),
        |(number, model, known, before)| {
            let wanted = Curve {
                spec: spec.clone(),
                free,
                known: known.clone(),
                limits: ready.wanted.over.limits,
            };
            let mut keep = |record: &Record| match &mut *lock(&log) {
                Some(log) => log.part(*number, record),
                None => Ok(()),
            };
            match find_curve(model, &wanted, (before.clone(), &mut keep), observer) {
                Ok(curve) => *lock(&found[*number]) = Some(curve),
                // Of several the others are followed.
                Err(refusal @ (Refusal::Input { .. } | Refusal::Unfinished { .. })) => {
                    lock(&refused).push((*number, refusal));
                }
                Err(refusal) => return Err(refusal),
            }
            Ok(())
        },
    );
    match filled {
        Ok(_) | Err(Refusal::Interrupted) => {}
        Err(refusal) => return Err(refusal),
    }
    let mut refused = refused.into_inner().unwrap_or_else(PoisonError::into_inner);
    refused.sort_by_key(|&(number, _)| number);
    if refused.len() == pieces.len() && !refused.is_empty() {
        return Err(refused.swap_remove(0).1);
    }
    for (number, refusal) in refused {
        if let Refusal::Input { message, .. } | Refusal::Unfinished { message, .. } = refusal {
            let Restored {
                known, parameters, ..
            } = &plane.points[number];
            let values: Vec<String> = (parameters.iter())
                .map(|(name, value)| format!("{name} = {value}"))
                .collect();
            let (kind, values) = (known.kind.name(), values.join(", "));
            observer.remark(&format!("no curve of the {kind} at {values}: {message}"));
        }
    }
    let found = found.into_iter().map(|curve| lock(&curve).take());
    let mut all: Vec<Option<(SpecialKind, Branch)>> = found.collect();
    let is_whole = |curve: &Option<(SpecialKind, Branch)>| {
        (curve.as_ref()).is_some_and(|(_, curve)| !curve.ends.contains(&End::Interrupted))
    };
    let complete = all.iter().all(is_whole);
    // Two points may lie on one curve: it is listed once, from the first of them.
    for (number, model, known, _) in &pieces {
        if all[*number].is_none() {
            continue;
        }
        let of = (free, known);
        let before = pieces.iter().zip(&all[..*number]);
        let is_known = before
            .filter_map(|(piece, curve)| Some((&piece.2, curve.as_ref()?)))
            .any(|(other, (of_kind, curve))| {
                let limits = &ready.wanted.over.limits;
                let curve = (*of_kind, &*curve.points);
                other.monitor == known.monitor
                    && goes_through(model, &spec, of, limits, curve).unwrap_or(false)
            });
        if is_known {
            all[*number] = None;
        }
    }
    Ok(Curves {
        complete,
        curves: all.into_iter().flatten().collect(),
        monitors: spec.monitors,
    })
}

/// A special point that is followed in two parameters; the model is set to its values.
fn known_point(
    (model, spec): (&mut Model, &mut Spec),
    restored: &Restored,
) -> Result<Known, Refusal> {
    for (name, value) in &restored.parameters {
        (model.set_parameter(name, &format!("{value:?}"))).map_err(Refusal::input)?;
    }
    let mut known = restored.known.clone();
    if let Some(text) = &restored.function {
        let place = spec.monitors.iter().position(|known| known == text);
        known.monitor = Some(place.unwrap_or_else(|| {
            spec.monitors.push(text.clone());
            spec.monitors.len() - 1
        }));
    }
    Ok(known)
}
