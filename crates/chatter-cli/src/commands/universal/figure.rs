//! The figure that `--plot` asks for.

use super::arguments::CobwebOption;
use super::{Arguments, refused};
use crate::failure::Failure;
use crate::universal::{Findings, Window, picture};
use chatter::analysis::universal::{Universal, UniversalMap};
use chatter::numerics::Real;
use chatter_io::figures::{Figure, Sharing};

/// Widths of a figure, in millimetres.
const WIDE: f64 = 178.0;
const NARROW: f64 = 110.0;

/// Orbit diagram, cobweb or Upsilon, whichever was asked for.
pub fn figure<R: Real>(
    arguments: &Arguments,
    findings: &Findings<R>,
    universal: &Universal<f64>,
    map: &UniversalMap<f64>,
) -> Result<Figure, Failure> {
    let made = format!("Made by chatter {}.", env!("CARGO_PKG_VERSION"));
    let about = format!("r = {}", arguments.restitution.to_f64());
    let map_about = format!("{about}, K = {}", map.slope());
    if let Some(CobwebOption(mu)) = arguments.cobweb {
        let map =
            UniversalMap::new(universal.clone(), map.slope(), mu.to_f64()).map_err(refused)?;
        let caption = format!(
            "Cobweb of z -> Upsilon(K z + mu), {map_about}, mu = {}.",
            mu.to_f64()
        );
        let figure = Figure::from(picture::cobweb_panel(&map))
            .width(NARROW)
            .height(NARROW);
        return Ok(figure.title("Cobweb").caption(format!("{caption} {made}")));
    }
    let Some((sweep, rows)) = &findings.diagram else {
        let [lap, whole] = picture::upsilon_panels(universal);
        let figure = Figure::new().panel(lap).panel(whole).columns(2).width(WIDE);
        let caption =
            format!("The universal function Upsilon, {about}: one lap over Q, all over x.");
        return Ok(figure.title("Upsilon").caption(format!("{caption} {made}")));
    };
    let range = &sweep.spec().sweeps[0];
    let mut panel = picture::orbit_panel(sweep, rows)?;
    if let (Some(windows), "mu") = (&findings.windows, range.parameter.as_str()) {
        let windows: Vec<_> = windows.iter().map(Window::rounded).collect();
        picture::period_layers(&mut panel, &findings.periodic, (range.from, range.to));
        picture::window_layers(&mut panel, &windows, (range.from, range.to));
    }
    let mut figure = Figure::from(panel).width(WIDE);
    if arguments.lyapunov {
        let exponents = picture::exponent_panel(sweep, rows);
        figure = figure
            .panel(exponents)
            .sharing(Sharing::Horizontal)
            .row_heights(&[2.0, 1.0]);
    }
    let caption = format!(
        "Orbits of z -> Upsilon(K z + mu), {map_about}: {} iterates after {} for each of {} values, the last one carried \
         on.",
        arguments.keep, arguments.transient, range.count
    );
    Ok(figure
        .title("Orbit diagram")
        .caption(format!("{caption} {made}")))
}
