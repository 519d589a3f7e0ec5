//! Figs. 5 and 6: the valve itself, beside and under the prediction of the one-dimensional map.

use super::{Advance, Plate, WIDTH, sweep};
use crate::border::refused;
use crate::failure::Failure;
use crate::parallel;
use crate::shipped;
use chatter::analysis::border::{AffineStates, Border, BorderSpec, LeadingOrder, section_states};
use chatter::analysis::border_search::{border_near, leading_order_at};
use chatter::analysis::diagram::{Range, Row, Spec, Start, Sweep};
use chatter::analysis::map::Map;
use chatter::analysis::return_map::{ReturnMap, ReturnSpec};
use chatter::analysis::universal::{Universal, UniversalMap};
use chatter::model::Model;
use chatter_figures::{Axis, Color, Density, Figure, Legend, Line, Normalisation, Panel, Sharing};

/// Where the paper says that the border is.
const NEAR: f64 = 0.02;
/// q* as it is printed.
const PRINTED: f64 = 0.020_056;
/// The model and its section y3 = 9.7.
const MODEL: &str = "pressure_relief_valve";
const SECTION: &str = "closing";
/// The state that is shown, y2, by its place.
const RATE: usize = 1;

/// Fig. 5: from n = 40 or so, whose windows are as wide as a few values of q, to chaos at n = 25.
const WHOLE: (f64, f64) = (0.02012, 0.0212);
/// Fig. 6: one period-doubling sequence, with the end of the chaos of the next larger n at its left.
const ENLARGED: (f64, f64) = (0.02033, 0.020_52);
/// Values of q in either figure.
const COLUMNS: u64 = 1500;
const ENLARGED_COLUMNS: u64 = 1200;
/// Rows of cells of a panel, and the width of lines in points.
const ROWS: usize = 1200;
const EDGE: f64 = 0.5;
/// Returns passed over and kept for each: chaotic orbits need no more, and they cost forty impacts each.
const TRANSIENT: u64 = 150;
const KEPT: u64 = 200;

/// The valve and its border.
pub struct Valve {
    /// The model.
    pub model: Model,
    /// How it was looked for.
    pub spec: BorderSpec,
    /// The border orbit.
    pub border: Border<f64>,
    /// The paper's coefficients at our border.
    pub leading_order: LeadingOrder<f64>,
    /// The same at q = 0.020056.
    pub at_printed: LeadingOrder<f64>,
    /// Upsilon for its restitution.
    pub universal: Universal<f64>,
    /// From one crossing of y3 = 9.7 to the next.
    pub map: ReturnMap,
    /// States on that section: (27) with the flight on to it.
    pub projection: AffineStates,
}

impl Valve {
    /// Finds the border and its normal forms.
    pub fn new() -> Result<Self, Failure> {
        let text = shipped::find(MODEL)
            .map(|shipped| shipped.text)
            .unwrap_or_default();
        let model = Model::from_toml(text, MODEL)?;
        let spec = BorderSpec::new("q");
        let border = border_near::<f64>(&model, &spec, NEAR).map_err(refused)?;
        let leading_order = border
            .leading_order
            .clone()
            .map_err(|section| refused(section.into()))?;
        let at_printed = leading_order_at(&model, &spec, PRINTED).map_err(refused)?;
        let universal = Universal::new(border.constants.restitution).map_err(Failure::input)?;
        let map = ReturnMap::new(&model, &ReturnSpec::section(SECTION)).map_err(Failure::input)?;
        let projection = section_states(&model, &spec, &border, SECTION).map_err(refused)?;
        Ok(Self {
            model,
            spec,
            border,
            leading_order,
            at_printed,
            universal,
            map,
            projection,
        })
    }

