//! A placed panel as drawing primitives.

use super::layout::{
    AxisText, BAR, BAR_GAP, Frame, LABEL_GAP, MINOR_TICK, Plan, ROW_GAP, SPINE, TICK, TICK_GAP,
    TICK_TEXT,
};
use super::simplify;
use crate::axis::Placed;
use crate::color::Color;
use crate::density::Density;
use crate::figure_error::FigureError;
use crate::labels::text::{Align, SetText, line_extent};
use crate::layer::{Layer, Line, Marker, Orientation};
use crate::legend::{self, Legend, Occupancy};
use crate::map::{CategoryMap, Grid, HeatMap};
use crate::scene::{Image, Path, Primitive, Rect, Segment, Stroke};
use crate::writers::png::Resolution;

/// Half the thickness of a curve may reach beyond the frame's middle line.
const CLIP_MARGIN: f64 = 0.25;

impl Marker {
    /// The marker at places, as a primitive.
    pub(crate) fn at(self, places: Vec<(f64, f64)>, size: f64, color: Color) -> Primitive {
        let r = 0.5 * size;
        let thin = Stroke {
            color,
            width: (0.2 * size).clamp(0.4, 1.0),
            dash: Vec::new(),
        };
        let (shape, fill, stroke) = match self {
            Marker::Disc => (Path::circle(r), Some(color), None),
            Marker::Circle => (Path::circle(r), Some(Color::WHITE), Some(thin)),
            // Equal areas look equally large.
            Marker::Square => (
                Rect::new(-r, -r, r, r).grown(-0.11 * size).path(),
                Some(color),
                None,
            ),
            Marker::Triangle => {
                let r = 1.25 * r;
                (
                    Path::polygon(&[(0.0, -r), (0.866 * r, 0.5 * r), (-0.866 * r, 0.5 * r)]),
                    Some(color),
                    None,
                )
            }
            Marker::Diamond => {
                let r = 1.2 * r;
                (
                    Path::polygon(&[(0.0, -r), (r, 0.0), (0.0, r), (-r, 0.0)]),
                    Some(color),
                    None,
                )
            }
            Marker::Cross => {
                let r = 0.8 * r;
                let mut path = Path::line(-r, -r, r, r);
                path.0.extend(Path::line(-r, r, r, -r).0);
                (path, None, Some(thin))
            }
            Marker::Plus => {
                let mut path = Path::line(-r, 0.0, r, 0.0);
                path.0.extend(Path::line(0.0, -r, 0.0, r).0);
                (path, None, Some(thin))
            }
        };
        Primitive::Symbols {
            shape,
            fill,
            stroke,
            places,
        }
    }
}

/// Pixels of pictures inside a panel.
fn pixels(inner: &Rect, per_point: f64) -> (usize, usize) {
    let count = |length: f64| (length * per_point).round().max(1.0) as usize;
    (count(inner.width()), count(inner.height()))
}

