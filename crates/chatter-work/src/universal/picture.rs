//! The universal map in pictures: Upsilon, orbit diagrams, exponents, cobwebs.

use crate::diagram::picture::densities;
use crate::diagram::{Source, View};
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Row, Sweep};
use chatter::analysis::universal::Universal;
use chatter_figures::{Axis, Color, Legend, Line, Panel, Rule};

/// Points of a curve on one lap: straight lines between them look smooth.
pub const LAP_POINTS: i32 = 400;
/// Thin curves that stand beside each other in ever closer laps.
const FINE: f64 = 0.6;

/// Upsilon on lap 0 over Q, and from zero to the end of lap 0 over x: the panels of Fig. 2.
pub fn upsilon_panels(universal: &Universal<f64>) -> [Panel; 2] {
    let (begin, end) = universal.window();
    let lap = lap_curve(universal, 0);
    let mut x = Vec::new();
    let mut y = Vec::new();
    // Laps that are narrower than a hair are not told apart.
    const NARROWEST: f64 = 1e-4;
    let mut n = 0;
    while lap_end(universal, n) > NARROWEST * end {
        n += 1;
    }
    for n in (0..n).rev() {
        let (lap_x, lap_y) = lap_curve(universal, n);
        x.extend(lap_x);
        y.extend(lap_y);
    }
    let curve = |x, y| Line::new(x, y).color(Color::BLUE).width(FINE);
    [
        Panel::new(
            Axis::new("$Q(u_1, r)$").range(begin, end),
            Axis::new("$(g(u_1, r) - 1/2) P^2(u_1, r)$"),
        )
        .with(curve(lap.0, lap.1))
        .legend(Legend::Hidden),
        Panel::new(
            Axis::new("$x$").range(0.0, end),
            Axis::new("$\\Upsilon(x)$"),
        )
        .with(Rule::horizontal(0.0).width(0.4))
        .with(curve(x, y))
        .legend(Legend::Hidden),
    ]
}

fn lap_end(universal: &Universal<f64>, n: i32) -> f64 {
    (0..n).fold(universal.lap_end(), |x, _| x * universal.constants().eta)
}

fn lap_curve(universal: &Universal<f64>, n: i32) -> (Vec<f64>, Vec<f64>) {
    curve(universal, lap_end(universal, n + 1), lap_end(universal, n))
}

/// Upsilon over x on one lap. Points crowd at its end, where the slope is infinite.
pub fn curve(universal: &Universal<f64>, begin: f64, end: f64) -> (Vec<f64>, Vec<f64>) {
    (0..=LAP_POINTS)
        .rev()
        .map(|k| {
            let share = f64::from(k) / f64::from(LAP_POINTS);
            let x = end - (end - begin) * share * share;
            (x, universal.value(x))
        })
        .unzip()
}

/// An orbit diagram over mu or the slope, drawn as those of flows are.
pub fn orbit_panel(sweep: &Sweep, source: &mut dyn Source) -> Result<Panel, Refusal> {
    let axis = |name: &str| Axis::new(label(name));
    let range = &sweep.spec().sweeps[0];
    let drawn = densities(sweep, range, &axis, source, &View::default())?;
    let none = || Panel::new(axis(&range.name()), axis("z"));
    Ok(drawn.panels.into_iter().next().unwrap_or_else(none))
}

/// What figures call parameters and the coordinate of the map.
pub fn label(name: &str) -> &'static str {
    match name {
        "mu" => "$\\mu$",
        "slope" => "$K$",
        "initial_z" => "initial $z$",
        _ => "$z$",
    }
}

/// Exponents over the parameter.
pub fn exponent_panel(sweep: &Sweep, rows: &[Row]) -> Panel {
    let range = &sweep.spec().sweeps[0];
    let x = label(&range.name());
    let values = rows.iter().map(|row| sweep.values(row.row)[0]).collect();
    let exponents = rows.iter().map(|row| row.exponent).collect();
    Panel::new(
        Axis::new(x).range(range.from, range.to),
        Axis::new("Lyapunov exponent"),
    )
    .with(Rule::horizontal(0.0).width(0.4))
    .with(Line::new(values, exponents).color(Color::BLUE).width(FINE))
    .legend(Legend::Hidden)
}
