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

/// Name, value, and by how much of its distance from the border the prediction misses it.
type Kind = (&'static str, Option<Estimate<f64>>, Option<f64>);

fn kinds(window: &WindowComparison, border: f64) -> [Kind; 3] {
    let (found, off) = (window.located, window.discrepancy(border));
    [
        ("fold", found.fold, off.fold),
        (
            "period_doubling",
            found.period_doubling,
            off.period_doubling,
        ),
        ("grazing", found.grazing, off.grazing),
    ]
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
    let mut rows = vec![vec!["n".to_owned()]];
    for window in windows {
        let mut row = vec![window.predicted.lap.to_string()];
        for (name, found, off) in kinds(window, border) {
            if rows[0].len() < NUMBERS.len() {
                rows[0].extend([name.replace('_', " "), "missed by".to_owned()]);
            }
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
        (kinds(window, border).into_iter())
            .fold(start, |object, (name, found, off)| {
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
