//! Theory against simulation: numbers of impacts, and windows over n.

use super::{Advance, Part, Plate, Valve, WIDTH, sweep};
use crate::border::refused;
use crate::failure::Failure;
use crate::numbers::concise;
use crate::parallel;
use chatter::analysis::border::{Prediction, Simulator, WindowComparison};
use chatter::analysis::diagram::{Range, Row, Spec};
use chatter::analysis::map::Map;
use chatter::analysis::universal::UniversalMap;
use chatter_figures::reports::{Block, Column, Grid};
use chatter_figures::{Axis, Color, Figure, Legend, Line, Marker, Markers, Panel};

/// Flow rates at which impacts are counted.
const RATES: [f64; 5] = [0.020_185, 0.020_19, 0.0203, 0.0205, 0.021];
/// Returns passed over and counted there.
const TRANSIENT: u64 = 1000;
const COUNTED: u64 = 500;
/// Windows that are compared: first and last n.
const WINDOWS: (i64, i64) = (19, 44);

/// What orbits settle to: returns a period (0 for none), impacts a return.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Settled {
    period: u64,
    impacts: f64,
}

impl Settled {
    fn text(self) -> String {
        match self.period {
            _ if self.impacts.is_infinite() => "complete chatter".to_owned(),
            0 => format!("{} (chaos)", concise(self.impacts, 4)),
            1 => format!("{}", self.impacts),
            period => format!("{} (period {period})", concise(self.impacts, 4)),
        }
    }
}

fn settle(map: &dyn Map, parameter: &str, value: f64, observe: &str) -> Result<Row, Failure> {
    let range = Range::linear(parameter, value, value, 1);
    let spec = Spec::new(range, observe, TRANSIENT, COUNTED);
    let (_, mut rows) = sweep(map, &spec, &|_| {})?;
    rows.pop()
        .ok_or_else(|| Failure::input("a sweep without values"))
}

fn simulated(valve: &Valve, q: f64) -> Result<Settled, Failure> {
    let row = settle(&valve.map, "q", q, "y2")?;
    Ok(Settled {
        period: row.period,
        impacts: row.impacts_per_return,
    })
}

/// n + 1 impacts for an x = K z + mu on lap n: the first impact and n more.
fn predicted(map: &UniversalMap<f64>) -> Result<Settled, Failure> {
    let row = settle(map, "mu", map.offset(), "z")?;
    let recent = match row.period {
        0 => row.samples.len(),
        period => period as usize,
    };
    let last = &row.samples[row.samples.len() - recent..];
    let impacts = last.iter().map(|z| {
        let x = map.slope() * z + map.offset();
        map.universal().at(x).lap + 1.0
    });
    Ok(Settled {
        period: row.period,
        impacts: impacts.sum::<f64>() / recent as f64,
    })
}

/// A window of the valve, beside the prediction with either coefficients.
struct Compared {
    exact: WindowComparison,
    leading_order: WindowComparison,
}

/// Fold, period doubling and graze.
type Values = [Option<f64>; 3];

/// What is compared.
const KINDS: [(&str, Color); 3] = [
    ("fold", Color::GREEN),
    ("period doubling", Color::VERMILION),
    ("graze", Color::BLUE),
];

impl Compared {
    /// Values of q.
    fn simulated(&self) -> Values {
        let ends = self.exact.located.ends();
        ends.map(|found| Some(found?.value))
    }
}

/// By how much a prediction misses the distance from the border.
fn off(valve: &Valve, window: &WindowComparison) -> Values {
    window.discrepancy(valve.border.value.value).ends()
}

fn compare(valve: &Valve) -> Result<Vec<Compared>, Failure> {
    let simulator = Simulator::new(&valve.model, &valve.spec, &valve.border).map_err(refused)?;
    let exact = Prediction::exact(&valve.border).map_err(refused)?;
    let leading_order = Prediction::leading_order(&valve.border).map_err(refused)?;
    let (first, last) = WINDOWS;
    let windows = simulator.compare(&exact, first, last).into_iter();
    let compared = windows.map(|exact| Compared {
        exact,
        leading_order: WindowComparison {
            predicted: leading_order.window(exact.predicted.lap),
            ..exact
        },
    });
    Ok(compared.collect())
}

/// Share of the first table in the time that all takes.
const COUNTING: f64 = 0.2;

