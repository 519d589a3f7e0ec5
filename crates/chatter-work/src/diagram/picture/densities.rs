//! Samples over one parameter, as densities; as discs where there are few.

use super::discs::Discs;
use super::layers::Layers;
use super::line_fit::LineFit;
use super::window::{Abscissa, SPARSE, Window};
use super::{Shear, View};
use crate::diagram::Source;
use crate::diagram::tally::Tally;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Range, Sweep};
use chatter::expressions::tex_name;
use chatter_figures::{Axis, Density, Grain, Legend, Normalisation, Panel, Scale};

/// Cells of a density, of which there is at most one along the horizontal axis for each parameter value: finer ones are not
/// told apart in print.
const COLUMNS: u64 = 2048;
const ROWS: usize = 1200;

/// Fewer values than these are few for a part of a diagram.
pub const FEW: u64 = 150;

/// The samples of few values are shown as dots, of which so many would stand side by side and above each other: as wide as they
/// are high. As cells they would be dashes.
const DOTS: (u64, usize) = (SPARSE, 300);

/// Room above and below the samples, as a part of their extent.
const ROOM: f64 = 0.03;

/// Samples that follow a straight line as closely as this (squared correlation) form a narrow band.
const NARROW: f64 = 0.98;

/// Panels one above the other.
pub struct Densities {
    /// One for each observed quantity that is shown.
    pub panels: Vec<Panel>,
    /// Whether the samples form a narrow slanted band.
    pub slanted: bool,
    /// How many values of the parameter are shown.
    pub shown: u64,
}

/// Draws the samples of a diagram over one parameter. `axis` labels the swept parameter and observed quantities.
pub fn densities(
    sweep: &Sweep,
    range: &Range,
    axis: &dyn Fn(&str) -> Axis,
    source: &mut dyn Source,
    view: &View,
) -> Result<Densities, Refusal> {
    let window = Window::new(range, view.zoom(&range.name()))?;
    let tally = match sweep.compares() {
        true => Some(Tally::of(source)?),
        false => None,
    };
    let layers = Layers::new(sweep, tally.as_ref());
    let mut shown = Vec::new();
    for (place, observed) in sweep.spec().observe.iter().enumerate() {
        if view.observe.is_empty() || view.observe.contains(&observed.name) {
            shown.push(Shown {
                place,
                name: &observed.name,
                fit: LineFit::default(),
                slope: 0.0,
                low: f64::INFINITY,
                high: f64::NEG_INFINITY,
            });
        }
    }
    let mut abscissa = Abscissa::new(sweep);
    let mut visible = |source: &mut dyn Source, visit: &mut dyn FnMut(u64, f64, &[f64])| {
        source.samples(&mut |row, sample| {
            let x = abscissa.of(row);
            if window.holds(x) {
                visit(row, x, sample);
            }
        })
    };
    visible(source, &mut |_, x, sample| {
        for one in &mut shown {
            one.fit.add(x - window.low, sample[one.place]);
        }
    })?;
    for one in &mut shown {
        one.slope = match view.shear {
            None => 0.0,
            Some(Shear::Slope(slope)) => slope,
            Some(Shear::Fitted) => one.fit.slope(),
        };
    }
    visible(source, &mut |_, x, sample| {
        for one in &mut shown {
            let y = one.level(x - window.low, sample);
            if y.is_finite() {
                (one.low, one.high) = (one.low.min(y), one.high.max(y));
            }
        }
    })?;
    let (columns, rows, grain) = match window.count {
        // An odd number of cells for each value: the dot is in the middle.
        few if window.is_sparse() => (few * ((DOTS.0 / few.max(1)) | 1), DOTS.1, Grain::Points),
        count => (count.min(COLUMNS), ROWS, Grain::Smooth),
    };
    let mut drawn = Vec::new();
    for one in shown {
        let extent = one.extent(view)?;
        let densities = layers.layers.iter().map(|layer| {
            Density::new(window.cells, extent)
                .normalisation(Normalisation::Column)
                .color(layer.color)
                .label(&layer.name)
                .grain(grain)
                .cells(columns as usize, rows)
                .scales(window.scale, Scale::Linear)
        });
        let densities: Vec<Density> = densities.collect();
        let discs = Discs::new(window.is_sparse(), layers.layers.len(), extent);
        drawn.push((one, densities, discs));
    }
    visible(source, &mut |row, x, sample| {
        for (one, densities, discs) in &mut drawn {
            let (layer, y) = (layers.of(row), one.level(x - window.low, sample));
            densities[layer].add(x, y);
            discs.add(layer, (row, x, y));
        }
    })?;
    let level = view.shear.is_some();
    let slanted = !level && drawn.iter().any(|(one, ..)| one.fit.quality() > NARROW);
    let panel = |(place, (one, densities, discs)): (usize, (Shown, Vec<Density>, Discs))| {
        let (low, high) = discs.extent;
        let y = one.axis(axis, range, window.low).range(low, high);
        let panel = Panel::new(window.on(axis(&range.name())), y);
        // One legend for all panels.
        let legend = match (densities.len(), place) {
            (2.., 0) => Legend::Above,
            _ => Legend::Hidden,
        };
        let layered = match discs.markers(&layers) {
            Some(markers) => markers.into_iter().fold(panel, Panel::with),
            None => densities.into_iter().fold(panel, Panel::with),
        };
        layered.legend(legend)
    };
    Ok(Densities {
        panels: drawn.into_iter().enumerate().map(panel).collect(),
        shown: window.count,
        slanted,
    })
}

/// An observed quantity that is shown.
struct Shown<'a> {
    place: usize,
    name: &'a str,
    fit: LineFit,
    slope: f64,
    low: f64,
    high: f64,
}

impl Shown<'_> {
    /// The sheared quantity, so far from where the figure begins.
    fn level(&self, along: f64, sample: &[f64]) -> f64 {
        sample[self.place] - self.slope * along
    }

    /// From where to where the vertical axis goes.
    fn extent(&self, view: &View) -> Result<(f64, f64), Refusal> {
        let (low, high) = (self.low, self.high);
        match view.zoom(self.name) {
            Some((from, to)) if to < low || high < from => Err(Refusal::input(format!(
                "there is no sample of `{}` from {from} to {to}: they lie from {low} to {high}",
                self.name
            ))),
            Some(zoom) => Ok(zoom),
            None => Ok(padded(low, high)),
        }
    }

    /// The vertical axis: what is observed, less what the shear subtracts.
    fn axis(&self, axis: &dyn Fn(&str) -> Axis, range: &Range, from: f64) -> Axis {
        if self.slope == 0.0 {
            return axis(self.name);
        }
        let sign = if self.slope < 0.0 { '+' } else { '-' };
        let size = self.slope.abs();
        let parameter = tex_name(&range.name());
        let origin = crate::numbers::concise(from, 6);
        Axis::new(format!(
            "${} {sign} {size}\\,({parameter} - {origin})$",
            tex_name(self.name)
        ))
    }
}

/// Largest values that are drawn: differences and squares of pixels stay finite. Whatever lies beyond is none of what an
/// orbit settles to.
const LARGEST: f64 = 1e300;

fn padded(low: f64, high: f64) -> (f64, f64) {
    if low > high {
        return (0.0, 1.0);
    }
    let (low, high) = (low.clamp(-LARGEST, LARGEST), high.clamp(-LARGEST, LARGEST));
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
