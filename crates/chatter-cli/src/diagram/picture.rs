//! A diagram as a figure: densities of samples over one parameter, maps over two.

use super::job::Job;
use super::source::Source;
use crate::failure::Failure;
use crate::simulation::picture::axis_of;
use chatter::analysis::diagram::{Outcome, Range, Record, Spacing, Sweep};
use chatter::expressions::tex_name;
use chatter::model::Model;
use chatter_io::figures::{
    Axis, Category, CategoryMap, Color, Colormap, Density, Figure, HeatMap, Normalisation, Panel,
    Scale, Sharing,
};
use serde::{Deserialize, Serialize};

/// Width of the figure, and height of a panel, in millimetres.
const WIDTH: f64 = 178.0;
const PANEL_HEIGHT: f64 = 105.0;

/// A density has about as many cells as samples, so that bands of chaos are neither speckled nor blurred: between these
/// numbers, three along the horizontal axis for two along the vertical one, and at most one a parameter value.
const FEWEST_CELLS: u64 = 900 * 600;
const MOST_CELLS: u64 = 2400 * 1600;

/// Room above and below the samples, as a part of their extent.
const ROOM: f64 = 0.03;

/// Periods that have a colour of their own in a map over two parameters.
const PERIODS: [(u64, &str, Color); 6] = [
    (1, "period 1", Color::BLUE),
    (2, "period 2", Color::SKY),
    (3, "period 3", Color::GREEN),
    (4, "period 4", Color::PURPLE),
    (8, "period 5 to 8", Color::ORANGE),
    (u64::MAX, "longer period", Color::rgb(240, 228, 66)),
];

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
    /// What a map over two parameters shows.
    pub show: Show,
}

/// A figure and what to say about it.
pub struct Picture {
    /// The figure.
    pub figure: Figure,
    /// Whether the samples form a narrow slanted band, of which a shear would show more.
    pub slanted: bool,
}

/// What to say of such a figure.
pub const SLANTED: &str = "the samples lie in a narrow slanted band; --shear auto levels it\n";

/// Samples that follow a straight line as closely as this (squared correlation) form a narrow band.
const NARROW: f64 = 0.98;

/// Draws a finished diagram.
pub fn draw(
    job: &Job,
    model: &Model,
    sweep: &Sweep,
    source: &mut dyn Source,
    view: &View,
) -> Result<Picture, Failure> {
    let artist = Artist {
        job,
        model,
        sweep,
        view,
    };
    artist.check()?;
    let (figure, slanted) = match &job.diagram.sweeps[..] {
        [range] => artist.densities(range, source)?,
        [first, second, ..] => (artist.map(first, second, source)?, false),
        [] => (Figure::new(), false),
    };
    let title = model.title.as_deref().unwrap_or(&job.model);
    Ok(Picture {
        figure: figure
            .title(format!("Orbit diagram: {title}"))
            .caption(artist.caption(title)),
        slanted,
    })
}

struct Artist<'a> {
    job: &'a Job,
    model: &'a Model,
    sweep: &'a Sweep,
    view: &'a View,
}

