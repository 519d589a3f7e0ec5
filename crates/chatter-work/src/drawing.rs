//! The mechanism as the model's drawing has it, at a state: its shapes, and the lines that they are drawn with.

use chatter::expressions::Expr;
use chatter::model::{Model, ShapeKind};
use core::f64::consts::TAU;

/// Windings of a spring, and their width as a part of its length.
const TURNS: u32 = 7;
const WINDING: f64 = 0.04;
/// Hatches of a wall, and their length as a part of the picture.
const HATCHES: u32 = 12;
const HATCH: f64 = 0.025;
/// Sides of what is round.
const SIDES: u32 = 96;

/// Points one after the other, across and upwards; NaN where the line is broken.
pub type Path = (Vec<f64>, Vec<f64>);

/// A shape at a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// What it is.
    pub kind: ShapeKind,
    /// Where it is and how large, in the order of [`ShapeKind::quantities`].
    pub numbers: Vec<f64>,
    /// What it is drawn with.
    pub outline: Path,
    /// Finer lines: the hatches of walls.
    pub hatches: Path,
}

/// The shapes at a state of the model and a time, those that have a place there.
pub fn drawn(model: &Model, state: &[f64], time: f64) -> Vec<Drawn> {
    let parameters = model.parameter_values::<f64>(&[]);
    // Behind the states is time, for drawings of models that have none among them.
    let state: Vec<f64> = state.iter().copied().chain([time]).collect();
    let shapes = model.drawing.iter().map(|shape| {
        let numbers = shape.numbers.iter();
        let value = |expr: &Expr| model.graph.evaluate(*expr, &state, &parameters);
        (shape.kind, numbers.map(value).collect::<Vec<f64>>())
    });
    let shapes: Vec<(ShapeKind, Vec<f64>)> = shapes
        .filter(|(_, numbers)| numbers.iter().all(|value| value.is_finite()))
        .collect();
    let size = extent(&shapes);
    let of_shape = |(kind, numbers): (ShapeKind, Vec<f64>)| {
        let (outline, hatches) = lines(kind, &numbers, size);
        Drawn {
            kind,
            numbers,
            outline,
            hatches,
        }
    };
    shapes.into_iter().map(of_shape).collect()
}

/// How large all of it is.
fn extent(shapes: &[(ShapeKind, Vec<f64>)]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (kind, at) in shapes {
        let (x, y) = lines(*kind, at, 0.0).0;
        for (place, values) in [x, y].iter().enumerate() {
            for value in values.iter().filter(|value| value.is_finite()) {
                low[place] = low[place].min(*value);
                high[place] = high[place].max(*value);
            }
        }
    }
    (high[0] - low[0]).max(high[1] - low[1])
}

/// The outline of a shape, and its hatches in a picture of this size.
fn lines(kind: ShapeKind, at: &[f64], size: f64) -> (Path, Path) {
    let none = (Vec::new(), Vec::new());
    match (kind, at) {
        (ShapeKind::Mass, &[x, y, width, height, angle]) => {
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let corners = [
                (-0.5, -0.5),
                (0.5, -0.5),
                (0.5, 0.5),
                (-0.5, 0.5),
                (-0.5, -0.5),
            ];
            let corner = |(across, up): (f64, f64)| {
                let (u, v) = (across * width, up * height);
                (x + u * cos - v * sin, y + u * sin + v * cos)
            };
            (corners.into_iter().map(corner).unzip(), none)
        }
        (ShapeKind::Disc, &[x, y, radius, angle]) => {
            let (mut xs, mut ys) = circle(x, y, radius);
            // A mark that shows how it has turned.
            xs.extend([f64::NAN, x, x + radius * libm::cos(angle)]);
            ys.extend([f64::NAN, y, y + radius * libm::sin(angle)]);
            ((xs, ys), none)
        }
        (ShapeKind::RoundWall, &[x, y, radius]) => {
            let hatches = (0..4 * HATCHES).map(|k| {
                let angle = TAU * f64::from(k) / f64::from(4 * HATCHES);
                let along = (libm::cos(angle), libm::sin(angle));
                let end = radius + HATCH * size;
                [
                    (x + radius * along.0, y + radius * along.1),
                    (x + end * along.0, y + end * along.1),
                ]
            });
            (circle(x, y, radius), strokes(hatches))
        }
        (_, &[x0, y0, x1, y1]) => {
            let (dx, dy) = (x1 - x0, y1 - y0);
            let length = libm::hypot(dx, dy);
            match kind {
                ShapeKind::Spring => {
                    let steps = 2 * TURNS;
                    let winding = |k: u32| {
                        let along = 0.15 + 0.7 * (f64::from(k) + 0.5) / f64::from(steps);
                        let aside = if k.is_multiple_of(2) {
                            -WINDING
                        } else {
                            WINDING
                        };
                        (x0 + along * dx - aside * dy, y0 + along * dy + aside * dx)
                    };
                    let straight = |along: f64| (x0 + along * dx, y0 + along * dy);
                    let ends = [straight(0.0), straight(0.15)];
                    let path = ends.into_iter().chain((0..steps).map(winding));
                    (path.chain([straight(0.85), straight(1.0)]).unzip(), none)
                }
                ShapeKind::Wall if length > 0.0 => {
                    let hatch = HATCH * size / length;
                    let hatches = (0..=HATCHES).map(|k| {
                        let along = f64::from(k) / f64::from(HATCHES);
                        let (x, y) = (x0 + along * dx, y0 + along * dy);
                        // On the right of the way, leaning back.
                        [(x, y), (x + hatch * (dy - dx), y - hatch * (dx + dy))]
                    });
                    ((vec![x0, x1], vec![y0, y1]), strokes(hatches))
                }
                _ => ((vec![x0, x1], vec![y0, y1]), none),
            }
        }
        _ => (none.clone(), none),
    }
}

fn circle(x: f64, y: f64, radius: f64) -> Path {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(SIDES);
    (0..=SIDES)
        .map(|k| {
            (
                x + radius * libm::cos(angle(k)),
                y + radius * libm::sin(angle(k)),
            )
        })
        .unzip()
}

/// Lines that do not hang together, as one.
fn strokes(lines: impl Iterator<Item = [(f64, f64); 2]>) -> Path {
    lines
        .flat_map(|[from, to]| [from, to, (f64::NAN, f64::NAN)])
        .unzip()
}
