//! Where panels, ticks and labels are: margins from the extents of texts, so that nothing overlaps.

use crate::axis::{Limits, Placed};
use crate::color::Color;
use crate::figure_error::FigureError;
use crate::labels::text::{SetText, line_extent};
use crate::legend::{self, Entry, Legend};
use crate::panel::Panel;
use crate::scene::Rect;
use crate::ticks::{Notation, Ticks};

/// Sizes of text and lengths, in points.
pub(crate) const TICK_TEXT: f64 = 7.0;
pub(crate) const LABEL_TEXT: f64 = 8.0;
/// Smallest size to which a long label shrinks.
const LEAST_TEXT: f64 = 5.0;
pub(crate) const TICK: f64 = 2.8;
pub(crate) const MINOR_TICK: f64 = 1.6;
pub(crate) const TICK_GAP: f64 = 2.0;
pub(crate) const LABEL_GAP: f64 = 3.2;
pub(crate) const SPINE: f64 = 0.5;
pub(crate) const ROW_GAP: f64 = 3.0;
/// Colour bar: distance from the panel, and width.
pub(crate) const BAR_GAP: f64 = 6.0;
pub(crate) const BAR: f64 = 6.5;
/// Between panels side by side and below each other.
const COLUMN_GAP: f64 = 9.0;
const LINE_GAP: f64 = 6.0;
/// Round the whole figure.
const EDGE: f64 = 1.5;
/// Least side of a panel.
const LEAST_SIDE: f64 = 18.0;
/// Ticks are at least about so far apart.
const X_SPACING: f64 = 24.0;
const Y_SPACING: f64 = 13.0;
/// Edges of panels lie on whole pixels at 300 per inch and at its multiples, so that pictures are not resampled.
const PIXEL: f64 = 72.0 / 300.0;

/// A panel with all that its layout depends on.
pub(crate) struct Plan<'a> {
    pub(crate) panel: &'a Panel,
    pub(crate) x: Limits,
    pub(crate) y: Limits,
    /// Limits of the colour scale, if it has one.
    pub(crate) bar: Option<Limits>,
    pub(crate) bar_label: String,
    pub(crate) colors: Vec<Color>,
    pub(crate) entries: Vec<Entry>,
    pub(crate) legend: Legend,
    pub(crate) letter: Option<String>,
    /// Whether numbers and label stand at the horizontal axis.
    pub(crate) x_numbers: bool,
}

impl Plan<'_> {
    /// Widens the shorter axis of a panel with equal units until a unit is as long along both; whether it had to be.
    pub(crate) fn widen(&mut self, frame: &Frame) -> bool {
        let Rect {
            left,
            top,
            right,
            bottom,
        } = frame.inner;
        let (x_unit, y_unit) = (
            (self.x.high - self.x.low) / (right - left),
            (self.y.high - self.y.low) / (bottom - top),
        );
        let unit = x_unit.max(y_unit);
        if !self.panel.equal || (x_unit - y_unit).abs() <= 1e-9 * unit || !unit.is_finite() {
            return false;
        }
        for (axis, length) in [(&mut self.x, right - left), (&mut self.y, bottom - top)] {
            let middle = 0.5 * axis.low + 0.5 * axis.high;
            let half = 0.5 * unit * length;
            (axis.low, axis.high) = (middle - half, middle + half);
        }
        true
    }
}

/// Set texts of one axis.
pub(crate) struct AxisText {
    pub(crate) ticks: Ticks,
    pub(crate) numbers: Vec<SetText>,
    pub(crate) notation: Option<SetText>,
    /// Whether the notation stands in the row of the label (of a horizontal axis). Decided when margins are measured.
    pub(crate) notation_beside_label: bool,
    pub(crate) label: SetText,
}

impl AxisText {
    fn new(ticks: Ticks, label: &str, length: f64) -> Result<Self, FigureError> {
        let numbers = ticks
            .major
            .iter()
            .map(|t| SetText::new(&t.label, TICK_TEXT))
            .collect::<Result<_, _>>()?;
        let notation = ticks
            .notation
            .as_deref()
            .map(|n| SetText::new(n, TICK_TEXT))
            .transpose()?;
        let label = within(label, length)?;
        Ok(AxisText {
            ticks,
            numbers,
            notation_beside_label: !label.is_empty()
                && notation
                    .as_ref()
                    .is_none_or(|n| 0.5 * (length - label.width) >= n.width + 4.0),
            notation,
            label,
        })
    }

