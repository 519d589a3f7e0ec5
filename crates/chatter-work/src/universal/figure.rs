//! The figure that is asked for.

use super::request::{Request, refused};
use super::{Findings, branches, picture};
use crate::diagram::Store;
use crate::options::Counts;
use crate::refusal::Refusal;
use chatter::analysis::universal::{Universal, UniversalMap};
use chatter::numerics::Real;
use chatter_figures::{Axis, Figure, Panel, Sharing};

/// Width of a figure, in millimetres.
const WIDE: f64 = 178.0;
/// Heights of panels below each other, and of a period in that of windows, relative to each other.
const ORBITS_HEIGHT: f64 = 2.0;
const EXPONENT_HEIGHT: f64 = 1.0;
const PERIOD_HEIGHT: f64 = 0.1;
/// Room beside the windows of an atlas, as a part of what they span.
const ATLAS_ROOM: f64 = 0.04;

/// Orbit diagram, cobweb, atlas or Upsilon, whichever was asked for.
///
/// # Errors
/// The samples cannot be read, or the map is none.
pub fn figure<R: Real>(
    request: &Request,
    findings: &Findings<R>,
    samples: Option<&mut Store>,
    universal: &Universal<f64>,
    map: &UniversalMap<f64>,
) -> Result<Figure, Refusal> {
    let made = format!("Made by chatter {}.", env!("CARGO_PKG_VERSION"));
    let about = format!("r = {}", request.restitution.to_f64());
    let map_about = format!("{about}, K = {}", map.slope());
    if let Some(cobweb) = &findings.cobweb {
        return Ok(cobweb.figure());
    }
    let (Some((sweep, rows)), Some(samples)) = (&findings.diagram, samples) else {
        if let Some(laps) = request.windows {
            return atlas(findings, laps, map, &format!("{map_about}. {made}"));
        }
        let [lap, whole] = picture::upsilon_panels(universal);
        let figure = Figure::new().panel(lap).panel(whole).columns(2).width(WIDE);
        let caption =
            format!("The universal function Upsilon, {about}: one lap over Q, all over x.");
        return Ok(figure.title("Upsilon").caption(format!("{caption} {made}")));
    };
    let range = &sweep.spec().sweeps[0];
    let mut caption = format!(
        "Orbits of z -> Upsilon(K z + mu), {map_about}: {} iterates after {} for each of {} values, the last one carried \
         on.",
        request.keep, request.transient, range.count
    );
    let mut orbits = picture::orbit_panel(sweep, samples)?;
    let mut below = Vec::new();
    if let (Some(laps), "mu") = (request.windows, range.parameter.as_str()) {
        let shown = (range.from, range.to);
        branches::fixed_point_layers(&mut orbits, map, laps, shown).map_err(refused)?;
        caption += " Curves: the fixed points, whatever these orbits have settled to.";
        if let Some((panel, longest)) = branches::window_panel(&findings.periodic, shown) {
            below.push((panel, PERIOD_HEIGHT * (longest as f64 + 1.0)));
            caption += " Outlines: intervals in which an orbit of that period is stable.";
        }
    }
    if request.lyapunov {
        below.push((picture::exponent_panel(sweep, rows), EXPONENT_HEIGHT));
    }
    Ok(stacked(orbits, below)
        .title("Orbit diagram")
        .caption(format!("{caption} {made}")))
}

/// A panel above others of these heights.
fn stacked(top: Panel, below: Vec<(Panel, f64)>) -> Figure {
    let figure = Figure::from(top).width(WIDE);
    if below.is_empty() {
        return figure;
    }
    let (panels, heights): (Vec<_>, Vec<f64>) = below.into_iter().unzip();
    let heights: Vec<f64> = core::iter::once(ORBITS_HEIGHT).chain(heights).collect();
    (panels.into_iter().fold(figure, Figure::panel))
        .sharing(Sharing::Horizontal)
        .row_heights(&heights)
}

/// The fixed points on these laps over mu, and under them the windows of other orbits.
fn atlas<R: Real>(
    findings: &Findings<R>,
    laps: Counts,
    map: &UniversalMap<f64>,
    about: &str,
) -> Result<Figure, Refusal> {
    let windows = findings.windows.iter().flatten();
    let ends = windows.flat_map(|window| {
        [
            window.fold,
            window.period_doubling,
            window.superstable,
            window.grazing,
        ]
    });
    let ends = ends.flatten().map(|mu| mu.to_f64());
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mu| {
        (low.min(mu), high.max(mu))
    });
    let room = ATLAS_ROOM * (high - low);
    let shown = (low - room, high + room);
    let mut panel = Panel::new(
        Axis::new(picture::label("mu")).range(shown.0, shown.1),
        Axis::new(picture::label("z")),
    );
    branches::fixed_point_layers(&mut panel, map, laps, shown).map_err(refused)?;
    let below = branches::window_panel(&findings.periodic, shown);
    let below = below.map(|(panel, longest)| (panel, PERIOD_HEIGHT * (longest as f64 + 1.0)));
    Ok(stacked(panel, below.into_iter().collect())
        .title("Atlas of the universal map")
        .caption(format!(
            "Fixed points of z -> Upsilon(K z + mu) and where they are born, double and graze, {about}"
        )))
}
