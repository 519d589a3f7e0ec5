//! A cobweb: the map, the diagonal and an orbit between them.

use super::picture::{LAP_POINTS, label};
use chatter::analysis::universal::UniversalMap;
use chatter_figures::{Axis, Color, Figure, Legend, Line, Panel};
use chatter_files::tables::{Dataset, Table};

/// Steps of the orbit that are passed over, and shown.
const TRANSIENT: usize = 200;
const STEPS: usize = 100;
/// Room around the orbit, as a part of its extent.
const ROOM: f64 = 0.4;
/// In millimetres.
const SIZE: f64 = 110.0;

/// The curve of the map around an orbit that has settled.
#[derive(Clone, Debug, PartialEq)]
pub struct Cobweb {
    /// From where to where, in z.
    pub range: (f64, f64),
    /// z, and the next z.
    pub curve: (Vec<f64>, Vec<f64>),
    /// z of the orbit, one after the other.
    pub orbit: Vec<f64>,
    /// What map it is.
    about: String,
}

impl Cobweb {
    /// Follows the map.
    pub fn new(map: &UniversalMap<f64>) -> Self {
        let settled = (0..TRANSIENT).fold(0.0, |z, _| map.step(z));
        let steps = core::iter::successors(Some(settled), |&z| Some(map.step(z)));
        let orbit: Vec<f64> = steps.take(STEPS + 1).collect();
        let low = orbit.iter().copied().fold(f64::INFINITY, f64::min);
        let high = orbit.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let extent = if high > low {
            high - low
        } else {
            low.abs().max(1e-3)
        };
        let (low, high) = (low - ROOM * extent, high + ROOM * extent);
        let points = 4 * LAP_POINTS;
        let at = |k: i32| low + (high - low) * f64::from(k) / f64::from(points);
        Self {
            range: (low, high),
            curve: (0..=points).map(|k| (at(k), map.step(at(k)))).unzip(),
            orbit,
            about: format!(
                "r = {}, K = {}, mu = {}",
                map.universal().constants().restitution,
                map.slope(),
                map.offset()
            ),
        }
    }

    /// Drawn.
    pub fn figure(&self) -> Figure {
        let (low, high) = self.range;
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for pair in self.orbit.windows(2) {
            x.extend([pair[0], pair[0]]);
            y.extend([pair[0], pair[1]]);
        }
        if let Some(&last) = self.orbit.last() {
            x.push(last);
            y.push(last);
        }
        let panel = Panel::new(
            Axis::new(label("z")).range(low, high),
            Axis::new("$\\Upsilon(K z + \\mu)$").range(low, high),
        )
        .with(
            Line::new(vec![low, high], vec![low, high])
                .color(Color::GREY)
                .width(0.4),
        )
        .with(
            Line::new(self.curve.0.clone(), self.curve.1.clone())
                .color(Color::INK)
                .width(0.8),
        )
        .with(Line::new(x, y).color(Color::VERMILION).width(0.4))
        .legend(Legend::Hidden);
        Figure::from(panel)
            .width(SIZE)
            .height(SIZE)
            .title("Cobweb")
            .caption(format!(
                "Cobweb of z -> Upsilon(K z + mu), {}. Made by chatter {}.",
                self.about,
                env!("CARGO_PKG_VERSION")
            ))
    }

    /// As tables: each z of the orbit with the next one, and the curve.
    pub fn dataset(&self) -> Dataset {
        let pairs = self.orbit.windows(2);
        let (z, next): (Vec<f64>, Vec<f64>) = pairs.map(|pair| (pair[0], pair[1])).unzip();
        let orbit = Table::new("orbit").column("z", z).column("next", next);
        let curve = Table::new("curve")
            .column("curve_z", self.curve.0.clone())
            .column("curve_next", self.curve.1.clone());
        Dataset::new().table(orbit).table(curve)
    }
}
