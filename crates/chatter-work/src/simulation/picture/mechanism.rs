//! The mechanism as the model's drawing has it, at the last time shown.

use super::Subject;
use super::shown::Shown;
use crate::drawing::drawn;
use chatter::model::ShapeKind;
use chatter_figures::{Axis, Color, Legend, Line, Panel};

const STROKE: f64 = 0.9;
const HATCH_STROKE: f64 = 0.4;

/// The shapes at the last sample.
pub fn panel(subject: &Subject, shown: &Shown) -> Panel {
    let last = |values: &Vec<f64>| values.last().copied().unwrap_or(f64::NAN);
    let state: Vec<f64> = shown.states.iter().map(last).collect();
    let mut panel = Panel::new(Axis::new(""), Axis::new("")).equal();
    for shape in drawn(subject.model, &state, last(&shown.times)) {
        panel.add(
            Line::new(shape.hatches.0, shape.hatches.1)
                .color(Color::GREY)
                .width(HATCH_STROKE),
        );
        let color = match shape.kind {
            ShapeKind::Mass | ShapeKind::Disc => Color::BLUE,
            ShapeKind::Spring => Color::GREY,
            ShapeKind::Wall | ShapeKind::RoundWall | ShapeKind::Rod => Color::INK,
        };
        let (x, y) = shape.outline;
        panel.add(Line::new(x, y).color(color).width(STROKE));
    }
    panel.legend(Legend::Hidden)
}
