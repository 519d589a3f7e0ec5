//! Labels to glyphs: where each stands, and how much room the whole takes.

use super::fonts::{CAP_HEIGHT, DESCENT, Face, SLANT};
use super::label::{self, Node, Spacing};
use crate::color::Color;
use crate::figure_error::FigureError;
use crate::scene::{Glyph, GlyphRun, Primitive, Turn};

/// Size of an index or exponent relative to its line.
const SCRIPT_SIZE: f64 = 0.7;
/// How far an index is below the line, in ems.
const SUB_DROP: f64 = 0.17;
/// How far an exponent is above it.
const SUP_RISE: f64 = 0.38;
/// How far an asterisk is lowered, and how much enlarged.
const ASTERISK_DROP: f64 = 0.35;
const ASTERISK_SIZE: f64 = 1.3;
/// Space after an index or exponent.
const SCRIPT_GAP: f64 = 0.04;

/// A label set in glyphs, its origin at the left end of its baseline.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SetText {
    glyphs: Vec<Glyph>,
    source: String,
    /// Width in points.
    pub(crate) width: f64,
    /// Extent above the baseline, at least that of a capital letter.
    pub(crate) above: f64,
    /// Extent below the baseline, zero for figures.
    pub(crate) below: f64,
}

/// Which part of a text is at the given point, horizontally.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Align {
    Start,
    Middle,
    End,
}

impl SetText {
    /// Sets a label in a size given in points.
    pub(crate) fn new(source: &str, size: f64) -> Result<Self, FigureError> {
        let nodes = label::parse(source)?;
        let mut setter = Setter::default();
        let width = setter.line(&nodes, 0.0, 0.0, size, false);
        let mut above = CAP_HEIGHT * size;
        let mut below: f64 = 0.0;
        for g in &setter.glyphs {
            if let Some([_, top, _, bottom]) = g.face.ink(g.id) {
                above = above.max(-(g.y + top * g.size));
                below = below.max(g.y + bottom * g.size);
            }
        }
        Ok(SetText {
            glyphs: setter.glyphs,
            source: source.to_string(),
            width,
            above,
            below,
        })
    }

    pub(crate) fn height(&self) -> f64 {
        self.above + self.below
    }

    /// Whether there is nothing to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.glyphs.is_empty()
    }

    /// Level text with its baseline at `y`.
    pub(crate) fn level(self, x: f64, y: f64, align: Align, color: Color) -> Primitive {
        let x = x - self.width * align.fraction();
        self.run(x, y, Turn::None, color)
    }

    /// Text read upwards with its baseline at `x`.
    pub(crate) fn upward(self, x: f64, y: f64, align: Align, color: Color) -> Primitive {
        let y = y + self.width * align.fraction();
        self.run(x, y, Turn::Left, color)
    }

    fn run(self, x: f64, y: f64, turn: Turn, color: Color) -> Primitive {
        Primitive::Text(GlyphRun {
            glyphs: self.glyphs,
            x,
            y,
            turn,
            color,
            source: self.source,
        })
    }
}

impl Align {
    fn fraction(self) -> f64 {
        match self {
            Align::Start => 0.0,
            Align::Middle => 0.5,
            Align::End => 1.0,
        }
    }
}

/// Nominal extent of a line of text above and below its baseline, in points.
pub(crate) fn line_extent(size: f64) -> (f64, f64) {
    (CAP_HEIGHT * size, DESCENT * size)
}

#[derive(Default)]
struct Setter {
    glyphs: Vec<Glyph>,
}

impl Setter {
    /// Sets nodes from `x` on; returns where they end.
    fn line(&mut self, nodes: &[Node], x: f64, y: f64, size: f64, in_script: bool) -> f64 {
        let mut x = x;
        let mut slanted = false;
        for node in nodes {
            match node {
                Node::Char(c, face) => {
                    x = self.char(*c, *face, x, y, size);
                    slanted = *face == Face::Italic;
                    continue;
                }
                Node::Space(em, Spacing::Wanted) => x += em * size,
                Node::Space(em, Spacing::Operator) => {
                    x += if in_script { 0.3 * em } else { *em } * size
                }
                Node::Scripts { sub, sup } => {
                    let small = SCRIPT_SIZE * size;
                    let lean = if slanted { 0.06 * size } else { 0.02 * size };
                    let low = self.line(sub, x, y + SUB_DROP * size, small, true);
                    let high = self.line(sup, x + lean, y - SUP_RISE * size, small, true);
                    let high = if sup.is_empty() { x } else { high };
                    x = low.max(high) + SCRIPT_GAP * size;
                }
                Node::Accent { mark, body } => x = self.accent(*mark, body, x, y, size, in_script),
            }
            slanted = false;
        }
        x
    }

