//! What a panel shows: curves, markers, bands, reference lines.

use super::color::Color;
use super::density::Density;
use super::map::{CategoryMap, HeatMap};

/// One thing that a panel shows. Later ones are drawn over earlier ones.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Layer {
    /// A curve.
    Line(Line),
    /// Separate points.
    Markers(Markers),
    /// Very many points.
    Density(Density),
    /// Bands across the panel.
    Spans(Spans),
    /// A straight line across the panel.
    Rule(Rule),
    /// Numbers as colours.
    HeatMap(HeatMap),
    /// Categories as colours.
    CategoryMap(CategoryMap),
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Not at all.
    #[default]
    Solid,
    /// Into dashes.
    Dashed,
    /// Into dots.
    Dotted,
    /// Into dashes and dots in turn.
    DashDotted,
}

impl Dash {
    /// Lengths of dashes and gaps in turn, in points.
    pub(super) fn pattern(self, width: f64) -> Vec<f64> {
        let lengths: &[f64] = match self {
            Dash::Solid => &[],
            Dash::Dashed => &[4.0, 2.2],
            Dash::Dotted => &[1.0, 1.6],
            Dash::DashDotted => &[4.0, 1.8, 1.0, 1.8],
        };
        lengths.iter().map(|l| l * width.max(0.6)).collect()
    }
}

/// A curve through points, broken where a coordinate is not finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) color: Option<Color>,
    pub(super) width: f64,
    pub(super) dash: Dash,
    pub(super) label: Option<String>,
}

impl Line {
    /// A curve through the points `(x[k], y[k])`, in the next colour of the palette.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        Line {
            x,
            y,
            color: None,
            width: 0.8,
            dash: Dash::Solid,
            label: None,
        }
    }
}

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marker {
    /// Filled circle.
    #[default]
    Disc,
    /// Circle with a white inside.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle, point upwards.
    Triangle,
    /// Filled square on its corner.
    Diamond,
    /// Two crossing diagonals.
    Cross,
    /// A level and an upright line, crossing.
    Plus,
}

/// Separate points.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) marker: Marker,
    pub(super) size: f64,
    pub(super) color: Option<Color>,
    pub(super) label: Option<String>,
}

impl Markers {
    /// Discs at the points `(x[k], y[k])`, in the next colour of the palette.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        Markers {
            x,
            y,
            marker: Marker::Disc,
            size: 3.0,
            color: None,
            label: None,
        }
    }

    /// Of this shape.
    pub fn marker(mut self, marker: Marker) -> Self {
        self.marker = marker;
        self
    }

    /// So many points across.
    pub fn size(mut self, size: f64) -> Self {
        self.size = size;
        self
    }
}

/// Which way a line or band runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// From left to right, at a place on the vertical axis.
    Horizontal,
    /// From bottom to top, at a place on the horizontal axis.
    Vertical,
}

/// Bands across the panel, such as phases of contact over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Spans {
    pub(super) intervals: Vec<(f64, f64)>,
    pub(super) orientation: Orientation,
    pub(super) color: Color,
    pub(super) label: Option<String>,
}

impl Spans {
    /// Vertical bands over intervals of the horizontal axis. They do not enter an automatic range.
    pub fn new(intervals: Vec<(f64, f64)>) -> Self {
        Spans {
            intervals,
            orientation: Orientation::Vertical,
            color: Color::BAND,
            label: None,
        }
    }

    /// Horizontal bands over intervals of the vertical axis.
    pub fn horizontal(mut self) -> Self {
        self.orientation = Orientation::Horizontal;
        self
    }
}

/// A straight line across the whole panel. It does not enter an automatic range.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    pub(super) at: f64,
    pub(super) orientation: Orientation,
    pub(super) color: Color,
    pub(super) width: f64,
    pub(super) dash: Dash,
    pub(super) label: Option<String>,
}

impl Rule {
    /// From bottom to top at a place on the horizontal axis.
    pub fn vertical(at: f64) -> Self {
        Rule {
            at,
            orientation: Orientation::Vertical,
            color: Color::GREY,
            width: 0.6,
            dash: Dash::Dashed,
            label: None,
        }
    }

    /// From left to right at a place on the vertical axis.
    pub fn horizontal(at: f64) -> Self {
        Rule {
            orientation: Orientation::Horizontal,
            ..Rule::vertical(at)
        }
    }
}

/// What several kinds of layers let one choose.
macro_rules! choices {
    ($(#[$about:meta] $choice:ident($given:ty) of $($kind:ident),+;)+) => {
        $($(impl $kind {
            #[$about]
            pub fn $choice(mut self, $choice: $given) -> Self {
                self.$choice = $choice.into();
                self
            }
        })+)+
    };
}

choices! {
    /// In this colour.
    color(Color) of Line, Markers, Density, Spans, Rule;
    /// So many points thick.
    width(f64) of Line, Rule;
    /// Broken in this way.
    dash(Dash) of Line, Rule;
}

/// What has a place in the legend.
macro_rules! labelled {
    ($($kind:ident),*) => {
        $(impl $kind {
            /// With an entry in the legend.
            pub fn label(mut self, label: impl Into<String>) -> Self {
                self.label = Some(label.into());
                self
            }
        })*
    };
}

labelled!(Line, Markers, Density, Spans, Rule);

macro_rules! into_layer {
    ($($kind:ident),*) => {
        $(impl From<$kind> for Layer {
            fn from(layer: $kind) -> Self {
                Layer::$kind(layer)
            }
        })*
    };
}

into_layer!(Line, Markers, Density, Spans, Rule, HeatMap, CategoryMap);
