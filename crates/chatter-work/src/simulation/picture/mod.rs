//! A simulation as a figure: the history of each state, and the phase portrait.

mod history;
mod portrait;
mod shown;

use super::{Record, Subject};
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Samples, Sampling, Simulation};
use chatter::model::Label;
use chatter::numerics::{DoubleDouble, Real};
use chatter_figures::{Axis, Color, Figure, Line, Panel, variable};
use shown::Shown;

/// The resolution of a picture, in parts of the time simulated.
const RESOLUTION: f64 = 1e-6;

/// One column of panels in a figure of this width, and two in one of that, in millimetres.
const NARROW: f64 = 110.0;
const WIDE: f64 = 178.0;
/// So many panels still stand in one column; its lowest one, the portrait, is higher than the others.
const MOST_IN_COLUMN: usize = 3;
const COLUMN_HEIGHT: f64 = 190.0;
const PORTRAIT_HEIGHT: f64 = 1.6;

/// Widths of the lines of the motion, and of the jumps at impacts.
const CURVE: f64 = 0.8;
const JUMP: f64 = 0.4;

/// What has to be sampled of a run that lasts so long, to show this window of it.
pub fn sampling(duration: DoubleDouble, window: Option<(f64, f64)>) -> Sampling {
    Sampling::Smooth {
        resolution: duration * DoubleDouble::from(RESOLUTION),
        window: window.map(|(from, to)| (from.into(), to.into())),
    }
}

/// A figure, and whether it leaves out the beginning.
pub struct Picture {
    /// The figure.
    pub figure: Figure,
    /// The first time shown, where that is not the start, and nobody asked for it.
    pub shortened_to: Option<f64>,
}

/// Draws the samples within `window`; without one all that can be told apart, up to the end of the run.
pub fn draw<R: Real>(
    subject: &Subject,
    run: (&Simulation<R>, &Record<R>),
    samples: &Samples<R>,
    window: Option<(f64, f64)>,
) -> Result<Picture, Refusal> {
    let shown = Shown::new(subject, run, samples, window)?;
    let states: Vec<usize> = subject.states().collect();
    let mut figure = Figure::new();
    for (place, &index) in states.iter().enumerate() {
        figure = figure.panel(history::panel(subject, &shown, index, place == 0));
    }
    let portrait = portrait::panel(subject, &shown);
    let panels = states.len() + usize::from(portrait.is_some());
    if let Some(portrait) = portrait {
        figure = figure.panel(portrait);
    }
    figure = if panels > MOST_IN_COLUMN {
        figure.columns(2).width(WIDE)
    } else if panels == MOST_IN_COLUMN {
        let figure = figure.width(NARROW).height(COLUMN_HEIGHT);
        figure.row_heights(&[1.0, 1.0, PORTRAIT_HEIGHT])
    } else {
        figure.width(NARROW)
    };
    let title = subject.model.title.as_deref().unwrap_or(subject.source);
    Ok(Picture {
        figure: figure.title(title).caption(caption(subject, title, &shown)),
        shortened_to: shown.shortened.then_some(shown.from),
    })
}

fn caption(subject: &Subject, title: &str, shown: &Shown) -> String {
    let parameters = subject.model.parameter_values::<f64>(&[]);
    let values = subject.model.parameters.iter().zip(parameters);
    let values: Vec<String> = values
        .map(|(parameter, value)| format!("{} = {value}", parameter.name))
        .collect();
    let given = match &values[..] {
        [] => String::new(),
        values => format!(", {}", values.join(", ")),
    };
    format!(
        "{title} ({}){given}, from time {} to {}. Bands: contact; ticks: impacts; discs: accumulations of impacts. Made by \
         chatter {}.",
        subject.source,
        shown.from,
        shown.to,
        env!("CARGO_PKG_VERSION")
    )
}

/// The axis of a quantity: what its label says, else its name.
pub fn axis_of(name: &str, label: Option<&Label>) -> Axis {
    let text = label.and_then(|label| label.text.clone());
    let axis = Axis::new(text.unwrap_or_else(|| variable(name)));
    match label.and_then(|label| label.unit.clone()) {
        Some(unit) => axis.unit(unit),
        None => axis,
    }
}

/// The motion as a curve that is broken where an impact makes the state jump, and the jumps as thin lines.
fn add_curve(panel: &mut Panel, jumps: &[usize], x: &[f64], y: &[f64]) {
    let jump_line = |side: &[f64]| {
        let ends = jumps
            .iter()
            .flat_map(|&place| [side[place - 1], side[place], f64::NAN]);
        ends.collect::<Vec<f64>>()
    };
    let curve = |side: &[f64]| {
        let mut broken = Vec::with_capacity(side.len() + jumps.len());
        let mut from = 0;
        for &place in jumps {
            broken.extend_from_slice(&side[from..place]);
            broken.push(f64::NAN);
            from = place;
        }
        broken.extend_from_slice(&side[from..]);
        broken
    };
    panel.add(
        Line::new(jump_line(x), jump_line(y))
            .color(Color::GREY)
            .width(JUMP),
    );
    panel.add(
        Line::new(curve(x), curve(y))
            .color(Color::BLUE)
            .width(CURVE),
    );
}
