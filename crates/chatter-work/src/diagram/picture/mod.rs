//! A diagram as a figure: densities of samples over one parameter, maps over two.

mod cells;
mod densities;
mod discs;
mod layers;
mod line_fit;
mod window;

pub use cells::{check_cells, panel as map_panel};
pub use densities::densities;

use super::source::Source;
use super::watched::Watched;
use crate::observer::Observer;
use crate::refusal::Refusal;
use crate::simulation::picture::axis_of;
use chatter::analysis::diagram::{Exponent, Range, Record, Spec, Sweep, Swept, initial_name};
use chatter::analysis::map::Passage;
use chatter::model::Model;
use chatter_figures::{Axis, Figure, Sharing};
use serde::{Deserialize, Serialize};

/// Width of the figure, and height of a panel, in millimetres.
const WIDTH: f64 = 178.0;
const PANEL_HEIGHT: f64 = 105.0;

/// An affine change of the vertical axis that makes a slanted diagram level: a multiple of the parameter is subtracted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shear {
    /// The slope of the line that fits the samples best.
    Fitted,
    /// This slope.
    Slope(f64),
}

/// A part of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Zoom {
    /// The swept parameter or observed quantity.
    pub name: String,
    /// From where.
    pub from: f64,
    /// To where.
    pub to: f64,
}

/// What a map over two parameters shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Show {
    /// Periods, chaos, complete chatter, and what else orbits settle to.
    #[default]
    Period,
    /// Mean number of impacts from sample to sample.
    Impacts,
    /// The largest Lyapunov exponent.
    Exponent,
    /// Which of the attractors that coexist orbits settle to.
    Attractor,
}

/// How a diagram is looked at.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// Parts of axes.
    pub zooms: Vec<Zoom>,
    /// Shear of the vertical axis.
    pub shear: Option<Shear>,
    /// Observed quantities to be shown; all if there are none.
    pub observe: Vec<String>,
    /// What a map over two parameters shows, if not what is usual for it.
    pub show: Option<Show>,
}

impl View {
    /// What a map shows: of initial values their basins.
    fn shown(&self, spec: &Spec) -> Show {
        let initial = spec
            .sweeps
            .iter()
            .any(|range| range.swept == Swept::Initial);
        let usual = if initial {
            Show::Attractor
        } else {
            Show::Period
        };
        self.show.unwrap_or(usual)
    }

    fn zoom(&self, name: &str) -> Option<(f64, f64)> {
        let mut named = self.zooms.iter().filter(|zoom| zoom.name == name);
        named.next().map(|zoom| (zoom.from, zoom.to))
    }
}

/// A figure and what to say about it.
pub struct Picture {
    /// The figure.
    pub figure: Figure,
    /// Whether the samples form a narrow slanted band, of which a shear would show more.
    pub slanted: bool,
    /// What to say where a part of the parameter's axis is shown in which only few of many values were computed.
    pub few: Option<String>,
}

/// What to say of such a figure.
pub const SLANTED: &str = "the samples lie in a narrow slanted band; --shear auto levels it\n";

/// What a figure says of what it shows.
pub struct Words<'a> {
    /// What the orbits are orbits of.
    pub title: &'a str,
    /// Where that comes from.
    pub origin: &'a str,
    /// What is not swept, as `, q = 1, r = 2`.
    pub parameters: &'a str,
    /// The version that computed it.
    pub version: &'a str,
    /// Labels of parameters and observed quantities.
    pub axis: &'a dyn Fn(&str) -> Axis,
}

impl Words<'_> {
    fn caption(&self, spec: &Spec) -> String {
        let sweeps: Vec<String> = spec
            .sweeps
            .iter()
            .map(|range| {
                format!(
                    "{} values of {} from {} to {}",
                    range.count,
                    range.name(),
                    range.from,
                    range.to
                )
            })
            .collect();
        format!(
            "{} ({}){}: {}, {} samples each after {}. Made by chatter {}.",
            self.title,
            self.origin,
            self.parameters,
            sweeps.join(", "),
            spec.keep,
            spec.transient,
            self.version
        )
    }
}

/// How often the samples of a diagram are gone through: for the slope of their band, for their extent, and to be drawn.
const PASSES: u32 = 3;

/// Draws a finished diagram.
///
/// # Errors
/// The view does not fit it, it cannot be read, or the observer stopped the work.
pub fn draw(
    words: &Words<'_>,
    (sweep, source): (&Sweep, &mut dyn Source),
    view: &View,
    observer: &dyn Observer,
) -> Result<Picture, Refusal> {
    check(sweep, view)?;
    let axis = words.axis;
    let passes = match sweep.spec().sweeps.len() {
        1 => PASSES,
        _ => 1,
    } + u32::from(sweep.compares());
    let source = &mut Watched::new(source, (sweep.rows(), passes), observer);
    let (figure, slanted, few) = match &sweep.spec().sweeps[..] {
        [range] => {
            let drawn = densities(sweep, range, axis, source, view)?;
            let mut figure = Figure::new()
                .width(WIDTH)
                .height(PANEL_HEIGHT * drawn.panels.len() as f64)
                .sharing(Sharing::Horizontal);
            for panel in drawn.panels {
                figure = figure.panel(panel);
            }
            (figure, drawn.slanted, few(range, drawn.shown))
        }
        [first, second, ..] => {
            let panel = cells::panel(sweep, [first, second], axis, source, view)?;
            let figure = Figure::from(panel).width(WIDTH).height(PANEL_HEIGHT * 1.1);
            (figure, false, None)
        }
        [] => (Figure::new(), false, None),
    };
    Ok(Picture {
        figure: figure
            .title(format!(
                "Orbit diagram: {}{}",
                words.title, words.parameters
            ))
            .caption(words.caption(sweep.spec())),
        slanted,
        few,
    })
}

