//! The orbits of a model near a border, beside and under those that the one-dimensional map predicts.

use super::Subject;
use super::refused::refused;
use crate::diagram::picture::axis;
use crate::observer::Observer;
use crate::parallel;
use crate::refusal::Refusal;
use crate::simulation::picture::axis_of;
use chatter::analysis::border::{
    Border, BorderSpec, PredictedWindow, Prediction, Simulator, WindowComparison,
};
use chatter::expressions::tex_name;
use chatter::model::Label;
use chatter::numerics::Real;
use chatter_figures::{Color, Density, Figure, Legend, Normalisation, Panel, Sharing};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Values of the parameter, and rows of cells of a panel.
const COLUMNS: usize = 500;
const CELLS: usize = 500;
/// Passages left out and kept for each value.
const TRANSIENT: usize = 150;
const KEPT: usize = 100;
/// Room beyond the outermost windows, and around the orbits.
const ROOM: f64 = 0.04;
/// In millimetres.
const WIDTH: f64 = 178.0;
const HEIGHT: f64 = 210.0;

type Points = Vec<(f64, f64)>;

/// Simulated, predicted, and both on top of each other, over the windows of these n.
pub fn picture<R: Real>(
    subject: &Subject,
    spec: &BorderSpec,
    border: &Border<R>,
    compared: &[WindowComparison],
    observer: &dyn Observer,
) -> Result<Figure, Refusal> {
    let model = subject.model;
    let prediction = Prediction::exact(border).map_err(refused)?;
    let simulator = Simulator::new(model, spec, border).map_err(refused)?;
    let (first, last) = subject.laps(border);
    // Far from the border an orbit is born at a fold or at its graze; the next lap begins where this one's graze is not.
    let ends = |window: PredictedWindow| {
        let begins = window.fold.unwrap_or(window.grazing);
        let doubles = window.period_doubling.unwrap_or(window.grazing);
        [begins, window.superstable, doubles].map(|point| point.parameter)
    };
    let predicted = [first, last].map(|lap| ends(prediction.window(lap)));
    let located = compared.iter().filter(|window| {
        let lap = window.predicted.lap;
        lap == first || lap == last
    });
    let located = located.flat_map(|window| [window.located.fold, window.located.period_doubling]);
    let all = || {
        let located = located.clone().flatten().map(|point| point.value);
        predicted.into_iter().flatten().chain(located)
    };
    let low = all().fold(f64::INFINITY, f64::min);
    let high = all().fold(f64::NEG_INFINITY, f64::max);
    let room = ROOM * (high - low);
    let (low, high) = (low - room, high + room);
    let coordinate = coordinate(border);

    let value = |column: usize| low + (high - low) * column as f64 / (COLUMNS - 1) as f64;
    let straight = |parameter: f64, state: &[f64]| {
        let distance = parameter - prediction.border;
        state[coordinate] - prediction.states.at(0.0, distance)[coordinate]
    };
    let predicted: Points = (0..COLUMNS)
        .flat_map(|column| {
            let parameter = value(column);
            let passages = prediction.orbit(parameter, TRANSIENT, KEPT);
            let y = passages
                .into_iter()
                .map(|passage| straight(parameter, &prediction.state(parameter, &passage)));
            y.map(move |y| (parameter, y)).collect::<Points>()
        })
        .collect();
    let simulated = each_column(observer, |column| {
        let parameter = value(column);
        let orbit = simulator.orbit(parameter, TRANSIENT, KEPT);
        let passages = orbit.map_or_else(|_| Vec::new(), |orbit| orbit.passages);
        let y = passages
            .iter()
            .map(|passage| straight(parameter, &passage.state));
        y.map(|y| (parameter, y)).collect()
    })?;

    if simulated.is_empty() {
        observer.remark(
            "no orbit of the model stays near the border over these windows: nothing simulated is drawn",
        );
    }
    let all = || simulated.iter().chain(&predicted).map(|point| point.1);
    let bottom = all().fold(f64::INFINITY, f64::min);
    let top = all().fold(f64::NEG_INFINITY, f64::max);
    // Where all orbits end at rest there is one value only.
    let height = if top > bottom {
        top - bottom
    } else {
        top.abs().max(1.0)
    };
    let margin = ROOM * height;
    let range = (bottom - margin, top + margin);
    let state = &model.states[coordinate];
    // Less what does not depend on the passage before: the state of the next order in z alone.
    let observed = format!(
        "${}$ after first impact, less that for $z = 0$",
        tex_name(&state.name)
    );
    let label = Label {
        text: Some(observed),
        unit: state.label.as_ref().and_then(|label| label.unit.clone()),
    };
    let vertical = axis_of(&state.name, Some(&label)).range(range.0, range.1);
    let panel = |layers: &[(&Points, Color, &str)]| {
        let mut panel = Panel::new(
            axis(model, &spec.parameter).range(low, high),
            vertical.clone(),
        );
        for (points, color, name) in layers {
            let mut density = Density::new((low, high), range)
                .cells(COLUMNS, CELLS)
                .normalisation(Normalisation::Column)
                .color(*color)
                .label(*name);
            points.iter().for_each(|&(x, y)| density.add(x, y));
            panel.add(density);
        }
        panel.legend(Legend::Above)
    };
    let (ours, theirs) = (
        (&simulated, Color::NIGHT, "simulated"),
        (&predicted, Color::VERMILION, "predicted"),
    );
    Ok(Figure::new()
        .panel(panel(&[ours]))
        .panel(panel(&[theirs]))
        .panel(panel(&[ours, theirs]))
        .sharing(Sharing::Horizontal)
        .width(WIDTH)
        .height(HEIGHT))
}

/// The coordinate after the first impact that is no phase; else the first.
fn coordinate<R: Real>(border: &Border<R>) -> usize {
    let is_phase = |i: usize| border.turns.iter().any(|turn| turn.state == i);
    let coordinates = || border.section.iter().copied();
    coordinates()
        .find(|&i| !is_phase(i))
        .or_else(|| coordinates().next())
        .unwrap_or(0)
}

/// Points of all columns in their order, computed side by side.
fn each_column(
    observer: &dyn Observer,
    points: impl Fn(usize) -> Points + Sync,
) -> Result<Points, Refusal> {
    let done = AtomicUsize::new(0);
    let columns: Vec<usize> = (0..COLUMNS).collect();
    let found = parallel::each(&columns, observer.stop(), |&column| {
        let found = points(column);
        let part = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / COLUMNS as f64;
        observer.progress(part, &|| "orbits".to_owned());
        Ok(found)
    });
    Ok(found?.concat())
}