    /// y2 on the section, on the orbit from release: Upsilon is zero there. Its bend in q is of second order, but within a
    /// few windows larger than they are.
    pub fn released(&self, q: f64) -> Result<f64, Failure> {
        let parameter = self.model.parameter_index("q").unwrap_or(0);
        let parameters = self.map.parameter_values(&[(parameter, q)]);
        let mut point = self.border.release.state.clone();
        (self.map.next(&parameters, &mut point)).map_err(Failure::input)?;
        Ok(point[RATE])
    }

    /// The one-dimensional map with the exact coefficients, at q.
    pub fn exact_at(&self, q: f64) -> Result<UniversalMap<f64>, Failure> {
        let exact = &self.border.exact;
        self.map_with(exact.slope.value, exact.unfolding_rate.value, q)
    }

    /// The one-dimensional map with the paper's coefficients, at q.
    pub fn leading_order_at(&self, q: f64) -> Result<UniversalMap<f64>, Failure> {
        let form = &self.leading_order;
        self.map_with(form.slope, form.unfolding_rate, q)
    }

    fn map_with(&self, slope: f64, rate: f64, q: f64) -> Result<UniversalMap<f64>, Failure> {
        let mu = rate * (q - self.border.value.value);
        UniversalMap::new(self.universal.clone(), slope, mu).map_err(Failure::input)
    }
}

struct Window {
    range: (f64, f64),
    columns: u64,
}

/// Simulated and predicted orbits over the same q, y2 sheared alike.
fn panels(valve: &Valve, window: &Window, advance: &Advance) -> Result<[Panel; 2], Failure> {
    let (from, to) = window.range;
    let range = Range::linear("q", from, to, window.columns);
    let spec = Spec {
        start: Start::CarryUp,
        chunk: Some(Spec::quick_chunk(window.columns)),
        ..Spec::new(range, "y2", TRANSIENT, KEPT)
    };
    let (simulated, rows) = sweep(&valve.map, &spec, advance)?;

    let border = valve.border.value.value;
    let p = &valve.projection;
    let sheared: Vec<(f64, f64)> = samples(&simulated, &rows)
        .map(|(q, y2)| (q, y2 - p.origin[RATE] - p.by_parameter[RATE] * (q - border)))
        .collect();
    // What is left of q when the shear is taken away: the bend of the orbit with Upsilon = 0.
    let value = |row: &Row| simulated.values(row.row)[0];
    let zeros = parallel::each(&rows, |row| valve.released(value(row)))?;
    let straightened: Vec<(f64, f64)> = (rows.iter().zip(zeros))
        .flat_map(|(row, zero)| {
            let q = value(row);
            row.samples.iter().map(move |y2| (q, y2 - zero))
        })
        .collect();
    let edges = edges(valve, &simulated)?;
    let panel = |label: &str, points: &[(f64, f64)], with_edges: bool| {
        let lines = edges.iter().filter(|_| with_edges);
        let ends = lines
            .clone()
            .flat_map(|&(q, low, high)| [(q, low), (q, high)]);
        let (low, high) = points
            .iter()
            .copied()
            .chain(ends)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, y)| {
                (low.min(y), high.max(y))
            });
        const ROOM: f64 = 0.04;
        let y = (low - ROOM * (high - low), high + ROOM * (high - low));
        let mut panel = Panel::new(
            Axis::new("flow rate $q$").range(from, to),
            Axis::new(label).range(y.0, y.1),
        );
        let mut density = Density::new((from, to), y)
            .cells(window.columns as usize, ROWS)
            .normalisation(Normalisation::Column)
            .color(Color::NIGHT)
            .label("simulated");
        density.extend(points.iter().copied());
        panel.add(density);
        if !with_edges {
            return panel.legend(Legend::Hidden);
        }
        let line = |of: fn(&(f64, f64, f64)) -> f64| {
            let x = edges.iter().map(|edge| edge.0).collect();
            Line::new(x, edges.iter().map(of).collect())
                .color(Color::VERMILION)
                .width(EDGE)
        };
        panel.add(line(|edge| edge.1).label("edges of the predicted orbits"));
        panel.add(line(|edge| edge.2));
        panel.legend(Legend::Above)
    };
    Ok([
        panel("$y_2 - y_2^* - c (q - q^*)$", &sheared, false),
        panel("$y_2 - y_2^0(q)$", &straightened, true),
    ])
}

