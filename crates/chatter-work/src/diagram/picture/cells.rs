//! Maps over two parameters: a cell for each pair of values.

use super::layers::Layers;
use super::window::Window;
use super::{Show, View};
use crate::diagram::tally::Tally;
use crate::diagram::{Class, Source};
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Outcome, Range, Sweep};
use chatter_figures::{Axis, Category, CategoryMap, Color, Colormap, HeatMap, Legend, Panel};

/// Periods that have a colour of their own.
const PERIODS: [(u64, &str, Color); 6] = [
    (1, "period 1", Color::BLUE),
    (2, "period 2", Color::SKY),
    (3, "period 3", Color::GREEN),
    (4, "period 4", Color::PURPLE),
    (8, "period 5 to 8", Color::ORANGE),
    (u64::MAX, "longer period", Color::rgb(240, 228, 66)),
];

const COMPLETE_CHATTER: (Outcome, &str, Color) =
    (Outcome::CompleteChatter, "complete chatter", Color::NIGHT);

/// What else orbits settle to. Chaos is pale, since it is most of many maps and the periods are what is looked for.
const OTHERS: [(Outcome, &str, Color); 9] = [
    (Outcome::Chaotic, "chaotic", Color::rgb(250, 222, 200)),
    (
        Outcome::Quasiperiodic,
        "quasi-periodic",
        Color::rgb(204, 236, 214),
    ),
    COMPLETE_CHATTER,
    (Outcome::Unsettled, "unsettled", Color::rgb(190, 190, 190)),
    (Outcome::NoReturn, "no return", Color::rgb(235, 235, 235)),
    (
        Outcome::LeftDomain,
        "left the domain",
        Color::rgb(120, 80, 60),
    ),
    (Outcome::NoStart, "no start", Color::WHITE),
    (Outcome::Undetermined, "undetermined", Color::BLACK),
    (Outcome::NotFinite, "not finite", Color::rgb(160, 60, 120)),
];

/// Most cells of a map: more than any page or screen shows, and some hundred bytes each.
const MOST_CELLS: u64 = 10_000_000;

/// Whether a map of so many cells can be drawn.
pub fn check_cells(across: u64, up: u64) -> Result<(), Refusal> {
    match across.checked_mul(up) {
        Some(0..=MOST_CELLS) => Ok(()),
        _ => Err(Refusal::input(format!(
            "a map of {across} by {up} cells cannot be drawn: at most {MOST_CELLS} can"
        ))
        .help("chatter plot FILE.npz --zoom NAME=FROM:TO draws a part")),
    }
}

/// Draws the map. `axis` labels the swept parameters.
pub fn panel(
    sweep: &Sweep,
    ranges: [&Range; 2],
    axis: &dyn Fn(&str) -> Axis,
    source: &mut dyn Source,
    view: &View,
) -> Result<Panel, Refusal> {
    let [first, second] = ranges;
    let windows = [
        Window::new(first, view.zoom(&first.name()))?,
        Window::new(second, view.zoom(&second.name()))?,
    ];
    let inside = |range: &Range, window: &Window| -> Vec<u64> {
        let holds = |index: &u64| window.holds(range.value(*index));
        (0..range.count).filter(holds).collect()
    };
    let places = [inside(first, &windows[0]), inside(second, &windows[1])];
    let values = |range: &Range, places: &[u64]| -> Vec<f64> {
        places.iter().map(|&index| range.value(index)).collect()
    };
    check_cells(places[0].len() as u64, places[1].len() as u64)?;
    let grid = (values(first, &places[0]), values(second, &places[1]));
    let starts = sweep.rows() / (first.count * second.count);
    let show = view.shown(sweep.spec());
    let layers = match show {
        Show::Attractor => Some(Layers::by_attractor(&Tally::of(source)?)),
        _ => None,
    };
    let mut classes = vec![None; grid.0.len() * grid.1.len()];
    let mut colors = vec![None; grid.0.len() * grid.1.len()];
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
            classes[j * grid.0.len() + i] = Some(*class);
            colors[j * grid.0.len() + i] = layers.as_ref().map(|layers| layers.of(row));
        }
    })?;
    let axis = |range: &Range, window: &Window| {
        let mut axis = axis(&range.name()).tight();
        axis.scale = window.scale;
        axis
    };
    let panel = Panel::new(axis(first, &windows[0]), axis(second, &windows[1]));
    Ok(match show {
        Show::Attractor => {
            let layers = layers.into_iter().flat_map(|layers| layers.layers);
            let categories = layers.map(|layer| Category::new(layer.name, layer.color));
            panel.with(CategoryMap::new(
                grid.0,
                grid.1,
                colors,
                categories.collect(),
            ))
        }
        Show::Period => panel.with(outcomes(grid, &classes)),
        Show::Impacts => {
            let bar = Axis::new("impacts per return").tight().whole();
            numbers(panel, grid, &classes, Colormap::Sequential, bar, |class| {
                class.impacts_per_return
            })
        }
        Show::Exponent => {
            let bar = Axis::new("largest Lyapunov exponent").tight();
            let colors = Colormap::Diverging { centre: 0.0 };
            numbers(panel, grid, &classes, colors, bar, |class| class.exponent)
        }
    })
}

/// Cells whose numbers are infinite, beside colours of both scales.
const INFINITE: Color = Color::rgb(205, 205, 205);

/// Middles of the cells along both axes.
type Grid = (Vec<f64>, Vec<f64>);

/// Numbers as colours; cells of complete chatter, whose numbers are infinite, as a category of their own.
fn numbers(
    panel: Panel,
    grid: Grid,
    classes: &[Option<Class>],
    colors: Colormap,
    bar: Axis,
    number: fn(&Class) -> f64,
) -> Panel {
    let of = |class: &Option<Class>| class.as_ref().map_or(f64::NAN, number);
    let values: Vec<f64> = classes.iter().map(of).collect();
    let map = HeatMap::new(grid.0.clone(), grid.1.clone(), values).colormap(colors);
    let panel = panel.with(map.axis(bar));
    let (chatter, name, _) = COMPLETE_CHATTER;
    let infinite = |class: &Option<Class>| {
        let chatters = class.is_some_and(|class| class.outcome == chatter);
        (chatters && of(class).is_infinite()).then_some(0)
    };
    let cells: Vec<Option<usize>> = classes.iter().map(infinite).collect();
    if cells.iter().all(Option::is_none) {
        return panel;
    }
    let categories = vec![Category::new(name, INFINITE)];
    panel
        .with(CategoryMap::new(grid.0, grid.1, cells, categories))
        .legend(Legend::Above)
}

/// What orbits settle to, in colours.
fn outcomes(grid: Grid, classes: &[Option<Class>]) -> CategoryMap {
    let all = PERIODS.iter().map(|&(_, name, color)| (name, color));
    let all = all.chain(OTHERS.iter().map(|&(_, name, color)| (name, color)));
    let kind = |class: &Class| match class.outcome {
        Outcome::Periodic => PERIODS
            .iter()
            .position(|&(up_to, ..)| class.period <= up_to),
        outcome => OTHERS
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
    CategoryMap::new(grid.0, grid.1, renumbered, categories)
}
