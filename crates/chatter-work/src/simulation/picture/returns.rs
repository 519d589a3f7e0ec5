//! A return map: a quantity at an event against what it is at the next one, with the cobweb between.

use super::shown::Shown;
use super::side::{Formula, Quantity};
use super::wanted::At;
use super::{Record, Subject};
use crate::refusal::Refusal;
use chatter::flow::Place;
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
) -> Result<Panel, Refusal> {
    let formula = Formula::new(subject, what)?;
    let parameters = subject.model.parameter_values::<f64>(&[]);
    let mut values = Vec::new();
    for noted in record.events() {
        let event = noted?.event;
        let is_meant = match at {
            At::Kind(kind) => event.kind == kind,
            At::Section(section) => event.detail.place() == Some(Place::Section(section)),
        };
        if is_meant && (shown.from..=shown.to).contains(&event.time.to_f64()) {
            let state: Vec<f64> = event.state.iter().map(|value| value.to_f64()).collect();
            values.push(formula.value(&state, &parameters));
        }
    }
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
        .with(Line::new(web_x, web_y).color(Color::BLUE).width(0.4))
        .with(
            Markers::new(before, after)
                .marker(Marker::Disc)
                .size(DISC)
                .color(Color::INK),
        )
        .legend(Legend::Hidden))
}
