//! The embedded fonts: Chatter Sans, a subset of Liberation Sans 2 (SIL Open Font License, see `fonts/OFL.txt`).

use std::sync::OnceLock;

use ttf_parser::{GlyphId, OutlineBuilder};

use crate::scene::{Path, Segment};

/// One of the embedded fonts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Face {
    /// Upright.
    Regular,
    /// Slanted, for mathematical letters.
    Italic,
}

/// Both faces.
pub(crate) const FACES: [Face; 2] = [Face::Regular, Face::Italic];

/// Height of capital letters and figures, in ems.
pub(crate) const CAP_HEIGHT: f64 = 0.716;
/// Depth of letters such as p below the baseline, in ems.
pub(crate) const DESCENT: f64 = 0.21;
/// Tangent of the italic's slant.
pub(crate) const SLANT: f64 = 0.2126;

impl Face {
    /// The font file.
    pub(crate) fn data(self) -> &'static [u8] {
        match self {
            Face::Regular => include_bytes!("../../fonts/ChatterSans-Regular.ttf"),
            Face::Italic => include_bytes!("../../fonts/ChatterSans-Italic.ttf"),
        }
    }

    /// The font's name inside files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Face::Regular => "ChatterSans-Regular",
            Face::Italic => "ChatterSans-Italic",
        }
    }

    pub(crate) fn parsed(self) -> &'static ttf_parser::Face<'static> {
        static PARSED: OnceLock<[ttf_parser::Face<'static>; 2]> = OnceLock::new();
        let parsed = PARSED.get_or_init(|| {
            FACES.map(|f| ttf_parser::Face::parse(f.data(), 0).expect("the embedded font is whole"))
        });
        &parsed[self as usize]
    }

    /// Font units in an em.
    pub(crate) fn units(self) -> f64 {
        f64::from(self.parsed().units_per_em())
    }

    /// The glyph of a character, if the font has it.
    pub(crate) fn glyph(self, c: char) -> Option<u16> {
        self.parsed().glyph_index(c).map(|g| g.0)
    }

    /// Distance to the next glyph, in ems.
    pub(crate) fn advance(self, glyph: u16) -> f64 {
        f64::from(self.parsed().glyph_hor_advance(GlyphId(glyph)).unwrap_or(0)) / self.units()
    }

    /// Ink of a glyph in ems: left, top, right, bottom with y downwards; `None` for a space.
    pub(crate) fn ink(self, glyph: u16) -> Option<[f64; 4]> {
        let b = self.parsed().glyph_bounding_box(GlyphId(glyph))?;
        let em = |v: i16| f64::from(v) / self.units();
        Some([em(b.x_min), -em(b.y_max), em(b.x_max), -em(b.y_min)])
    }

    /// The outline in font units, y downwards.
    pub(crate) fn outline(self, glyph: u16) -> Path {
        let mut outline = Outline::default();
        self.parsed().outline_glyph(GlyphId(glyph), &mut outline);
        Path(outline.segments)
    }
}

#[derive(Default)]
struct Outline {
    segments: Vec<Segment>,
    at: (f64, f64),
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.at = (f64::from(x), -f64::from(y));
        self.segments.push(Segment::Move(self.at.0, self.at.1));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.at = (f64::from(x), -f64::from(y));
        self.segments.push(Segment::Line(self.at.0, self.at.1));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (x0, y0) = self.at;
        let (cx, cy, x, y) = (f64::from(x1), -f64::from(y1), f64::from(x), -f64::from(y));
        let third = |a: f64, c: f64| a + (c - a) * 2.0 / 3.0;
        self.segments.push(Segment::Cubic([
            third(x0, cx),
            third(y0, cy),
            third(x, cx),
            third(y, cy),
            x,
            y,
        ]));
        self.at = (x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let c = [x1, -y1, x2, -y2, x, -y].map(f64::from);
        self.segments.push(Segment::Cubic(c));
        self.at = (c[4], c[5]);
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}