impl Artist<'_> {
    fn check(&self) -> Result<(), Failure> {
        let spec = &self.job.diagram;
        let swept: Vec<&str> = spec.sweeps.iter().map(|range| &*range.parameter).collect();
        let observed: Vec<&str> = spec.observe.iter().map(|one| &*one.name).collect();
        for name in &self.view.observe {
            known(name, &observed, "observed")?;
        }
        let axes: Vec<&str> = match swept.len() {
            1 => swept.iter().chain(&observed).copied().collect(),
            _ => swept,
        };
        for zoom in &self.view.zooms {
            known(&zoom.name, &axes, "on an axis")?;
            let ordered = zoom.from < zoom.to && zoom.from.is_finite() && zoom.to.is_finite();
            if !ordered {
                return Err(Failure::input(format!(
                    "--zoom {}={}:{} shows nothing: expected two finite numbers, the smaller first",
                    zoom.name, zoom.from, zoom.to
                )));
            }
        }
        if spec.sweeps.len() == 1 && spec.record == Record::Classes {
            return Err(Failure::input(
                "the diagram has no samples to be drawn: it was computed with --record classes",
            ));
        }
        Ok(())
    }

    fn zoom(&self, name: &str) -> Option<(f64, f64)> {
        let zooms = self.view.zooms.iter();
        let mut named = zooms.filter(|zoom| zoom.name == name);
        named.next().map(|zoom| (zoom.from, zoom.to))
    }

    /// Label and unit of a parameter or of an observed quantity.
    fn axis(&self, name: &str) -> Axis {
        let parameters = self.model.parameters.iter();
        let states = self.model.states.iter();
        let labels = parameters
            .map(|parameter| (&parameter.name, &parameter.label))
            .chain(states.map(|state| (&state.name, &state.label)));
        let mut same = labels.filter(|(known, _)| *known == name);
        match same.next() {
            Some((_, label)) => axis_of(name, label.as_ref()),
            None => axis_of(name, None),
        }
    }

    fn densities(&self, range: &Range, source: &mut dyn Source) -> Result<(Figure, bool), Failure> {
        let window = Window::new(range, self.zoom(&range.parameter))?;
        let shown: Vec<usize> = (0..self.job.diagram.observe.len())
            .filter(|&place| {
                let name = &self.job.diagram.observe[place].name;
                self.view.observe.is_empty() || self.view.observe.contains(name)
            })
            .collect();
        let mut abscissa = Abscissa::new(self.sweep);
        let mut fits = vec![Fit::default(); shown.len()];
        source.samples(&mut |row, sample| {
            let x = abscissa.of(row);
            if window.holds(x) {
                for (fit, &place) in fits.iter_mut().zip(&shown) {
                    fit.add(x - window.low, sample[place]);
                }
            }
        })?;
        let slopes: Vec<f64> = match self.view.shear {
            None => vec![0.0; shown.len()],
            Some(Shear::Slope(slope)) => vec![slope; shown.len()],
            Some(Shear::Fitted) => fits.iter().map(Fit::slope).collect(),
        };
        let slanted = self.view.shear.is_none() && fits.iter().any(|fit| fit.quality() > NARROW);
        let level = |x: f64, y: f64, slope: f64| y - slope * (x - window.low);
        let mut extents = vec![(f64::INFINITY, f64::NEG_INFINITY); shown.len()];
        let mut count: u64 = 0;
        source.samples(&mut |row, sample| {
            let x = abscissa.of(row);
            if window.holds(x) {
                count += 1;
                for ((extent, &place), &slope) in extents.iter_mut().zip(&shown).zip(&slopes) {
                    let y = level(x, sample[place], slope);
                    if y.is_finite() {
                        *extent = (extent.0.min(y), extent.1.max(y));
                    }
                }
            }
        })?;
        let across = (count.clamp(FEWEST_CELLS, MOST_CELLS) as f64 / 6.0).sqrt();
        let (columns, rows) = ((3.0 * across) as u64, (2.0 * across) as usize);
        let mut densities = Vec::new();
        for (&(low, high), &place) in extents.iter().zip(&shown) {
            let name = &self.job.diagram.observe[place].name;
            let y = self.zoom(name).unwrap_or_else(|| padded(low, high));
            let density = Density::new(window.cells, y)
                .normalisation(Normalisation::Column)
                .cells(window.count.min(columns) as usize, rows)
                .scales(window.scale, Scale::Linear);
            densities.push(density);
        }
        source.samples(&mut |row, sample| {
            let x = abscissa.of(row);
            if window.holds(x) {
                for ((density, &place), &slope) in densities.iter_mut().zip(&shown).zip(&slopes) {
                    density.add(x, level(x, sample[place], slope));
                }
            }
        })?;
        let mut figure = Figure::new();
        for ((density, &place), &slope) in densities.into_iter().zip(&shown).zip(&slopes) {
            let x = window.on(self.axis(&range.parameter));
            let y = self.vertical(place, slope, range, window.low);
            figure = figure.panel(Panel::new(x, y.tight()).with(density));
        }
        let height = PANEL_HEIGHT * shown.len() as f64;
        let figure = figure
            .width(WIDTH)
            .height(height)
            .sharing(Sharing::Horizontal);
        Ok((figure, slanted))
    }

    /// The vertical axis: what is observed, less what the shear subtracts.
    fn vertical(&self, place: usize, slope: f64, range: &Range, from: f64) -> Axis {
        let name = &self.job.diagram.observe[place].name;
        if slope == 0.0 {
            return self.axis(name);
        }
        let sign = if slope < 0.0 { '+' } else { '-' };
        let size = slope.abs();
        let parameter = tex_name(&range.parameter);
        let origin = crate::numbers::concise(from, 6);
        Axis::new(format!(
            "${} {sign} {size}\\,({parameter} - {origin})$",
            tex_name(name)
        ))
    }

    fn map(
        &self,
        first: &Range,
        second: &Range,
        source: &mut dyn Source,
    ) -> Result<Figure, Failure> {
        let windows = [
            Window::new(first, self.zoom(&first.parameter))?,
            Window::new(second, self.zoom(&second.parameter))?,
        ];
        let inside = |range: &Range, window: &Window| -> Vec<u64> {
            let holds = |index: &u64| window.holds(range.value(*index));
            (0..range.count).filter(holds).collect()
        };
        let places = [inside(first, &windows[0]), inside(second, &windows[1])];
        let values = |range: &Range, places: &[u64]| -> Vec<f64> {
            places.iter().map(|&index| range.value(index)).collect()
        };
        let (x, y) = (values(first, &places[0]), values(second, &places[1]));
        let starts = self.sweep.rows() / (first.count * second.count);
        let mut classes = vec![None; x.len() * y.len()];
        source.classes(&mut |row, class| {
            // Of several starts the first is shown.
            let column = row / starts;
            let place = |k: usize, index: u64| places[k].binary_search(&index).ok();
            if row % starts == 0
                && let (Some(i), Some(j)) = (
                    place(0, column % first.count),
                    place(1, column / first.count),
                )
            {
                classes[j * x.len() + i] = Some(*class);
            }
        })?;
        let axis = |range: &Range, window: &Window| {
            let mut axis = self.axis(&range.parameter).tight();
            axis.scale = window.scale;
            axis
        };
        let horizontal = axis(first, &windows[0]);
        let vertical = axis(second, &windows[1]);
        let panel = Panel::new(horizontal, vertical);
        let number = |value: fn(&super::Class) -> f64| -> Vec<f64> {
            let values = classes
                .iter()
                .map(|class| class.as_ref().map_or(f64::NAN, value));
            values.collect()
        };
        let panel = match self.view.show {
            Show::Period => panel.with(periods(x, y, &classes)),
            Show::Impacts => panel.with(
                HeatMap::new(x, y, number(|class| class.impacts_per_return))
                    .axis(Axis::new("impacts per return").tight()),
            ),
            Show::Exponent => panel.with(
                HeatMap::new(x, y, number(|class| class.exponent))
                    .colormap(Colormap::Diverging { centre: 0.0 })
                    .axis(Axis::new("largest Lyapunov exponent").tight()),
            ),
        };
        Ok(Figure::from(panel).width(WIDTH).height(PANEL_HEIGHT * 1.1))
    }

    fn caption(&self, title: &str) -> String {
        let spec = &self.job.diagram;
        let sweeps: Vec<String> = spec
            .sweeps
            .iter()
            .map(|range| {
                format!(
                    "{} values of {} from {} to {}",
                    range.count, range.parameter, range.from, range.to
                )
            })
            .collect();
        format!(
            "{title} ({}): {}, {} samples each after {}. Made by chatter {}.",
            self.job.model,
            sweeps.join(", "),
            spec.keep,
            spec.transient,
            self.job.version
        )
    }
}

