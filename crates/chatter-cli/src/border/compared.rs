//! The windows of a model near a border, beside the predicted ones.

use super::Subject;
use super::refused::refused;
use crate::aligned::Side;
use crate::failure::Failure;
use crate::json::{Json, Object};
use crate::numbers::{Digits, full};
use chatter::analysis::border::{
    Border, BorderSpec, Estimate, Prediction, Simulator, WindowComparison,
};
use chatter::numerics::Real;

/// The windows asked for, as far as the model has them.
pub fn compared<R: Real>(
    subject: &Subject,
    spec: &BorderSpec,
    border: &Border<R>,
) -> Result<Vec<WindowComparison>, Failure> {
    let prediction = Prediction::exact(border).map_err(refused)?;
    let simulator = Simulator::new(subject.model, spec, border).map_err(refused)?;
    let (first, last) = subject.laps(border);
    Ok(simulator.compare(&prediction, first, last))
}

/// What is compared.
const NAMES: [&str; 3] = ["fold", "period_doubling", "grazing"];

/// Of each its value, and by how much of its distance from the border the prediction misses it.
fn ends(
    window: &WindowComparison,
    border: f64,
) -> impl Iterator<Item = (Option<Estimate<f64>>, Option<f64>)> {
    let (found, off) = (window.located, window.discrepancy(border));
    found.ends().into_iter().zip(off.ends())
}

/// Decimals of a percentage at most.
const PERCENT_DECIMALS: f64 = 3.0;

/// Rows of text with a heading, and the sides of their columns.
pub fn rows(
    windows: &[WindowComparison],
    border: f64,
    digits: Digits,
) -> (Vec<Vec<String>>, &'static [Side]) {
    const NUMBERS: &[Side] = &[Side::Right; 7];
    let named = NAMES.map(|name| [name.replace('_', " "), "missed by".to_owned()]);
    let heading = core::iter::once("n".to_owned()).chain(named.into_iter().flatten());
    let mut rows = vec![heading.collect()];
    for window in windows {
        let mut row = vec![window.predicted.lap.to_string()];
        for (found, off) in ends(window, border) {
            let missing = || "-".to_owned();
            row.push(found.map_or_else(missing, |found| {
                full(found.value, super::known(&found, digits))
            }));
            let percent = |off: f64, found: Estimate<f64>| {
                let error = 100.0 * found.error / (found.value - border).abs();
                // Up to the first digit of the error.
                let decimals = (-error.log10()).ceil().clamp(0.0, PERCENT_DECIMALS) as usize;
                format!("{:+.decimals$} %", 100.0 * off)
            };
            row.push(
                off.zip(found)
                    .map_or_else(missing, |(off, found)| percent(off, found)),
            );
        }
        rows.push(row);
    }
    (rows, NUMBERS)
}

/// As JSON.
pub fn list(windows: &[WindowComparison], border: f64, digits: Digits) -> Json {
    let number = |value: Option<f64>| value.map_or(Json::Null, Json::Number);
    let object = |window: &WindowComparison| {
        let start = Object::new(digits).with("n", i64::from(window.predicted.lap));
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