    fn char(&mut self, c: char, face: Face, x: f64, y: f64, size: f64) -> f64 {
        // The font's asterisk is small and high, as if it were an exponent already.
        let (y, size) = match c {
            '*' => (y + ASTERISK_DROP * size, ASTERISK_SIZE * size),
            _ => (y, size),
        };
        // A character that the slanted font lacks is taken upright; one that both lack shows the font's empty box.
        let (face, id) = match (face.glyph(c), Face::Regular.glyph(c)) {
            (Some(id), _) => (face, id),
            (None, Some(id)) => (Face::Regular, id),
            (None, None) => (Face::Regular, 0),
        };
        self.glyphs.push(Glyph {
            face,
            id,
            character: c,
            x,
            y,
            size,
        });
        x + face.advance(id) * size
    }

    /// Places a mark above the middle of the body's ink, shifted as the slant asks.
    fn accent(
        &mut self,
        mark: char,
        body: &[Node],
        x: f64,
        y: f64,
        size: f64,
        in_script: bool,
    ) -> f64 {
        let first = self.glyphs.len();
        let end = self.line(body, x, y, size, in_script);
        let (mut left, mut right, mut top) = (f64::INFINITY, f64::NEG_INFINITY, y);
        let mut lean: f64 = 0.0;
        for g in &self.glyphs[first..] {
            if let Some([l, t, r, _]) = g.face.ink(g.id) {
                left = left.min(g.x + l * g.size);
                right = right.max(g.x + r * g.size);
                top = top.min(g.y + t * g.size);
                if g.face == Face::Italic {
                    lean = SLANT;
                }
            }
        }
        let id = Face::Regular.glyph(mark).unwrap_or(0);
        if let (Some([ml, _, mr, mb]), true) = (Face::Regular.ink(id), left < right) {
            // The mark's own ink stands at the height of lower-case accents: lift it clear of the body.
            let clearance = 0.09 * size;
            let rise = (top - clearance) - mb * size;
            let middle = 0.5 * (left + right) + lean * 0.5 * (y - top).min(0.3 * size);
            self.glyphs.push(Glyph {
                face: Face::Regular,
                id,
                character: mark,
                x: middle - 0.5 * (ml + mr) * size,
                y: rise,
                size,
            });
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(source: &str) -> SetText {
        SetText::new(source, 10.0).unwrap()
    }

    #[test]
    fn scripts_stand_below_and_above_and_are_small() {
        let text = set("$x_1^2$");
        let [x, one, two] = text.glyphs[..] else {
            panic!("{text:?}")
        };
        assert!(one.y > x.y && two.y < x.y && one.size < x.size);
        assert!(
            (one.x - two.x).abs() < x.size * 0.1,
            "stacked, not in a row"
        );
        assert!(text.width > set("$x$").width && text.below > 0.0);
    }

    #[test]
    fn a_dot_is_above_its_letter_and_takes_no_width() {
        let text = set("$\\dot{x}$");
        let [x, dot] = text.glyphs[..] else {
            panic!("{text:?}")
        };
        let top_of_x = x.face.ink(x.id).unwrap()[1] * x.size;
        let bottom_of_dot = dot.y + dot.face.ink(dot.id).unwrap()[3] * dot.size;
        assert!(bottom_of_dot < top_of_x);
        assert_eq!(text.width, set("$x$").width);
    }

    #[test]
    fn all_characters_that_commands_make_are_in_the_fonts() {
        for name in [
            "Upsilon", "omega", "lambda", "eta", "mu", "infty", "approx", "to", "ell", "sim",
            "hbar", "cap", "dagger", "surd", "partial", "sum", "int", "prod", "ne", "pm", "div",
            "Vert",
        ] {
            let text = set(&format!("$\\{name}$"));
            assert!(text.glyphs.iter().all(|g| g.id != 0), "\\{name}");
        }
    }
}