/// What orbits settle to, in colours.
fn periods(x: Vec<f64>, y: Vec<f64>, classes: &[Option<super::Class>]) -> CategoryMap {
    let others = [
        (Outcome::Chaotic, "chaotic", Color::VERMILION),
        (Outcome::CompleteChatter, "complete chatter", Color::NIGHT),
        (Outcome::Unsettled, "unsettled", Color::rgb(190, 190, 190)),
        (Outcome::NoReturn, "no return", Color::rgb(235, 235, 235)),
        (
            Outcome::LeftDomain,
            "left the domain",
            Color::rgb(120, 80, 60),
        ),
        (Outcome::NoStart, "no start", Color::WHITE),
        (Outcome::Undetermined, "undetermined", Color::BLACK),
    ];
    let all = PERIODS.iter().map(|&(_, name, color)| (name, color));
    let all = all.chain(others.iter().map(|&(_, name, color)| (name, color)));
    let kind = |class: &super::Class| match class.outcome {
        Outcome::Periodic => PERIODS
            .iter()
            .position(|&(up_to, ..)| class.period <= up_to),
        outcome => others
            .iter()
            .position(|&(known, ..)| known == outcome)
            .map(|place| PERIODS.len() + place),
    };
    let cells: Vec<Option<usize>> = classes
        .iter()
        .map(|class| class.as_ref().and_then(kind))
        .collect();
    // The legend tells what is to be seen and nothing else.
    let mut seen: Vec<usize> = cells.iter().flatten().copied().collect();
    seen.sort_unstable();
    seen.dedup();
    let categories = all
        .enumerate()
        .filter(|(place, _)| seen.contains(place))
        .map(|(_, (name, color))| Category::new(name, color))
        .collect();
    let renumbered = cells
        .into_iter()
        .map(|cell| cell.and_then(|place| seen.binary_search(&place).ok()))
        .collect();
    CategoryMap::new(x, y, renumbered, categories)
}

