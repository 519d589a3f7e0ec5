//! What can keep a figure from being drawn.

use std::fmt;

use super::labels::label::LabelError;

/// Which axis of a panel is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisSide {
    /// The horizontal axis.
    X,
    /// The vertical axis.
    Y,
    /// The scale of colours.
    Color,
}

impl fmt::Display for AxisSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            AxisSide::X => "horizontal axis",
            AxisSide::Y => "vertical axis",
            AxisSide::Color => "colour scale",
        })
    }
}

/// A figure cannot be drawn as described.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FigureError {
    /// A label's markup is wrong.
    Label(LabelError),
    /// A given range is empty, reversed or not finite, or reaches below zero on a logarithmic axis.
    Range {
        /// The axis.
        axis: AxisSide,
        /// Its label.
        label: String,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
        /// What is wrong.
        what: &'static str,
    },
    /// The coordinates of one layer differ in number.
    UnequalLengths {
        /// What has those coordinates.
        layer: &'static str,
        /// Number of horizontal coordinates, or of cells expected.
        x: usize,
        /// Number of vertical coordinates, or of cells given.
        y: usize,
    },
    /// The cells of a map are not in increasing order.
    Unordered {
        /// The axis along which they are not.
        axis: AxisSide,
        /// First index whose coordinate is not above the one before.
        index: usize,
    },
    /// A cell of a map names a category that does not exist.
    NoSuchCategory {
        /// The number in the cell.
        category: usize,
        /// How many categories there are.
        known: usize,
    },
    /// A density was counted on one scale and is to be drawn on another.
    ScaleMismatch {
        /// The axis.
        axis: AxisSide,
    },
    /// The figure is too small for its labels, or its size is not a size.
    TooSmall {
        /// Width in millimetres.
        width: f64,
        /// Height in millimetres.
        height: f64,
    },
    /// The figure has more picture elements than can be drawn.
    TooLarge {
        /// Width in pixels.
        width: f64,
        /// Height in pixels.
        height: f64,
    },
    /// The figure has no panel.
    Empty,
}

impl fmt::Display for FigureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FigureError::Label(e) => e.fmt(f),
            FigureError::Range {
                axis,
                label,
                low,
                high,
                what,
            } => {
                write!(f, "{axis}")?;
                if !label.is_empty() {
                    write!(f, " `{label}`")?;
                }
                let told = |end: f64| match end.abs() {
                    0.0 | 1e-4..1e6 => format!("{end}"),
                    _ => format!("{end:e}"),
                };
                write!(f, ": range {} to {} {what}", told(*low), told(*high))
            }
            FigureError::UnequalLengths { layer, x, y } => {
                write!(
                    f,
                    "{layer}: {x} values on one side do not go with {y} on the other"
                )
            }
            FigureError::Unordered { axis, index } => {
                write!(
                    f,
                    "map: cell {index} along the {axis} is not above the one before it"
                )
            }
            FigureError::NoSuchCategory { category, known } => {
                write!(
                    f,
                    "map: a cell has category {category}, but only {known} are named (counted from 0)"
                )
            }
            FigureError::ScaleMismatch { axis } => {
                write!(
                    f,
                    "density: it was counted on another scale than the {axis} has"
                )
            }
            FigureError::TooSmall { width, height } => {
                write!(
                    f,
                    "a figure of {width} mm by {height} mm leaves no room for its panels beside their labels"
                )
            }
            FigureError::TooLarge { width, height } => {
                write!(f, "a picture of {width} by {height} pixels is too large")
            }
            FigureError::Empty => f.write_str("the figure has no panel"),
        }
    }
}

impl std::error::Error for FigureError {}

impl From<LabelError> for FigureError {
    fn from(e: LabelError) -> Self {
        FigureError::Label(e)
    }
}