/// Draws a panel; pictures inside it get so many pixels per point.
pub(crate) fn panel(
    plan: &Plan,
    frame: &Frame,
    per_point: f64,
    items: &mut Vec<Primitive>,
) -> Result<(), FigureError> {
    let mut inside = Vec::new();
    let mut over = Vec::new();
    for (layer, &color) in plan.panel.layers.iter().zip(&plan.colors) {
        match layer {
            Layer::Line(line) => inside.push(Primitive::Path {
                path: curve(line, frame),
                fill: None,
                stroke: Some(Stroke {
                    color,
                    width: line.width,
                    dash: line.dash.pattern(line.width),
                }),
            }),
            Layer::Markers(m) => {
                let places =
                    m.x.iter()
                        .zip(&m.y)
                        .map(|(&x, &y)| (frame.x.at(x), frame.y.at(y)));
                let seen = places
                    .filter(|&(x, y)| frame.inner.grown(CLIP_MARGIN).contains(x, y))
                    .collect();
                flush(&mut inside, &mut over, frame);
                over.push(m.marker.at(seen, m.size, color));
            }
            Layer::Density(d) => inside.push(density(d, frame, color, per_point)),
            Layer::Spans(s) => {
                let bands = s
                    .intervals
                    .iter()
                    .filter_map(|&(a, b)| band(a, b, s.orientation, frame));
                let path = Path(bands.flat_map(|r| r.path().0).collect());
                inside.push(Primitive::Path {
                    path,
                    fill: Some(color),
                    stroke: None,
                });
            }
            Layer::Rule(r) => {
                if let Some(path) = rule(r.at, r.orientation, frame) {
                    inside.push(Primitive::Path {
                        path,
                        fill: None,
                        stroke: Some(Stroke {
                            color,
                            width: r.width,
                            dash: r.dash.pattern(r.width),
                        }),
                    });
                }
            }
            Layer::HeatMap(m) => inside.push(heat_map(m, plan, frame, per_point)),
            Layer::CategoryMap(m) => inside.push(category_map(m, frame, per_point)),
        }
    }
    flush(&mut inside, &mut over, frame);
    items.append(&mut over);
    if let Some(rect) = legend::inside(plan.legend, &plan.entries, &frame.inner) {
        items.push(Primitive::Path {
            path: rect.grown(2.0).path(),
            fill: Some(Color::WHITE.opacity(0.85)),
            stroke: None,
        });
        legend::draw_stacked(&plan.entries, rect.left, rect.top, items);
    }
    spines_and_ticks(frame, items);
    around(plan, frame, items);
    Ok(())
}

/// Moves what is to be clipped behind what is not, in order.
fn flush(inside: &mut Vec<Primitive>, over: &mut Vec<Primitive>, frame: &Frame) {
    if !inside.is_empty() {
        over.push(Primitive::Clip {
            rect: frame.inner.grown(CLIP_MARGIN),
            items: std::mem::take(inside),
        });
    }
}

fn curve(line: &Line, frame: &Frame) -> Path {
    let places = line
        .x
        .iter()
        .zip(&line.y)
        .map(|(&x, &y)| (frame.x.at(x), frame.y.at(y)));
    simplify::curve(places, frame.inner)
}

fn band(a: f64, b: f64, orientation: Orientation, frame: &Frame) -> Option<Rect> {
    let (axis, low, high) = along(orientation, frame);
    let (p, q) = (axis.at(a), axis.at(b));
    if p.is_nan() || q.is_nan() {
        return None;
    }
    let (p, q) = (p.min(q).max(low), p.max(q).min(high));
    // A band that lasts for less than can be seen is still shown, as a hairline.
    (p <= q).then(|| {
        let q = q.max((p + 0.25).min(high));
        match orientation {
            Orientation::Vertical => Rect::new(p, frame.inner.top, q, frame.inner.bottom),
            Orientation::Horizontal => Rect::new(frame.inner.left, p, frame.inner.right, q),
        }
    })
}

/// The axis across which a line or band of this orientation lies, and its ends on the page.
fn along(orientation: Orientation, frame: &Frame) -> (&Placed, f64, f64) {
    match orientation {
        Orientation::Vertical => (&frame.x, frame.inner.left, frame.inner.right),
        Orientation::Horizontal => (&frame.y, frame.inner.top, frame.inner.bottom),
    }
}

fn rule(at: f64, orientation: Orientation, frame: &Frame) -> Option<Path> {
    let (axis, low, high) = along(orientation, frame);
    let p = axis.at(at);
    let i = &frame.inner;
    (p >= low - CLIP_MARGIN && p <= high + CLIP_MARGIN).then(|| match orientation {
        Orientation::Vertical => Path::line(p, i.bottom, p, i.top),
        Orientation::Horizontal => Path::line(i.left, p, i.right, p),
    })
}

/// Linear coordinates of the ends of a placed axis on the page.
fn window(axis: &Placed, from: f64, to: f64) -> (f64, f64) {
    (axis.linear_at(from), axis.linear_at(to))
}