/// For each q it, and the lowest and the highest of many predicted y2. Extremes of few would be chance.
fn edges(valve: &Valve, sweep: &Sweep) -> Result<Vec<(f64, f64, f64)>, Failure> {
    const MANY: u64 = 4000;
    let by_upsilon = valve.projection.by_upsilon[RATE];
    let rows: Vec<u64> = (0..sweep.rows()).collect();
    parallel::each(&rows, |&row| {
        let q = sweep.values(row)[0];
        let map = valve.exact_at(q)?;
        let mut z = 0.0;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for step in 0..TRANSIENT + MANY {
            z = map.step(z);
            if step >= TRANSIENT {
                (low, high) = (low.min(by_upsilon * z), high.max(by_upsilon * z));
            }
        }
        Ok((q, low, high))
    })
}

fn samples<'a>(sweep: &'a Sweep, rows: &'a [Row]) -> impl Iterator<Item = (f64, f64)> + 'a {
    rows.iter().flat_map(|row| {
        let value = sweep.values(row.row)[0];
        row.samples.iter().map(move |&sample| (value, sample))
    })
}

fn how(valve: &Valve, columns: u64) -> String {
    let p = &valve.projection;
    format!(
        "{columns} values of $q$, {KEPT} returns to the section $y_3 = 9.7$ (falling) after {TRANSIENT} for each, the last \
         state carried on to the next value. In (a) the vertical axis is sheared, as in the paper: $c = {:.5}$ is the \
         slope of $y_2$ over $q$ where $\\Upsilon$ is zero. In (b) $y_2^0(q)$, on the orbit from release at that $q$, is \
         subtracted, and the edges of the predicted orbits lie over the simulation: those of $z \\to \\Upsilon(K z + M (q - q^*))$ with the \
         exact $K = {:.6}$ and $M = {:.8}$, drawn as $y_2 = {:.5} z$. Nothing is fitted.",
        p.by_parameter[RATE],
        valve.border.exact.slope.value,
        valve.border.exact.unfolding_rate.value,
        p.by_upsilon[RATE]
    )
}

/// Simulation above simulation and prediction.
fn stacked([simulated, both]: [Panel; 2], title: &str) -> Figure {
    Figure::new()
        .panel(simulated)
        .panel(both)
        .sharing(Sharing::Horizontal)
        .width(WIDTH)
        .height(WIDTH)
        .title(title)
}

/// The cascade of the valve.
pub fn fig5(valve: &Valve, advance: &Advance) -> Result<Plate, Failure> {
    let window = Window {
        range: WHOLE,
        columns: COLUMNS,
    };
    let panels = panels(valve, &window, advance)?;
    Ok(Plate {
        name: "fig5",
        label: "Fig. 5",
        caption: format!(
            "Orbits of the valve near its border $q^* = {:.9}$, (a): {} ",
            valve.border.value.value,
            how(valve, COLUMNS)
        ),
        figure: stacked(panels, "Fig. 5: orbits of the pressure relief valve"),
    })
}

/// An enlargement of Fig. 5.
pub fn fig6(valve: &Valve, advance: &Advance) -> Result<Plate, Failure> {
    let window = Window {
        range: ENLARGED,
        columns: ENLARGED_COLUMNS,
    };
    let panels = panels(valve, &window, advance)?;
    Ok(Plate {
        name: "fig6",
        label: "Fig. 6",
        caption: format!(
            "Enlargement of Fig. 5, to be compared with Fig. 4: {}",
            how(valve, ENLARGED_COLUMNS)
        ),
        figure: stacked(panels, "Fig. 6: enlargement of Fig. 5"),
    })
}