/// What to say of so many values that are shown of a range.
fn few(range: &Range, shown: u64) -> Option<String> {
    let is_part = shown < range.count && shown < densities::FEW;
    is_part.then(|| {
        let values = match shown {
            1 => "value of".to_owned(),
            _ => format!("values of `{}` of", range.name()),
        };
        format!(
            "only {shown} {values} {} that were computed lie in this window; --recompute computes as many in it",
            range.count
        )
    })
}

/// The diagram over the parts of its axes that are shown, in as many values.
pub fn zoomed(spec: &Spec, view: &View) -> Spec {
    let mut spec = spec.clone();
    for range in &mut spec.sweeps {
        if let Some((from, to)) = view.zoom(&range.name()) {
            (range.from, range.to) = (from, to);
        }
    }
    spec
}

/// Checks that a view fits a diagram.
///
/// # Errors
/// A name is on no axis, or what is asked for changes nothing.
pub fn check(sweep: &Sweep, view: &View) -> Result<(), Refusal> {
    let spec = sweep.spec();
    let swept: Vec<String> = spec.sweeps.iter().map(Range::name).collect();
    let swept: Vec<&str> = swept.iter().map(String::as_str).collect();
    let observed: Vec<&str> = spec.observe.iter().map(|one| &*one.name).collect();
    for name in &view.observe {
        known(name, &observed, "observed")?;
    }
    let axes: Vec<&str> = match swept.len() {
        1 => swept.iter().chain(&observed).copied().collect(),
        _ => swept,
    };
    for zoom in &view.zooms {
        known(&zoom.name, &axes, "on an axis")?;
        let ordered = zoom.from < zoom.to && zoom.from.is_finite() && zoom.to.is_finite();
        if !ordered {
            return Err(Refusal::input(format!(
                "--zoom {}={}:{} shows nothing: expected two finite numbers, the smaller first",
                zoom.name, zoom.from, zoom.to
            )));
        }
    }
    let over = match spec.sweeps.len() {
        1 => "one parameter or initial value",
        _ => "two parameters",
    };
    let useless = [
        (
            spec.sweeps.len() == 1 && view.show.is_some_and(|show| show != Show::Period),
            "--show",
        ),
        (spec.sweeps.len() > 1 && view.shear.is_some(), "--shear"),
        (
            spec.sweeps.len() > 1 && !view.observe.is_empty(),
            "--observe",
        ),
    ];
    if let Some((_, option)) = useless.iter().find(|(useless, _)| *useless) {
        return Err(Refusal::input(format!(
            "{option} changes nothing in a diagram over {over}: leave it out"
        )));
    }
    if view.show == Some(Show::Attractor) && !sweep.compares() {
        return Err(Refusal::input(
            "the diagram tells no attractors apart: there is one orbit for each pair of values",
        )
        .help("compute it with --start random:COUNT or carry:both, or sweep initial values"));
    }
    if view.show == Some(Show::Exponent) && spec.exponent == Exponent::Skip {
        return Err(
            Refusal::input("the diagram has no exponents").help("compute it with --exponent")
        );
    }
    if spec.sweeps.len() == 1 && spec.record == Record::Classes {
        return Err(Refusal::input(
            "the diagram has no samples to be drawn: it was computed with --record classes",
        ));
    }
    Ok(())
}

fn known(name: &str, known: &[&str], what: &str) -> Result<(), Refusal> {
    if known.contains(&name) {
        return Ok(());
    }
    let list = known.join("`, `");
    Err(
        Refusal::input(format!("`{name}` is not {what}: there is `{list}`"))
            .did_you_mean(chatter::expressions::nearest(name, known.iter().copied())),
    )
}

/// Label and unit of a parameter of a model or of an observed quantity.
pub fn axis(model: &Model, name: &str) -> Axis {
    let parameters = model.parameters.iter();
    let states = model.states.iter();
    let labels = parameters
        .map(|parameter| (&parameter.name, &parameter.label))
        .chain(states.map(|state| (&state.name, &state.label)));
    let mut same = labels.filter(|(known, _)| *known == name);
    let mut started = (model.states.iter()).filter(|state| initial_name(&state.name) == name);
    match same.next() {
        Some((_, label)) => axis_of(name, label.as_ref()),
        None if let Some(state) = started.next() => {
            let mut axis = axis_of(&state.name, state.label.as_ref());
            axis.label = format!("initial {}", axis.label);
            axis
        }
        None if Passage::NAMES.contains(&name) => {
            let axis = Axis::new(name.replace('_', " "));
            match name {
                "impacts" | "accumulations" => axis.whole(),
                _ => axis,
            }
        }
        None => axis_of(name, None),
    }
}

/// The parameters that are not swept, as `, q = 1, r = 2`.
pub fn parameters(model: &Model, spec: &Spec) -> String {
    let swept = |name: &str| {
        let mut parameters = spec
            .sweeps
            .iter()
            .filter(|range| range.swept == Swept::Parameter);
        parameters.any(|range| range.parameter == name)
    };
    crate::simulation::picture::parameters(model, &|name| !swept(name))
}