fn density(d: &Density, frame: &Frame, color: Color, per_point: f64) -> Primitive {
    let i = &frame.inner;
    // Finer pixels would only hold fewer points.
    let per_point = per_point.min(Resolution::PRINT.pixels_per_point());
    let (width, height) = pixels(i, per_point);
    let (x, y) = (
        window(&frame.x, i.left, i.right),
        window(&frame.y, i.top, i.bottom),
    );
    let shades = d.shades(x, y, width, height);
    let opaque = f64::from(color.a) / 255.0;
    Primitive::Image(Image {
        rect: *i,
        width,
        height,
        pixels: shades.iter().map(|s| color.opacity(s * opaque)).collect(),
    })
}

/// The cell of each pixel column and row.
fn cells(
    grid: &Grid,
    frame: &Frame,
    width: usize,
    height: usize,
) -> (Vec<Option<usize>>, Vec<Option<usize>>) {
    let i = frame.inner;
    let middle =
        |k: usize, n: usize, from: f64, to: f64| from + (to - from) * ((k as f64 + 0.5) / n as f64);
    let columns = (0..width).map(|k| frame.x.linear_at(middle(k, width, i.left, i.right)));
    let rows = (0..height).map(|k| frame.y.linear_at(middle(k, height, i.top, i.bottom)));
    (
        Grid::indices(&grid.x, frame.x.limits.scale, columns),
        Grid::indices(&grid.y, frame.y.limits.scale, rows),
    )
}

fn map_image(
    grid: &Grid,
    frame: &Frame,
    per_point: f64,
    color: impl Fn(usize) -> Option<Color>,
) -> Primitive {
    const CLEAR: Color = Color {
        r: 255,
        g: 255,
        b: 255,
        a: 0,
    };
    let (width, height) = pixels(&frame.inner, per_point);
    let (columns, rows) = cells(grid, frame, width, height);
    let mut pixels = Vec::with_capacity(width * height);
    for row in &rows {
        for column in &columns {
            let cell = row.zip(*column).map(|(j, i)| j * grid.x.len() + i);
            pixels.push(cell.and_then(&color).unwrap_or(CLEAR));
        }
    }
    Primitive::Image(Image {
        rect: frame.inner,
        width,
        height,
        pixels,
    })
}

fn heat_map(m: &HeatMap, plan: &Plan, frame: &Frame, per_point: f64) -> Primitive {
    let limits = plan.bar.expect("a heat map has a colour scale");
    // One scale of a panel serves all its heat maps; their order of numbers is that of this one.
    let colors: Vec<Option<Color>> = m
        .values
        .iter()
        .map(|&v| {
            let u = limits.scale.forward(v);
            let t = m.colormap.place(u, limits.low, limits.high);
            u.is_finite().then(|| m.colormap.color(t))
        })
        .collect();
    map_image(&m.grid, frame, per_point, |k| colors[k])
}

fn category_map(m: &CategoryMap, frame: &Frame, per_point: f64) -> Primitive {
    map_image(&m.grid, frame, per_point, |k| {
        m.cells[k].map(|c| m.categories[c].color)
    })
}

fn ink_stroke(width: f64) -> Option<Stroke> {
    Some(Stroke {
        color: Color::INK,
        width,
        dash: Vec::new(),
    })
}

fn spines_and_ticks(frame: &Frame, items: &mut Vec<Primitive>) {
    let i = &frame.inner;
    let mut ticks = Path::default();
    let mut add = |x0: f64, y0: f64, x1: f64, y1: f64| {
        ticks
            .0
            .extend([Segment::Move(x0, y0), Segment::Line(x1, y1)]);
    };
    for (list, length) in [
        (
            frame.x_text.ticks.major.iter().map(|t| t.at).collect(),
            TICK,
        ),
        (frame.x_text.ticks.minor.clone(), MINOR_TICK),
    ] {
        let list: Vec<f64> = list;
        list.iter()
            .map(|&t| frame.x.at(t))
            .for_each(|p| add(p, i.bottom, p, i.bottom + length));
    }
    for (list, length) in [
        (
            frame.y_text.ticks.major.iter().map(|t| t.at).collect(),
            TICK,
        ),
        (frame.y_text.ticks.minor.clone(), MINOR_TICK),
    ] {
        let list: Vec<f64> = list;
        list.iter()
            .map(|&t| frame.y.at(t))
            .for_each(|p| add(i.left, p, i.left - length, p));
    }
    items.push(Primitive::Path {
        path: ticks,
        fill: None,
        stroke: ink_stroke(SPINE),
    });
    items.push(Primitive::Path {
        path: i.path(),
        fill: None,
        stroke: ink_stroke(SPINE),
    });
}