/// Tables and figure.
pub fn report(valve: &Valve, advance: &Advance) -> Result<Part, Failure> {
    let impacts = impacts_table(valve)?;
    advance(COUNTING);
    let remark = Block::Paragraph(
        "The paper counts 36 collisions on the periodic orbits near $q = 0.02019$: its sequence follows the first impact, which \
         is counted here, and there are 37 from release to release. With the exact coefficients the map predicts the number of impacts that simulation has; with the coefficients of \
         leading order it does not. They take $C$ and $D$ from $u = \\beta q y_2 / (\\delta - y_3)^2$ at the first impact, \
         where $\\delta - y_3 = 0.55$ is not small, and so they depend on which impact is called the first and on the \
         section $y_3 = 10.1$; the exact ones depend on neither."
            .to_owned(),
    );
    let compared = compare(valve)?;
    advance(1.0 - COUNTING);
    let plate = discrepancy(valve, &compared);
    Ok(Part {
        blocks: vec![
            impacts.into(),
            remark,
            windows_table(valve, &compared).into(),
            plate.picture().into(),
        ],
        plate,
    })
}

fn impacts_table(valve: &Valve) -> Result<Grid, Failure> {
    let mut grid = Grid::new(
        "Table 2",
        format!(
            "Impacts from release to release, over {COUNTED} returns after {TRANSIENT}: simulated, and predicted by \
             $z \\to \\Upsilon(K z + M (q - q^*))$ with exact and with leading-order coefficients."
        ),
        [
            Column::numbers("$q$"),
            Column::numbers("simulated"),
            Column::numbers("exact"),
            Column::numbers("leading order"),
        ],
    );
    let rows = parallel::each(&RATES, |&q| {
        Ok([
            format!("{q}"),
            simulated(valve, q)?.text(),
            predicted(&valve.exact_at(q)?)?.text(),
            predicted(&valve.leading_order_at(q)?)?.text(),
        ])
    })?;
    rows.into_iter().for_each(|row| grid.add(row));
    Ok(grid)
}

fn windows_table(valve: &Valve, compared: &[Compared]) -> Grid {
    let mut columns = vec![Column::numbers("$n$")];
    for (name, _) in KINDS {
        columns.push(Column::numbers(format!("{name}: simulated")));
        columns.push(Column::numbers("exact"));
        columns.push(Column::numbers("leading order"));
    }
    let mut grid = Grid::new(
        "Table 3",
        "Windows of the orbits with one passage and $n + 1$ impacts a period: $q$ at which the valve's own orbits, by \
         Newton's method from impact to impact, have multiplier 1 and −1, and at which their \
         last impact grazes; and by how much of $q - q^*$ the predictions miss it.",
        columns,
    );
    for window in compared {
        let mut cells = vec![window.exact.predicted.lap.to_string()];
        let missing = || "–".to_owned();
        let simulated = window.simulated();
        let misses = [&window.exact, &window.leading_order].map(|window| off(valve, window));
        for kind in 0..KINDS.len() {
            cells.push(simulated[kind].map_or_else(missing, |q| format!("{q:.10}")));
            cells.extend(misses.iter().map(|miss| {
                miss[kind].map_or_else(missing, |off| format!("{:+.3} \\%", 100.0 * off))
            }));
        }
        grid.add(cells);
    }
    grid
}

fn discrepancy(valve: &Valve, compared: &[Compared]) -> Plate {
    type Part = fn(&Compared) -> &WindowComparison;
    let panel = |part: Part, named: bool| {
        let mut panel = Panel::new(
            Axis::new("$n$"),
            Axis::new("miss, part of $q - q^*$").logarithmic(),
        );
        for (kind, (name, color)) in KINDS.into_iter().enumerate() {
            let (n, miss): (Vec<f64>, Vec<f64>) = (compared.iter())
                .filter_map(|window| {
                    let window = part(window);
                    let miss = off(valve, window)[kind]?;
                    Some((window.predicted.lap as f64, miss.abs()))
                })
                .unzip();
            panel.add(Line::new(n.clone(), miss.clone()).color(color).width(0.5));
            let discs = Markers::new(n, miss)
                .marker(Marker::Disc)
                .size(3.0)
                .color(color);
            panel.add(if named { discs.label(name) } else { discs });
        }
        panel.legend(if named { Legend::Auto } else { Legend::Hidden })
    };
    Plate {
        name: "theory",
        label: "Fig. B",
        caption: "By how much the predicted windows of Table 3 miss those of the valve, as a part of their distance from \
                  the border: with exact coefficients, (a), and with those of leading order, (b). The exact map is the \
                  first term of an expansion, and its miss shrinks by a nearly constant factor, somewhat below \
                  $\\lambda$, from $n$ to $n + 1$; the miss of \
                  the leading order tends to a constant."
            .to_owned(),
        figure: Figure::new()
            .panel(panel(|window| &window.exact, true))
            .panel(panel(|window| &window.leading_order, false))
            .columns(2)
            .width(WIDTH)
            .title("Theory against simulation"),
    }
}
