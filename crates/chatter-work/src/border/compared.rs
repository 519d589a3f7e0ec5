//! The windows of a model near a border, beside the predicted ones.

use super::Subject;
use super::refused::refused;
use crate::json::{Json, Object};
use crate::numbers::Digits;
use crate::refusal::Refusal;
use chatter::analysis::border::{
    Border, BorderSpec, Estimate, Prediction, Simulator, WindowComparison,
};
use chatter::numerics::Real;
use core::ops::ControlFlow;

/// The windows asked for, as far as the model has them. The observer hears how much is done, of one.
///
/// # Errors
/// There is no prediction, or the observer breaks off.
pub fn compared<R: Real>(
    subject: &Subject,
    spec: &BorderSpec,
    border: &Border<R>,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Vec<WindowComparison>, Refusal> {
    let prediction = Prediction::exact(border).map_err(refused)?;
    let simulator = Simulator::new(subject.model, spec, border).map_err(refused)?;
    let (first, last) = subject.laps(border);
    (simulator.compare_until(&prediction, (first, last), observer)).ok_or(Refusal::Interrupted)
}

/// What is compared.
pub const NAMES: [&str; 3] = ["fold", "period_doubling", "grazing"];

/// Of each its value, and by how much of its distance from the border the prediction misses it.
pub fn ends(
    window: &WindowComparison,
    border: f64,
) -> impl Iterator<Item = (Option<Estimate<f64>>, Option<f64>)> {
    let (found, off) = (window.located, window.discrepancy(border));
    found.ends().into_iter().zip(off.ends())
}

/// As JSON.
pub fn list(windows: &[WindowComparison], border: f64, digits: Digits) -> Json {
    let number = |value: Option<f64>| value.map_or(Json::Null, Json::Number);
    let object = |window: &WindowComparison| {
        let start = Object::new(digits).with("n", window.predicted.lap);
        (NAMES.into_iter().zip(ends(window, border)))
            .fold(start, |object, (name, (found, off))| {
                object
                    .with(name, number(found.map(|found| found.value)))
                    .with(
                        &format!("{name}_error"),
                        number(found.map(|found| found.error)),
                    )
                    .with(&format!("{name}_missed_by"), number(off))
            })
            .into()
    };
    Json::List(windows.iter().map(object).collect())
}