    fn widest(&self) -> f64 {
        self.numbers.iter().map(|n| n.width).fold(0.0, f64::max)
    }

    pub(crate) fn above(&self) -> f64 {
        self.numbers.iter().map(|n| n.above).fold(0.0, f64::max)
    }

    fn below(&self) -> f64 {
        self.numbers.iter().map(|n| n.below).fold(0.0, f64::max)
    }

    /// Depth of the row of numbers below a horizontal axis.
    pub(crate) fn number_row(&self) -> f64 {
        TICK + TICK_GAP + self.above() + self.below()
    }

    /// Width of ticks and numbers beside a vertical axis.
    fn number_column(&self) -> f64 {
        if self.numbers.is_empty() {
            TICK
        } else {
            TICK + TICK_GAP + self.widest()
        }
    }

    fn label_room(&self) -> f64 {
        if self.label.is_empty() {
            0.0
        } else {
            LABEL_GAP + self.label.height()
        }
    }
}

/// A label, set smaller if need be to fit into the length of its side.
fn within(label: &str, length: f64) -> Result<SetText, FigureError> {
    let text = SetText::new(label, LABEL_TEXT)?;
    if text.width <= length {
        return Ok(text);
    }
    SetText::new(label, (LABEL_TEXT * length / text.width).max(LEAST_TEXT))
}

/// A panel with its place and the texts round it.
pub(crate) struct Frame {
    /// Between the spines.
    pub(crate) inner: Rect,
    /// With everything round it; letters and labels stand at its edges.
    pub(crate) outer: Rect,
    pub(crate) x: Placed,
    pub(crate) y: Placed,
    pub(crate) x_text: AxisText,
    pub(crate) y_text: AxisText,
    pub(crate) bar_text: Option<AxisText>,
    pub(crate) title: Option<SetText>,
    pub(crate) letter: Option<SetText>,
    pub(crate) rows: TopRows,
}

/// Heights of what stands above a panel, from the frame upwards.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TopRows {
    /// Notations of the vertical axis and the colour bar.
    pub(crate) notation: f64,
    pub(crate) legend: f64,
    /// Letter and title.
    pub(crate) header: f64,
    /// Whether letter and title stand beside the rows below them.
    pub(crate) header_beside: bool,
}

