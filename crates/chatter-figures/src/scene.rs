//! Drawing primitives: what every writer draws, and all that it needs to know.

use super::color::Color;
use super::labels::fonts::Face;

/// A rectangle in points (1/72 inch), y downwards.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rect {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Rect {
    /// A rectangle from its edges.
    pub fn new(left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Rect {
            left,
            top,
            right,
            bottom,
        }
    }

    /// Its width.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Its height.
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// The rectangle enlarged by `by` on every side.
    pub fn grown(&self, by: f64) -> Self {
        Rect::new(
            self.left - by,
            self.top - by,
            self.right + by,
            self.bottom + by,
        )
    }

    /// Whether the point is inside or on the edge.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    /// Whether the two overlap.
    pub fn meets(&self, other: &Rect) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    /// Its outline as a path.
    pub fn path(&self) -> Path {
        Path(vec![
            Segment::Move(self.left, self.top),
            Segment::Line(self.right, self.top),
            Segment::Line(self.right, self.bottom),
            Segment::Line(self.left, self.bottom),
            Segment::Close,
        ])
    }
}

/// One step of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Segment {
    /// Start anew at a point.
    Move(f64, f64),
    /// Straight to a point.
    Line(f64, f64),
    /// A cubic Bézier curve: two control points and the end.
    Cubic([f64; 6]),
    /// Back to where this part began.
    Close,
}

/// Straight and curved lines, in points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path(pub Vec<Segment>);

impl Path {
    /// The straight line between two points.
    pub fn line(x0: f64, y0: f64, x1: f64, y1: f64) -> Self {
        Path(vec![Segment::Move(x0, y0), Segment::Line(x1, y1)])
    }

    /// A polygon, closed.
    pub fn polygon(corners: &[(f64, f64)]) -> Self {
        let mut segments = Vec::with_capacity(corners.len() + 1);
        for (k, &(x, y)) in corners.iter().enumerate() {
            segments.push(if k == 0 {
                Segment::Move(x, y)
            } else {
                Segment::Line(x, y)
            });
        }
        segments.push(Segment::Close);
        Path(segments)
    }

    /// A circle round the origin.
    pub fn circle(radius: f64) -> Self {
        // Control points of the cubic that stays within 0.03 % of a quarter circle.
        let k = 0.552_284_749_8 * radius;
        let r = radius;
        Path(vec![
            Segment::Move(r, 0.0),
            Segment::Cubic([r, k, k, r, 0.0, r]),
            Segment::Cubic([-k, r, -r, k, -r, 0.0]),
            Segment::Cubic([-r, -k, -k, -r, 0.0, -r]),
            Segment::Cubic([k, -r, r, -k, r, 0.0]),
            Segment::Close,
        ])
    }
}

/// How a path is drawn along.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub color: Color,
    /// Width in points.
    pub width: f64,
    /// Lengths of dashes and gaps in turn, in points; empty for a solid line. Solid lines have round joins and ends.
    pub dash: Vec<f64>,
}

/// One glyph of an embedded font.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glyph {
    /// The font.
    pub face: Face,
    /// Its number in the font.
    pub id: u16,
    /// The character it shows.
    pub character: char,
    /// Where its origin is, from the run's origin.
    pub x: f64,
    /// Where its baseline is, from the run's origin, downwards.
    pub y: f64,
    /// Size of the em square in points.
    pub size: f64,
}

/// Whether text is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Read from left to right.
    None,
    /// Read from bottom to top.
    Left,
}

/// A piece of text.
#[derive(Debug, Clone, PartialEq)]
pub struct GlyphRun {
    /// Its glyphs.
    pub glyphs: Vec<Glyph>,
    /// Where its origin is.
    pub x: f64,
    /// Where its baseline is.
    pub y: f64,
    /// Whether it is turned about its origin.
    pub turn: Turn,
    /// Colour.
    pub color: Color,
    /// The label it was made from.
    pub source: String,
}

/// A picture: pixels, row after row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Where it is drawn.
    pub rect: Rect,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The pixels; opacity is not multiplied in.
    pub pixels: Vec<Color>,
}

/// One thing to draw.
#[derive(Debug, Clone, PartialEq)]
pub enum Primitive {
    /// A path, filled (non-zero winding), stroked, or both.
    Path {
        /// The path.
        path: Path,
        /// Colour of its inside.
        fill: Option<Color>,
        /// How it is drawn along.
        stroke: Option<Stroke>,
    },
    /// One shape at many places.
    Symbols {
        /// The shape round its place.
        shape: Path,
        /// Colour of its inside.
        fill: Option<Color>,
        /// How it is drawn along.
        stroke: Option<Stroke>,
        /// The places.
        places: Vec<(f64, f64)>,
    },
    /// A picture.
    Image(Image),
    /// Text.
    Text(GlyphRun),
    /// Things of which only the part within a rectangle is seen.
    Clip {
        /// The rectangle.
        rect: Rect,
        /// The things.
        items: Vec<Primitive>,
    },
}

/// A page of primitives, drawn in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Width in points.
    pub width: f64,
    /// Height in points.
    pub height: f64,
    /// What is drawn.
    pub items: Vec<Primitive>,
    /// What the figure is called, in the file's metadata.
    pub title: String,
    /// How it was made, in the file's metadata.
    pub caption: String,
}

impl Scene {
    /// Every primitive, with those inside clips.
    pub(super) fn all(&self) -> impl Iterator<Item = &Primitive> {
        let mut stack: Vec<&Primitive> = self.items.iter().rev().collect();
        std::iter::from_fn(move || {
            let next = stack.pop()?;
            if let Primitive::Clip { items, .. } = next {
                stack.extend(items.iter().rev());
            }
            Some(next)
        })
    }
}
