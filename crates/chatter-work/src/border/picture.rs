//! The orbits of a model near a border, under the edges of those that the one-dimensional map predicts, and the latter by
//! themselves.

use super::Subject;
use super::overlay::{COLUMNS, Orbits, Overlay};
use crate::diagram::picture::axis;
use crate::simulation::picture::axis_of;
use chatter::analysis::border::{PredictedPoint, PredictedWindow};
use chatter::expressions::tex_name;
use chatter::model::Label;
use chatter_figures::{
    Color, Dash, Density, Figure, Legend, Line, Normalisation, Panel, Rule, Sharing,
};

/// Rows of cells of a panel.
const CELLS: usize = 500;
/// Room around the orbits.
const ROOM: f64 = 0.04;
/// Widths of lines, in points.
const EDGE: f64 = 0.7;
const EVENT: f64 = 0.5;
/// In millimetres.
const WIDTH: f64 = 178.0;
const HEIGHT: f64 = 160.0;

/// Simulated orbits and the edges of the predicted ones, above the predicted ones.
pub fn picture(subject: &Subject, overlay: &Overlay) -> Figure {
    let model = subject.model;
    let (low, high) = overlay.range;
    let ends = || overlay.edges.iter().flat_map(|edge| [edge.1, edge.2]);
    let all = || overlay.simulated.straight.iter().copied().chain(ends());
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
    let state = &model.states[overlay.coordinate];
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
    let panel = |orbits: &Orbits, color: Color, name: &str| {
        let horizontal = axis(model, subject.parameter).range(low, high);
        let mut density = Density::new((low, high), range)
            .cells(COLUMNS, CELLS)
            .normalisation(Normalisation::Column)
            .color(color)
            .label(name);
        density.extend(orbits.points());
        Panel::new(horizontal, vertical.clone()).with(density)
    };
    let mut simulated = panel(&overlay.simulated, Color::NIGHT, "simulated");
    edges(&mut simulated, &overlay.edges);
    events(&mut simulated, overlay);
    let predicted = panel(&overlay.predicted, Color::VERMILION, "predicted");
    Figure::new()
        .panel(simulated.legend(Legend::Above))
        .panel(predicted.legend(Legend::Above))
        .sharing(Sharing::Horizontal)
        .width(WIDTH)
        .height(HEIGHT)
}

/// The lowest and the highest of the predicted orbits.
fn edges(panel: &mut Panel, edges: &[(f64, f64, f64)]) {
    let line = |of: fn(&(f64, f64, f64)) -> f64| {
        let x = edges.iter().map(|edge| edge.0).collect();
        let y = edges.iter().map(of).collect();
        Line::new(x, y).color(Color::VERMILION).width(EDGE)
    };
    panel.add(line(|edge| edge.1).label("edges of the predicted orbits"));
    panel.add(line(|edge| edge.2));
}

/// Where the predicted windows begin and end.
fn events(panel: &mut Panel, overlay: &Overlay) {
    let (low, high) = overlay.range;
    type Part = fn(&PredictedWindow) -> Option<PredictedPoint>;
    let kinds: [(&str, Dash, Part); 3] = [
        ("fold", Dash::Solid, |window| window.fold),
        ("period doubling", Dash::Dashed, |window| {
            window.period_doubling
        }),
        ("graze", Dash::Dotted, |window| Some(window.grazing)),
    ];
    for (name, dash, part) in kinds {
        let points = overlay.windows.iter().filter_map(part);
        let shown = points.filter(|point| (low..=high).contains(&point.parameter));
        for (place, point) in shown.enumerate() {
            let rule = Rule::vertical(point.parameter).color(Color::GREEN);
            let rule = rule.width(EVENT).dash(dash);
            panel.add(match place {
                0 => rule.label(format!("predicted {name}")),
                _ => rule,
            });
        }
    }
}
