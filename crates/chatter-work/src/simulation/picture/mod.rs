//! A simulation as a figure: histories, phase portraits, the rates of impacts, return maps, the mechanism.

mod history;
mod impacts;
mod mechanism;
mod portrait;
mod return_curve;
mod returns;
mod shown;
mod side;
mod wanted;

pub use return_curve::ReturnCurve;
pub use wanted::Axes;

use super::{Record, Subject};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Samples, Sampling, Simulation};
use chatter::model::{Label, Model};
use chatter::numerics::{DoubleDouble, Real};
use chatter_figures::{Axis, Color, Figure, Line, Panel, variable};
use shown::Shown;
use side::Side;
use wanted::Shows;

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

/// Checks that there is what a figure is to show.
///
/// # Errors
/// A name is no state's.
pub fn check(subject: &Subject, axes: &[Axes]) -> Result<(), Refusal> {
    wanted::panels(subject, axes).map(|_| ())
}

/// Draws the samples within `window`; without one all that can be told apart, up to the end of the run. In a panel for
/// each of `axes`; without any the history of each state, and the portrait.
pub fn draw<R: Real>(
    subject: &Subject,
    run: (&Simulation<R>, &Record<R>),
    samples: &Samples<R>,
    window: Option<(f64, f64)>,
    axes: &[Axes],
    observer: &dyn Observer,
) -> Result<Picture, Refusal> {
    let shown = Shown::new(subject, run, samples, window)?;
    let mut figure = Figure::new();
    let (mut panels, mut histories, mut square) = (0, 0, false);
    for shows in wanted::panels(subject, axes)? {
        let panel = match shows {
            Shows::History(what) => {
                histories += 1;
                // One legend for all.
                let side = Side::new(subject, &shown, what)?;
                Some(history::panel(subject, &shown, side, histories == 1))
            }
            Shows::Portrait(x, y) => {
                let sides = (
                    Side::new(subject, &shown, x)?,
                    Side::new(subject, &shown, y)?,
                );
                Some(portrait::of(&shown, sides))
            }
            Shows::UsualPortrait => portrait::panel(subject, &shown)?,
            Shows::Impacts(over) => Some(impacts::panel(subject, run.1, &shown, over)?),
            Shows::Returns(what, at) => {
                square = true;
                Some(returns::panel(
                    subject,
                    run.1,
                    &shown,
                    (what, at),
                    observer,
                )?)
            }
            Shows::Mechanism => {
                square = true;
                Some(mechanism::panel(subject, &shown))
            }
        };
        if let Some(panel) = panel {
            panels += 1;
            figure = figure.panel(panel);
        }
    }
    figure = if panels > MOST_IN_COLUMN {
        figure.columns(2).width(WIDE)
    } else if panels == MOST_IN_COLUMN && axes.is_empty() {
        let figure = figure.width(NARROW).height(COLUMN_HEIGHT);
        figure.row_heights(&[1.0, 1.0, PORTRAIT_HEIGHT])
    } else if square && panels == 1 {
        figure.width(NARROW).height(NARROW)
    } else {
        figure.width(NARROW)
    };
    let title = subject.model.title.as_deref().unwrap_or(subject.source);
    Ok(Picture {
        figure: figure
            .title(format!("{title}{}", parameters(subject.model, &|_| true)))
            .caption(caption(subject, title, &shown)),
        shortened_to: shown.shortened.then_some(shown.from),
    })
}

fn caption(subject: &Subject, title: &str, shown: &Shown) -> String {
    format!(
        "{title} ({}){}, from time {} to {}. Bands: contact; ticks: impacts; discs: accumulations of impacts. Made by \
         chatter {}.",
        subject.source,
        parameters(subject.model, &|_| true),
        shown.from,
        shown.to,
        env!("CARGO_PKG_VERSION")
    )
}

/// The parameters whose names are wanted with their values, as `, q = 1, r = 2`.
pub fn parameters(model: &Model, wanted: &dyn Fn(&str) -> bool) -> String {
    let values = model.parameter_values::<f64>(&[]);
    let known = model.parameters.iter().zip(values);
    known
        .filter(|(parameter, _)| wanted(&parameter.name))
        .map(|(parameter, value)| format!(", {} = {value}", parameter.name))
        .collect()
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