#[derive(Debug, Clone, Copy, Default)]
struct Margins {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Ticks as many as fit without touching: `room` is the length that a number needs along the axis.
fn fitting(
    limits: &Limits,
    length: f64,
    spacing: f64,
    label: &str,
    notation: Notation,
    room: impl Fn(&SetText) -> f64,
) -> Result<AxisText, FigureError> {
    let mut most = ((length / spacing) as usize).clamp(1, 8);
    loop {
        let text = AxisText::new(limits.ticks(most, notation), label, length)?;
        let placed = limits.place(0.0, length);
        let places: Vec<f64> = text.ticks.major.iter().map(|t| placed.at(t.at)).collect();
        let clear = (1..places.len()).all(|k| {
            let needed = 0.5 * (room(&text.numbers[k - 1]) + room(&text.numbers[k]));
            (places[k] - places[k - 1]).abs() >= needed
        });
        if clear {
            return Ok(text);
        }
        if most == 1 {
            return Ok(thinned(text, &places, room));
        }
        most -= 1;
    }
}

/// Without the numbers that would touch those before them.
fn thinned(mut text: AxisText, places: &[f64], room: impl Fn(&SetText) -> f64) -> AxisText {
    let mut last: Option<(f64, f64)> = None;
    let mut kept = Vec::new();
    for (k, number) in text.numbers.iter().enumerate() {
        let needed = room(number);
        let touches =
            last.is_some_and(|(place, before)| (places[k] - place).abs() < 0.5 * (before + needed));
        if !touches {
            last = Some((places[k], needed));
            kept.push(k);
        }
    }
    let mut bare = Vec::new();
    for k in (0..text.numbers.len()).rev() {
        if !kept.contains(&k) {
            bare.push(text.ticks.major.remove(k).at);
            text.numbers.remove(k);
        }
    }
    text.ticks.minor.extend(bare);
    text
}

/// A frame without its place, and the margins it asks for.
struct Measured {
    x_text: AxisText,
    y_text: AxisText,
    bar_text: Option<AxisText>,
    title: Option<SetText>,
    letter: Option<SetText>,
    rows: TopRows,
    margins: Margins,
}

fn measure(plan: &Plan, width: f64, height: f64, left: f64) -> Result<Measured, FigureError> {
    let panel = plan.panel;
    let x_label = if plan.x_numbers {
        panel.x.full_label()
    } else {
        String::new()
    };
    let level = |n: &SetText| n.height() + 3.0;
    let texts =
        |notation: Notation| -> Result<(AxisText, AxisText, Option<AxisText>), FigureError> {
            let mut x = fitting(&plan.x, width, X_SPACING, &x_label, notation, |n| {
                n.width + 9.0
            })?;
            if !plan.x_numbers {
                x.numbers.clear();
                x.ticks.powers = false;
                x.notation = None;
            }
            let label = panel.y.full_label();
            let y = fitting(&plan.y, height, Y_SPACING, &label, notation, level)?;
            let bar = plan
                .bar
                .as_ref()
                .map(|limits| fitting(limits, height, Y_SPACING, &plan.bar_label, notation, level));
            Ok((x, y, bar.transpose()?))
        };
    let mut set = texts(Notation::Plain)?;
    let (x, y, bar) = &set;
    if x.ticks.powers || y.ticks.powers || bar.as_ref().is_some_and(|bar| bar.ticks.powers) {
        // One notation a panel.
        set = texts(Notation::Powers)?;
    }
    let (x_text, y_text, bar_text) = set;
    let title = panel
        .title
        .as_deref()
        .map(|t| within(t, width))
        .transpose()?;
    let letter = plan
        .letter
        .as_deref()
        .map(|t| SetText::new(t, LABEL_TEXT))
        .transpose()?;

    // Below: numbers, then the label with the notation at its right, or below the notation if they would touch.
    let mut bottom = if x_text.numbers.is_empty() {
        TICK
    } else {
        x_text.number_row()
    };
    if let Some(notation) = x_text
        .notation
        .as_ref()
        .filter(|_| !x_text.notation_beside_label)
    {
        bottom += ROW_GAP + notation.height();
    }
    bottom += x_text.label_room();

    // Right: half of the last number, colour bar, legend.
    let x_placed = plan.x.place(0.0, width);
    let overhang = |end: f64| {
        let ends = x_text.ticks.major.iter().zip(&x_text.numbers);
        ends.map(|(t, n)| {
            if end > 0.0 {
                x_placed.at(t.at) + 0.5 * n.width - end
            } else {
                0.5 * n.width - x_placed.at(t.at)
            }
        })
        .fold(0.0, f64::max)
    };
    let mut side = 0.0;
    if let Some(bar) = &bar_text {
        let beside = BAR + bar.number_column() + bar.label_room();
        let notation = bar.notation.as_ref().map_or(0.0, |n| n.width);
        side += BAR_GAP + beside.max(notation);
    }
    if plan.legend == Legend::Right && !plan.entries.is_empty() {
        side += BAR_GAP + legend::stacked_size(&plan.entries).0;
    }
    let right = overhang(width).max(side).max(SPINE);
    let left_needed = (y_text.number_column() + y_text.label_room()).max(overhang(0.0));

    // Numbers at the upper end of a vertical axis reach above the frame, those with exponents farther.
    let (cap, _) = line_extent(TICK_TEXT);
    let protruding = |text: &AxisText, limits: &Limits| {
        let placed = limits.place(height, 0.0);
        let ends = text.ticks.major.iter().zip(&text.numbers);
        ends.map(|(t, n)| n.above - 0.5 * cap - placed.at(t.at))
            .fold(0.0, f64::max)
    };
    let above_frame = protruding(&y_text, &plan.y);
    let bar_above_frame = match (&bar_text, &plan.bar) {
        (Some(text), Some(limits)) => protruding(text, limits),
        _ => 0.0,
    };

    let mut rows = TopRows::default();
    let notations = y_text
        .notation
        .iter()
        .chain(bar_text.iter().filter_map(|b| b.notation.as_ref()));
    rows.notation = notations.map(|n| n.height() + ROW_GAP).fold(0.0, f64::max);
    if plan.legend == Legend::Above && !plan.entries.is_empty() {
        rows.legend = legend::flowed_height(&plan.entries, width) + 1.0;
    }
    if title.is_some() || letter.is_some() {
        let extent = |t: &Option<SetText>| t.as_ref().map_or(0.0, SetText::height);
        rows.header = extent(&title).max(extent(&letter)) + ROW_GAP.max(above_frame + 1.0);
        // Letter left of the spine, notation and legend right of it, title in the middle.
        let notation_end = y_text.notation.as_ref().map_or(0.0, |n| n.width + 4.0);
        let letter_fits = letter
            .as_ref()
            .is_none_or(|l| l.width + 4.0 <= left.max(left_needed));
        let bar_notation = bar_text.as_ref().is_some_and(|b| b.notation.is_some());
        let title_fits = title.as_ref().is_none_or(|t| {
            0.5 * (width - t.width) >= notation_end && rows.legend == 0.0 && !bar_notation
        });
        rows.header_beside = letter_fits && title_fits;
    }
    let top = if rows.header_beside {
        (rows.notation + rows.legend).max(rows.header)
    } else {
        rows.notation + rows.legend + rows.header
    };
    Ok(Measured {
        margins: Margins {
            left: left_needed,
            right,
            top: top.max(above_frame).max(bar_above_frame).max(SPINE),
            bottom,
        },
        x_text,
        y_text,
        bar_text,
        title,
        letter,
        rows,
    })
}

/// Figure size and arrangement.
pub(crate) struct Page<'a> {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) columns: usize,
    pub(crate) heights: &'a [f64],
    /// Size in millimetres, for the error message.
    pub(crate) millimetres: (f64, f64),
}