/// Numbers, labels, notations, letter, title, and a legend or colour bar outside.
fn around(plan: &Plan, frame: &Frame, items: &mut Vec<Primitive>) {
    let i = &frame.inner;
    let (cap, _) = line_extent(TICK_TEXT);

    let number_base = i.bottom + TICK + TICK_GAP + frame.x_text.above();
    for (tick, number) in frame.x_text.ticks.major.iter().zip(&frame.x_text.numbers) {
        items.push(number.clone().level(
            frame.x.at(tick.at),
            number_base,
            Align::Middle,
            Color::INK,
        ));
    }
    let mut row = i.bottom
        + if frame.x_text.numbers.is_empty() {
            TICK
        } else {
            frame.x_text.number_row()
        };
    let label = &frame.x_text.label;
    if let Some(notation) = &frame.x_text.notation {
        let beside = frame.x_text.notation_beside_label;
        let base = if beside {
            row + LABEL_GAP + label.above
        } else {
            row + ROW_GAP + notation.above
        };
        items.push(
            notation
                .clone()
                .level(i.right, base, Align::End, Color::INK),
        );
        if !beside {
            row += ROW_GAP + notation.height();
        }
    }
    if !label.is_empty() {
        let middle = 0.5 * (i.left + i.right);
        items.push(label.clone().level(
            middle,
            row + LABEL_GAP + label.above,
            Align::Middle,
            Color::INK,
        ));
    }

    for (tick, number) in frame.y_text.ticks.major.iter().zip(&frame.y_text.numbers) {
        let base = frame.y.at(tick.at) + 0.5 * cap;
        items.push(
            number
                .clone()
                .level(i.left - TICK - TICK_GAP, base, Align::End, Color::INK),
        );
    }
    let label = &frame.y_text.label;
    if !label.is_empty() {
        let middle = 0.5 * (i.top + i.bottom);
        items.push(label.clone().upward(
            frame.outer.left + label.above,
            middle,
            Align::Middle,
            Color::INK,
        ));
    }
    if let Some(notation) = &frame.y_text.notation {
        let base = i.top - ROW_GAP - notation.below;
        items.push(
            notation
                .clone()
                .level(i.left, base, Align::Start, Color::INK),
        );
    }
    header(frame, items);

    let mut side = i.right + BAR_GAP;
    if let Some(text) = &frame.bar_text {
        side = color_bar(plan, frame, text, side, items) + BAR_GAP;
    }
    match plan.legend {
        Legend::Right => legend::draw_stacked(&plan.entries, side, i.top, items),
        Legend::Above => {
            let top = i.top - frame.rows.notation - frame.rows.legend;
            legend::draw_flowed(&plan.entries, i.left, i.right, top, items);
        }
        _ => {}
    }
}

/// Letter and title.
fn header(frame: &Frame, items: &mut Vec<Primitive>) {
    let i = &frame.inner;
    let rows = &frame.rows;
    let below = if rows.header_beside {
        0.0
    } else {
        rows.notation + rows.legend
    };
    let base = |t: &SetText| i.top - below - ROW_GAP - t.below;
    if let Some(title) = &frame.title {
        let middle = 0.5 * (i.left + i.right);
        items.push(
            title
                .clone()
                .level(middle, base(title), Align::Middle, Color::INK),
        );
    }
    // Letters of panels side by side are in line.
    if let Some(letter) = &frame.letter {
        let base = frame.outer.top + letter.above;
        items.push(
            letter
                .clone()
                .level(frame.outer.left, base, Align::Start, Color::INK),
        );
    }
}

