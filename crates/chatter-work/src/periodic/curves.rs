//! Curves of special points in two parameters, one after the other.

use super::find::find_curve;
use super::job::{Plane, Ready};
use super::log::Log;
use super::restored::Restored;
use super::wanted::Curve;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::periodic::{Branch, End, Known, Record, Spec, SpecialKind};
use chatter::model::Model;

/// Curves that were followed.
pub(super) struct Curves {
    /// Each of its kind of points.
    pub curves: Vec<(SpecialKind, Branch)>,
    /// The functions that are watched on them.
    pub monitors: Vec<String>,
    /// Whether the observer let the work come to its end.
    pub complete: bool,
}

/// The curves. With a log they go on from what it held, and how far they come is kept in it.
///
/// # Errors
/// A point cannot be found again, or is of a kind that has no curve, or the log cannot be written.
pub(super) fn find_curves(
    ready: &Ready,
    plane: &Plane,
    log: Option<&mut Log>,
    observer: &dyn Observer,
) -> Result<Curves, Refusal> {
    let over = ready.wanted.over;
    let mut spec = ready.wanted.spec.clone();
    let mut log = log;
    let mut known = log.as_mut().map(|log| log.before()).unwrap_or_default();
    let mut curves = Vec::new();
    let mut complete = true;
    for (piece, point) in plane.points.iter().enumerate() {
        let mut model = ready.model.clone();
        let at = known_point((&mut model, &mut spec), point)?;
        let wanted = Curve {
            spec: spec.clone(),
            free: [ready.free[0], over.parameter],
            known: at,
            limits: over.limits,
        };
        let before = known.parts.remove(&piece).unwrap_or_default();
        let mut keep = |record: &Record| log.as_mut().map_or(Ok(()), |log| log.part(piece, record));
        let curve = find_curve(&model, &wanted, (before, &mut keep), observer)?;
        complete = !curve.1.ends.contains(&End::Interrupted);
        curves.push(curve);
        if !complete {
            break;
        }
    }
    Ok(Curves {
        curves,
        monitors: spec.monitors,
        complete,
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
