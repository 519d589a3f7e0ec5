//! Legends: what the colours mean, and where there is room to say so.

use super::color::Color;
use super::figure_error::FigureError;
use super::labels::text::{Align, SetText, line_extent};
use super::layer::{Layer, Marker};
use super::panel::Panel;
use super::scene::{Path, Primitive, Rect, Segment, Stroke};

/// Where a panel's legend is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Legend {
    /// Inside where nothing is drawn; above the panel if there is no such place; beside it for a map.
    #[default]
    Auto,
    /// Nowhere.
    Hidden,
    /// Inside, at the upper right.
    UpperRight,
    /// Inside, at the upper left.
    UpperLeft,
    /// Inside, at the lower right.
    LowerRight,
    /// Inside, at the lower left.
    LowerLeft,
    /// Above the panel.
    Above,
    /// To the right of the panel.
    Right,
}

/// Size of the text in points.
const SIZE: f64 = 7.0;
/// Length of a sample of a line, and room for a marker or swatch where no entry is a line.
const LINE_SAMPLE: f64 = 15.0;
const SMALL_SAMPLE: f64 = 8.0;
/// Space between a sample and its text.
const GAP: f64 = 3.5;
/// From one entry to the next.
const LINE: f64 = 9.6;
/// Between entries side by side.
const BESIDE: f64 = 9.0;
/// From the frame to a legend inside.
const INSET: f64 = 4.0;

/// Sample and text of one entry.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    sample: Sample,
    room: f64,
    text: SetText,
}

#[derive(Debug, Clone)]
enum Sample {
    Stroke(Stroke),
    Marker(Marker, f64, Color),
    Swatch(Color),
}

/// The entries of a panel: labelled layers in order, then categories.
pub(super) fn entries(panel: &Panel, colors: &[Color]) -> Result<Vec<Entry>, FigureError> {
    let mut entries = Vec::new();
    let mut push = |sample: Sample, label: &str| -> Result<(), FigureError> {
        entries.push(Entry {
            sample,
            room: SMALL_SAMPLE,
            text: SetText::new(label, SIZE)?,
        });
        Ok(())
    };
    for (layer, &color) in panel.layers.iter().zip(colors) {
        let stroke = |width: f64, dash: super::layer::Dash| {
            Sample::Stroke(Stroke {
                color,
                width,
                dash: dash.pattern(width),
            })
        };
        match layer {
            Layer::Line(l) => l
                .label
                .iter()
                .try_for_each(|t| push(stroke(l.width, l.dash), t))?,
            Layer::Rule(r) => r
                .label
                .iter()
                .try_for_each(|t| push(stroke(r.width, r.dash), t))?,
            Layer::Markers(m) => m
                .label
                .iter()
                .try_for_each(|t| push(Sample::Marker(m.marker, m.size, color), t))?,
            Layer::Density(d) => d
                .label
                .iter()
                .try_for_each(|t| push(Sample::Marker(Marker::Disc, 3.0, color), t))?,
            Layer::Spans(s) => s
                .label
                .iter()
                .try_for_each(|t| push(Sample::Swatch(color), t))?,
            Layer::CategoryMap(m) => m
                .categories
                .iter()
                .try_for_each(|c| push(Sample::Swatch(c.color), &c.name))?,
            Layer::HeatMap(_) => {}
        }
    }
    if entries
        .iter()
        .any(|e| matches!(e.sample, Sample::Stroke(_)))
    {
        entries.iter_mut().for_each(|e| e.room = LINE_SAMPLE);
    }
    Ok(entries)
}

impl Entry {
    fn width(&self) -> f64 {
        self.room + GAP + self.text.width
    }

    /// Draws the entry with its left end at `x` and its middle at `y`.
    fn draw(&self, x: f64, y: f64, items: &mut Vec<Primitive>) {
        let middle = x + 0.5 * self.room;
        match &self.sample {
            Sample::Stroke(stroke) => items.push(Primitive::Path {
                path: Path::line(x, y, x + self.room, y),
                fill: None,
                stroke: Some(stroke.clone()),
            }),
            Sample::Marker(marker, size, color) => {
                items.push(marker.at(vec![(middle, y)], *size, *color))
            }
            Sample::Swatch(color) => items.push(Primitive::Path {
                path: Rect::new(middle - 4.0, y - 3.0, middle + 4.0, y + 3.0).path(),
                fill: Some(*color),
                stroke: None,
            }),
        }
        let (above, _) = line_extent(SIZE);
        items.push(self.text.clone().level(
            x + self.room + GAP,
            y + 0.5 * above,
            Align::Start,
            Color::INK,
        ));
    }
}

/// Width and height of entries below each other.
pub(super) fn stacked_size(entries: &[Entry]) -> (f64, f64) {
    let width = entries.iter().map(Entry::width).fold(0.0, f64::max);
    (width, LINE * entries.len() as f64)
}

/// Draws entries below each other from the upper left corner.
pub(super) fn draw_stacked(entries: &[Entry], left: f64, top: f64, items: &mut Vec<Primitive>) {
    for (k, entry) in entries.iter().enumerate() {
        entry.draw(left, top + LINE * (k as f64 + 0.5), items);
    }
}

