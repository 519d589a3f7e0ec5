//! How lambda, eta and the exponent depend on the restitution.

use super::{Part, Plate, WIDTH};
use chatter::analysis::universal::Constants;
use chatter_figures::reports::{Column, Grid};
use chatter_figures::{Axis, Color, Dash, Figure, Legend, Line, Panel, Rule};

/// Restitutions of the curves, and of the table.
const CURVE_POINTS: u32 = 600;
const LISTED: [f64; 9] = [0.001, 0.1, 0.2, 0.4, 0.5, 0.6, 0.8, 0.9, 0.99];

/// Figure and table.
pub fn report() -> Part {
    let at = |r: f64| Constants::new(r).ok();
    let constants: Vec<Constants<f64>> = (1..CURVE_POINTS)
        // Crowded at zero, where all curves are steep.
        .filter_map(|k| {
            let share = f64::from(k) / f64::from(CURVE_POINTS);
            at(share * share)
        })
        .collect();
    let curve = |part: fn(&Constants<f64>) -> f64, color| {
        let restitutions = constants.iter().map(|c| c.restitution).collect();
        Line::new(restitutions, constants.iter().map(part).collect()).color(color)
    };
    let r = || Axis::new("restitution $r$").range(0.0, 1.0);
    let multipliers = Panel::new(r(), Axis::new("multipliers").range(0.0, 1.0))
        .with(curve(|c| c.lambda, Color::BLUE).label("$\\lambda$"))
        .with(curve(|c| c.eta, Color::VERMILION).label("$\\eta$"))
        .with(
            curve(|c| c.lambda * c.lambda, Color::GREY)
                .dash(Dash::Dashed)
                .label("$\\lambda^2$"),
        )
        .legend(Legend::Above);
    let exponent = Panel::new(r(), Axis::new("$\\log \\lambda^2 / \\log \\eta$"))
        .with(curve(|c| c.exponent, Color::BLUE))
        .with(Rule::horizontal(1.2).width(0.4))
        .legend(Legend::Hidden);
    let plate = Plate {
        name: "restitution",
        label: "Fig. A",
        caption: "Multipliers of the chatter map at its fixed point, (a), and the exponent with which $\\Upsilon(x)$ \
                  grows, (b), over the restitution: closed forms. $\\lambda^2 < \\eta < \\lambda$ for every $r$, and the \
                  exponent falls from 2 to 6/5 (dashed): a border orbit is always stable."
            .to_owned(),
        figure: Figure::new()
            .panel(multipliers)
            .panel(exponent)
            .columns(2)
            .width(WIDTH)
            .title("Constants over the restitution"),
    };
    let mut grid = Grid::new(
        "Table A",
        "The same in numbers.",
        [
            Column::numbers("$r$"),
            Column::numbers("$u^*$"),
            Column::numbers("$\\lambda$"),
            Column::numbers("$\\eta$"),
            Column::numbers("exponent"),
        ],
    );
    for constants in LISTED.into_iter().filter_map(at) {
        grid.add([
            format!("{}", constants.restitution),
            format!("{:.12}", constants.chatter_fixed_point),
            format!("{:.12}", constants.lambda),
            format!("{:.12}", constants.eta),
            format!("{:.12}", constants.exponent),
        ]);
    }
    let mut part = Part::from(plate);
    part.blocks.push(grid.into());
    part
}