/// Draws the colour bar with its left edge at `left`; returns its right end with numbers and label.
fn color_bar(
    plan: &Plan,
    frame: &Frame,
    text: &AxisText,
    left: f64,
    items: &mut Vec<Primitive>,
) -> f64 {
    let i = &frame.inner;
    let bar = Rect::new(left, i.top, left + BAR, i.bottom);
    let limits = plan.bar.expect("there is a bar");
    let placed = limits.place(bar.bottom, bar.top);
    let colormap = plan.panel.layers.iter().find_map(|l| match l {
        Layer::HeatMap(m) => Some(m.colormap),
        _ => None,
    });
    const STEPS: usize = 256;
    let pixels = (0..STEPS).rev().map(|k| {
        let place = bar.bottom + (bar.top - bar.bottom) * ((k as f64 + 0.5) / STEPS as f64);
        let map = colormap.expect("the bar is a heat map's");
        map.color(map.place(placed.linear_at(place), limits.low, limits.high))
    });
    items.push(Primitive::Image(Image {
        rect: bar,
        width: 1,
        height: STEPS,
        pixels: pixels.collect(),
    }));
    let (cap, _) = line_extent(TICK_TEXT);
    let mut ticks = bar.path();
    let mut widest: f64 = 0.0;
    for (tick, number) in text.ticks.major.iter().zip(&text.numbers) {
        let p = placed.at(tick.at);
        ticks
            .0
            .extend(Path::line(bar.right, p, bar.right + TICK, p).0);
        items.push(number.clone().level(
            bar.right + TICK + TICK_GAP,
            p + 0.5 * cap,
            Align::Start,
            Color::INK,
        ));
        widest = widest.max(number.width);
    }
    for &t in &text.ticks.minor {
        let p = placed.at(t);
        ticks
            .0
            .extend(Path::line(bar.right, p, bar.right + MINOR_TICK, p).0);
    }
    items.push(Primitive::Path {
        path: ticks,
        fill: None,
        stroke: ink_stroke(SPINE),
    });
    if let Some(notation) = &text.notation {
        items.push(notation.clone().level(
            bar.left,
            i.top - ROW_GAP - notation.below,
            Align::Start,
            Color::INK,
        ));
    }
    let mut right = bar.right + TICK + TICK_GAP + widest;
    if !text.label.is_empty() {
        let label = text.label.clone();
        let x = right + LABEL_GAP + label.above;
        right = x + label.below;
        items.push(label.upward(x, 0.5 * (i.top + i.bottom), Align::Middle, Color::INK));
    }
    right
}

/// Where the panel is drawn on, to find room for its legend.
pub(crate) fn occupancy(plan: &Plan, frame: &Frame) -> Result<Occupancy, FigureError> {
    let i = frame.inner;
    let mut taken = Occupancy::new(i);
    for layer in &plan.panel.layers {
        match layer {
            Layer::Line(line) => taken.take_path(&curve(line, frame)),
            Layer::Markers(m) => {
                for (&x, &y) in m.x.iter().zip(&m.y) {
                    let (x, y) = (frame.x.at(x), frame.y.at(y));
                    let r = 0.5 * m.size;
                    for (dx, dy) in [(0.0, 0.0), (r, 0.0), (-r, 0.0), (0.0, r), (0.0, -r)] {
                        taken.take(x + dx, y + dy);
                    }
                }
            }
            Layer::Density(d) => {
                let (columns, rows) = taken.size();
                let (x, y) = (
                    window(&frame.x, i.left, i.right),
                    window(&frame.y, i.top, i.bottom),
                );
                let shades = d.shades(x, y, columns, rows);
                for (k, _) in shades.iter().enumerate().filter(|(_, s)| **s > 0.0) {
                    taken.take_square(k % columns, k / columns);
                }
            }
            Layer::Rule(r) => {
                if let Some(path) = rule(r.at, r.orientation, frame) {
                    taken.take_path(&path);
                }
            }
            Layer::HeatMap(_) | Layer::CategoryMap(_) => {
                let (columns, rows) = taken.size();
                (0..columns * rows).for_each(|k| taken.take_square(k % columns, k / columns));
            }
            Layer::Spans(_) => {}
        }
    }
    Ok(taken)
}