/// The parameter values that are shown.
struct Window {
    low: f64,
    high: f64,
    scale: Scale,
    /// How many values there are in it.
    count: u64,
    /// From half a spacing before the first of them to half a spacing after the last, so that each has a cell.
    cells: (f64, f64),
}

impl Window {
    fn new(range: &Range, zoom: Option<(f64, f64)>) -> Result<Self, Failure> {
        let scale = match range.spacing {
            Spacing::Linear => Scale::Linear,
            Spacing::Logarithmic => Scale::Logarithmic,
        };
        let (low, high) = zoom.unwrap_or((range.from, range.to));
        let mut inside =
            (0..range.count).filter(|&index| (low..=high).contains(&range.value(index)));
        let Some(first) = inside.next() else {
            return Err(Failure::input(format!(
                "there is no value of `{}` from {low} to {high}: it was swept from {} to {}",
                range.parameter, range.from, range.to
            )));
        };
        let last = inside.next_back().unwrap_or(first);
        let gaps = (range.count - 1).max(1) as f64;
        let (from, to) = (range.value(first), range.value(last));
        let cells = match range.spacing {
            Spacing::Linear => {
                let half = (range.to - range.from) / gaps / 2.0;
                (from - half, to + half)
            }
            Spacing::Logarithmic => {
                let half = (range.to / range.from).powf(0.5 / gaps);
                (from / half, to * half)
            }
        };
        Ok(Self {
            low,
            high,
            scale,
            count: last - first + 1,
            cells,
        })
    }

    fn holds(&self, x: f64) -> bool {
        (self.low..=self.high).contains(&x)
    }

    /// The axis over just these values.
    fn on(&self, axis: Axis) -> Axis {
        let mut axis = if self.low < self.high {
            axis.range(self.low, self.high)
        } else {
            axis.tight()
        };
        axis.scale = self.scale;
        axis
    }
}

/// The parameter value of the row that samples come from, looked up once a row.
struct Abscissa<'a> {
    sweep: &'a Sweep,
    row: u64,
    x: f64,
}

impl<'a> Abscissa<'a> {
    fn new(sweep: &'a Sweep) -> Self {
        let row = u64::MAX;
        Self { sweep, row, x: 0.0 }
    }

    fn of(&mut self, row: u64) -> f64 {
        if row != self.row {
            self.row = row;
            self.x = self.sweep.values(row)[0];
        }
        self.x
    }
}

fn known(name: &str, known: &[&str], what: &str) -> Result<(), Failure> {
    if known.contains(&name) {
        return Ok(());
    }
    let list = known.join("`, `");
    Err(
        Failure::input(format!("`{name}` is not {what}: there is `{list}`"))
            .did_you_mean(chatter::expressions::nearest(name, known.iter().copied())),
    )
}

fn padded(low: f64, high: f64) -> (f64, f64) {
    if low > high {
        return (0.0, 1.0);
    }
    let extent = high - low;
    let room = if extent > 0.0 {
        extent * ROOM
    } else if low == 0.0 {
        0.5
    } else {
        low.abs() * ROOM
    };
    (low - room, high + room)
}

/// A line through points by least squares.
#[derive(Clone, Copy, Debug, Default)]
struct Fit {
    count: f64,
    mean_x: f64,
    mean_y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Fit {
    /// Welford's updating formulas: no digits are lost where the points are far from zero.
    fn add(&mut self, x: f64, y: f64) {
        if !y.is_finite() {
            return;
        }
        self.count += 1.0;
        let before = (x - self.mean_x, y - self.mean_y);
        self.mean_x += before.0 / self.count;
        self.mean_y += before.1 / self.count;
        self.xx += before.0 * (x - self.mean_x);
        self.xy += before.0 * (y - self.mean_y);
        self.yy += before.1 * (y - self.mean_y);
    }

    /// Squared correlation: one for points on a line.
    fn quality(&self) -> f64 {
        self.xy * self.xy / (self.xx * self.yy)
    }

    /// To four digits, which is what the axis says.
    fn slope(&self) -> f64 {
        let slope = self.xy / self.xx;
        if slope.is_finite() {
            format!("{slope:.3e}").parse().unwrap_or(slope)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted_to_its_slope() {
        let mut fit = Fit::default();
        for k in 0..100 {
            let x = f64::from(k) * 1e-5;
            let noise = if k % 2 == 0 { 1e-9 } else { -1e-9 };
            fit.add(x, 5.0 - 3.25 * x + noise);
        }
        assert_eq!(fit.slope(), -3.25);
        assert!(fit.quality() > 0.999 && fit.quality() <= 1.0 + 1e-12);
        assert_eq!(Fit::default().slope(), 0.0);
    }
}