/// Passes of measuring: margins depend on ticks, ticks on the room that margins leave.
const PASSES: usize = 4;

/// Places all panels. Spines of panels above each other and beside each other are in line.
pub(crate) fn arrange(page: &Page, plans: &[Plan]) -> Result<Vec<Frame>, FigureError> {
    let columns = page.columns;
    let rows = plans.len().div_ceil(columns);
    let weights: Vec<f64> = (0..rows)
        .map(|r| page.heights.get(r).copied().unwrap_or(1.0))
        .collect();
    let too_small = || FigureError::TooSmall {
        width: page.millimetres.0,
        height: page.millimetres.1,
    };
    let mut widths = vec![page.width / columns as f64 - 40.0; columns];
    let mut heights = vec![page.height / rows as f64 - 25.0; rows];
    let mut lefts = vec![0.0; columns];
    for pass in 1.. {
        let measured = plans
            .iter()
            .enumerate()
            .map(|(k, plan)| {
                let (row, column) = (k / columns, k % columns);
                measure(
                    plan,
                    widths[column].max(LEAST_SIDE),
                    heights[row].max(LEAST_SIDE),
                    lefts[column],
                )
            })
            .collect::<Result<Vec<_>, _>>()?;
        let column_margin = |column: usize, side: fn(&Margins) -> f64| {
            measured
                .iter()
                .skip(column)
                .step_by(columns)
                .map(|m| side(&m.margins))
                .fold(0.0, f64::max)
        };
        let row_margin = |row: usize, side: fn(&Margins) -> f64| {
            measured[row * columns..]
                .iter()
                .take(columns)
                .map(|m| side(&m.margins))
                .fold(0.0, f64::max)
        };
        lefts = (0..columns).map(|c| column_margin(c, |m| m.left)).collect();
        let rights: Vec<f64> = (0..columns)
            .map(|c| column_margin(c, |m| m.right))
            .collect();
        let tops: Vec<f64> = (0..rows).map(|r| row_margin(r, |m| m.top)).collect();
        let bottoms: Vec<f64> = (0..rows).map(|r| row_margin(r, |m| m.bottom)).collect();

        let around_x: f64 = lefts.iter().chain(&rights).sum::<f64>()
            + COLUMN_GAP * (columns - 1) as f64
            + 2.0 * EDGE;
        let around_y: f64 =
            tops.iter().chain(&bottoms).sum::<f64>() + LINE_GAP * (rows - 1) as f64 + 2.0 * EDGE;
        let width = (page.width - around_x) / columns as f64;
        let total_weight: f64 = weights.iter().sum();
        widths = vec![width; columns];
        heights = weights
            .iter()
            .map(|w| (page.height - around_y) * w / total_weight)
            .collect();
        let fits = |sides: &[f64]| sides.iter().all(|&s| s >= LEAST_SIDE);
        if pass < PASSES {
            continue;
        }
        if !(fits(&widths) && fits(&heights)) {
            return Err(too_small());
        }
        let mut frames = Vec::with_capacity(plans.len());
        let mut corner_y = EDGE;
        let mut measured = measured.into_iter();
        for row in 0..rows {
            let mut corner_x = EDGE;
            for column in 0..columns {
                let Some(m) = measured.next() else { break };
                let plan = &plans[row * columns + column];
                let snap = |v: f64| (v / PIXEL).round() * PIXEL;
                let inner = Rect::new(
                    snap(corner_x + lefts[column]),
                    snap(corner_y + tops[row]),
                    snap(corner_x + lefts[column] + widths[column]),
                    snap(corner_y + tops[row] + heights[row]),
                );
                let outer = Rect::new(
                    corner_x,
                    corner_y,
                    corner_x + lefts[column] + widths[column] + rights[column],
                    corner_y + tops[row] + heights[row] + bottoms[row],
                );
                frames.push(Frame {
                    x: plan.x.place(inner.left, inner.right),
                    y: plan.y.place(inner.bottom, inner.top),
                    inner,
                    outer,
                    x_text: m.x_text,
                    y_text: m.y_text,
                    bar_text: m.bar_text,
                    title: m.title,
                    letter: m.letter,
                    rows: m.rows,
                });
                corner_x = outer.right + COLUMN_GAP;
            }
            corner_y += tops[row] + heights[row] + bottoms[row] + LINE_GAP;
        }
        return Ok(frames);
    }
    unreachable!("the last pass returns")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::*;
    use proptest::prelude::*;

    /// Ink of a text on the page.
    fn ink(run: &GlyphRun) -> Rect {
        let mut ink = Rect::new(
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        );
        for g in &run.glyphs {
            let Some(em) = g.face.ink(g.id) else { continue };
            for (x, y) in [(em[0], em[1]), (em[2], em[3])] {
                let (x, y) = (g.x + x * g.size, g.y + y * g.size);
                let (x, y) = match run.turn {
                    Turn::None => (run.x + x, run.y + y),
                    Turn::Left => (run.x + y, run.y - x),
                };
                ink = Rect::new(
                    ink.left.min(x),
                    ink.top.min(y),
                    ink.right.max(x),
                    ink.bottom.max(y),
                );
            }
        }
        ink
    }

    fn texts(scene: &Scene) -> Vec<(String, Rect)> {
        let runs = scene.all().filter_map(|item| match item {
            Primitive::Text(run) => Some((run.source.clone(), ink(run))),
            _ => None,
        });
        runs.filter(|(_, r)| r.left <= r.right).collect()
    }

    /// A range of some size somewhere, on some scale.
    fn axis() -> impl Strategy<Value = Axis> {
        let label = prop_oneof![Just("$q$"), Just("displacement $\\ddot{y}_1^2$"), Just("")];
        (
            label,
            -6.0..6.0f64,
            -8.0..6.0f64,
            any::<bool>(),
            any::<bool>(),
        )
            .prop_map(|(label, centre, width, log, reversed)| {
                let axis = Axis::new(label);
                let axis = if reversed { axis.reversed() } else { axis };
                if log {
                    let low = 10f64.powf(centre);
                    axis.logarithmic()
                        .range(low, low * 10f64.powf(0.1 + width.abs()))
                } else {
                    axis.range(centre * 10.0, centre * 10.0 + 10f64.powf(width))
                }
            })
    }

    fn panel() -> impl Strategy<Value = Panel> {
        let title = prop_oneof![Just(None), Just(Some("A title"))];
        let legend = prop_oneof![
            Just(Legend::Auto),
            Just(Legend::Right),
            Just(Legend::Above),
            Just(Legend::UpperLeft)
        ];
        (axis(), axis(), title, legend, 0..3u8).prop_map(|(x, y, title, legend, kind)| {
            let panel = Panel::new(x, y).legend(legend);
            let panel = match title {
                Some(title) => panel.title(title),
                None => panel,
            };
            let line = Line::new(vec![0.0, 1.0, 2.0], vec![1.0, 3.0, 2.0]);
            match kind {
                0 => panel.with(line),
                1 => panel
                    .with(line.clone().label("computed $u^*$"))
                    .with(line.label("measured")),
                _ => panel.with(
                    HeatMap::new(
                        vec![0.5, 1.5],
                        vec![0.5, 1.5],
                        vec![1e-9, 2e-9, 0.0, f64::NAN],
                    )
                    .axis(Axis::new("exponent $\\lambda$")),
                ),
            }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn no_two_texts_touch_and_none_leaves_the_page(
            panels in proptest::collection::vec(panel(), 1..5),
            columns in 1usize..3,
            shared in any::<bool>(),
        ) {
            // Shared axes are of one scale.
            let same = panels.iter().all(|p| p.x.scale == panels[0].x.scale);
            let mut figure = Figure::new()
                .columns(columns)
                .width(90.0 * columns as f64)
                .height(60.0 * panels.len() as f64)
                .sharing(if shared && same { Sharing::Horizontal } else { Sharing::Nothing });
            for panel in panels {
                figure = figure.panel(panel);
            }
            let scene = figure.scene(Resolution(72.0)).unwrap();
            let page = Rect::new(0.0, 0.0, scene.width, scene.height);
            let texts = texts(&scene);
            for (k, (name, rect)) in texts.iter().enumerate() {
                prop_assert!(
                    page.contains(rect.left, rect.top) && page.contains(rect.right, rect.bottom),
                    "`{name}` at {rect:?} leaves {page:?}"
                );
                for (other, place) in &texts[..k] {
                    prop_assert!(!rect.meets(place), "`{name}` at {rect:?} touches `{other}` at {place:?}");
                }
            }
        }
    }

    #[test]
    fn a_figure_without_room_is_refused() {
        let figure = Figure::from(Panel::new(Axis::new("$x$"), Axis::new("$y$")));
        let error = figure
            .clone()
            .width(8.0)
            .scene(Resolution::PRINT)
            .unwrap_err();
        assert!(matches!(error, FigureError::TooSmall { width, .. } if width == 8.0));
        assert!(
            figure
                .clone()
                .height(f64::NAN)
                .scene(Resolution::PRINT)
                .is_err()
        );
        assert!(matches!(
            figure.scene(Resolution(1e6)),
            Err(FigureError::TooLarge { .. })
        ));
        assert_eq!(
            Figure::new().scene(Resolution::PRINT),
            Err(FigureError::Empty)
        );
    }

    #[test]
    fn spines_of_panels_are_in_line_and_on_whole_pixels() {
        let wide = Panel::new(Axis::new("$x$"), Axis::new("$y$").range(1000.0, 9000.0));
        let narrow = Panel::new(Axis::new("$x$"), Axis::new("").range(0.0, 1.0)).title("title");
        let figure = Figure::new().columns(2).width(178.0);
        let figure = figure
            .panel(wide.clone())
            .panel(narrow.clone())
            .panel(narrow)
            .panel(wide);
        let scene = figure.scene(Resolution::PRINT).unwrap();
        let frames: Vec<Rect> = scene
            .all()
            .filter_map(|item| match item {
                Primitive::Path {
                    path,
                    stroke: Some(_),
                    ..
                } => match path.0[..] {
                    [
                        Segment::Move(l, t),
                        _,
                        Segment::Line(r, b),
                        _,
                        Segment::Close,
                    ] => Some(Rect::new(l, t, r, b)),
                    _ => None,
                },
                _ => None,
            })
            .collect();
        assert_eq!(frames.len(), 4);
        assert_eq!(
            (frames[0].left, frames[0].right),
            (frames[2].left, frames[2].right)
        );
        assert_eq!(
            (frames[0].top, frames[0].bottom),
            (frames[1].top, frames[1].bottom)
        );
        for edge in [frames[0].left, frames[3].top, frames[3].right] {
            let pixels = edge / 72.0 * 300.0;
            assert!((pixels - pixels.round()).abs() < 1e-9);
        }
    }
}
