//! A return map: a quantity at an event against what it is at the next one, with the cobweb between, and the curve that the
//! points are on where it is one.

use super::return_curve::{ReturnCurve, states_at};
use super::shown::Shown;
use super::side::{Formula, Quantity};
use super::wanted::At;
use super::{Record, Subject};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::numerics::Real;
use chatter_figures::{Color, Legend, Line, Marker, Markers, Panel};

/// Steps of the cobweb: the last ones; of more it would be a blot.
const STEPS: usize = 60;
const DISC: f64 = 2.2;
/// Room around the points, as a part of their extent.
const ROOM: f64 = 0.06;

/// The map of the events that are shown.
pub fn panel<R: Real>(
    subject: &Subject,
    record: &Record<R>,
    shown: &Shown,
    (what, at): (Quantity, At),
    observer: &dyn Observer,
) -> Result<Panel, Refusal> {
    let formula = Formula::new(subject, what)?;
    let parameters = subject.model.parameter_values::<f64>(&[]);
    let states = states_at(record, at, (shown.from, shown.to))?;
    let values = states.iter();
    let values: Vec<f64> = values
        .map(|state| formula.value(state, &parameters))
        .collect();
    let curve = match ReturnCurve::of(subject.model, (what, at), &states) {
        Some(curve) => curve.points(subject.model, observer)?,
        None => (Vec::new(), Vec::new()),
    };
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = match high - low {
        extent if extent > 0.0 => (low - ROOM * extent, high + ROOM * extent),
        _ if low.is_finite() => (
            low - low.abs().max(1.0) * ROOM,
            low + low.abs().max(1.0) * ROOM,
        ),
        _ => (0.0, 1.0),
    };
    let x = formula.axis.range(low, high);
    let mut y = x.clone();
    y.label = format!("next {}", y.label);
    let (mut web_x, mut web_y) = (Vec::new(), Vec::new());
    for pair in values[values.len().saturating_sub(STEPS + 1)..].windows(2) {
        web_x.extend([pair[0], pair[0], pair[1]]);
        web_y.extend([pair[0], pair[1], pair[1]]);
    }
    let pairs = values.windows(2).map(|pair| (pair[0], pair[1]));
    let (before, after) = pairs.unzip();
    Ok(Panel::new(x, y)
        .with(
            Line::new(vec![low, high], vec![low, high])
                .color(Color::GREY)
                .width(0.4),
        )
        .with(Line::new(curve.0, curve.1).color(Color::INK).width(0.8))
        .with(Line::new(web_x, web_y).color(Color::BLUE).width(0.4))
        .with(
            Markers::new(before, after)
                .marker(Marker::Disc)
                .size(DISC)
                .color(Color::INK),
        )
        .legend(Legend::Hidden))
}