/// Entries side by side, in as many lines as the width needs.
fn flowed(entries: &[Entry], width: f64) -> Vec<Vec<&Entry>> {
    let mut lines: Vec<Vec<&Entry>> = Vec::new();
    let mut used = 0.0;
    for entry in entries {
        match lines.last_mut() {
            Some(line) if used + BESIDE + entry.width() <= width => {
                used += BESIDE + entry.width();
                line.push(entry);
            }
            _ => {
                used = entry.width();
                lines.push(vec![entry]);
            }
        }
    }
    lines
}

/// Height of entries side by side within the width.
pub(super) fn flowed_height(entries: &[Entry], width: f64) -> f64 {
    LINE * flowed(entries, width).len() as f64
}

/// Draws entries side by side, centred between left and right, from the top down.
pub(super) fn draw_flowed(
    entries: &[Entry],
    left: f64,
    right: f64,
    top: f64,
    items: &mut Vec<Primitive>,
) {
    for (k, line) in flowed(entries, right - left).iter().enumerate() {
        let total: f64 =
            line.iter().map(|e| e.width()).sum::<f64>() + BESIDE * (line.len() - 1) as f64;
        let mut x = 0.5 * (left + right) - 0.5 * total;
        for entry in line {
            entry.draw(x, top + LINE * (k as f64 + 0.5), items);
            x += entry.width() + BESIDE;
        }
    }
}

/// The box of a legend inside the panel at one of its corners; `None` for places outside.
pub(super) fn inside(place: Legend, entries: &[Entry], panel: &Rect) -> Option<Rect> {
    let (width, height) = stacked_size(entries);
    let (left, right) = (panel.left + INSET, panel.right - INSET - width);
    let (top, bottom) = (panel.top + INSET, panel.bottom - INSET - height);
    let (x, y) = match place {
        Legend::UpperRight => (right, top),
        Legend::UpperLeft => (left, top),
        Legend::LowerRight => (right, bottom),
        Legend::LowerLeft => (left, bottom),
        Legend::Auto | Legend::Hidden | Legend::Above | Legend::Right => return None,
    };
    Some(Rect::new(x, y, x + width, y + height))
}

/// Which parts of a panel are drawn on, in squares of two points.
pub(super) struct Occupancy {
    area: Rect,
    columns: usize,
    rows: usize,
    taken: Vec<bool>,
}

/// Side of a square in points.
const SQUARE: f64 = 2.0;

impl Occupancy {
    pub(super) fn new(area: Rect) -> Self {
        let columns = (area.width() / SQUARE).ceil().max(1.0) as usize;
        let rows = (area.height() / SQUARE).ceil().max(1.0) as usize;
        Occupancy {
            area,
            columns,
            rows,
            taken: vec![false; columns * rows],
        }
    }

    /// Columns and rows of squares.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    pub(super) fn take(&mut self, x: f64, y: f64) {
        if self.area.contains(x, y) {
            let column = ((x - self.area.left) / SQUARE) as usize;
            let row = ((y - self.area.top) / SQUARE) as usize;
            self.take_square(column, row);
        }
    }

    pub(super) fn take_square(&mut self, column: usize, row: usize) {
        if column < self.columns && row < self.rows {
            self.taken[row * self.columns + column] = true;
        }
    }

    /// Takes every square that the straight lines of a path pass.
    pub(super) fn take_path(&mut self, path: &Path) {
        let mut at = (0.0, 0.0);
        for segment in &path.0 {
            match *segment {
                Segment::Move(x, y) => at = (x, y),
                Segment::Line(x, y) => {
                    let (dx, dy) = (x - at.0, y - at.1);
                    let steps = (dx.abs().max(dy.abs()) / (0.5 * SQUARE)).ceil().max(1.0);
                    for k in 0..=steps as usize {
                        let t = k as f64 / steps;
                        self.take(at.0 + t * dx, at.1 + t * dy);
                    }
                    at = (x, y);
                }
                Segment::Cubic(_) | Segment::Close => {}
            }
        }
    }

    /// How many taken squares a box covers.
    fn covered(&self, rect: &Rect) -> usize {
        let rect = rect.grown(SQUARE);
        let range = |low: f64, high: f64, start: f64, count: usize| {
            let from = ((low - start) / SQUARE).max(0.0) as usize;
            let to = ((high - start) / SQUARE).ceil().max(0.0) as usize;
            from.min(count)..to.min(count)
        };
        range(rect.top, rect.bottom, self.area.top, self.rows)
            .flat_map(|row| {
                range(rect.left, rect.right, self.area.left, self.columns)
                    .map(move |column| row * self.columns + column)
            })
            .filter(|&k| self.taken[k])
            .count()
    }

    /// The first corner at which the legend covers nothing and that it fits into; above the panel if there is none.
    pub(super) fn place(&self, entries: &[Entry]) -> Legend {
        [
            Legend::UpperRight,
            Legend::UpperLeft,
            Legend::LowerRight,
            Legend::LowerLeft,
        ]
        .into_iter()
        .find(|&corner| {
            inside(corner, entries, &self.area).is_some_and(|rect| {
                self.area.contains(rect.left, rect.top)
                    && self.area.contains(rect.right, rect.bottom)
                    && self.covered(&rect) == 0
            })
        })
        .unwrap_or(Legend::Above)
    }
}
