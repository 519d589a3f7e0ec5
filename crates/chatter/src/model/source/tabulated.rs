//! Tables of a model that is built from Rust code.

use super::draft::{Column, KnotsDraft, Place, SourceText};
use crate::expressions::{CurveKind, Outside};
use crate::numerics::DoubleDouble;
use std::sync::Arc;

/// Points, and how a curve runs through them, for [`ModelBuilder::table`](crate::model::ModelBuilder::table).
#[derive(Clone, PartialEq, Debug)]
pub struct Table {
    kind: CurveKind,
    outside: Option<Outside>,
    x: Vec<f64>,
    y: Vec<f64>,
    slopes: Option<[f64; 2]>,
}

impl Table {
    /// A curve of this kind through these points, each number meant as its shortest decimal digits say.
    pub fn new(
        kind: CurveKind,
        x: impl IntoIterator<Item = f64>,
        y: impl IntoIterator<Item = f64>,
    ) -> Self {
        Self {
            kind,
            outside: None,
            x: x.into_iter().collect(),
            y: y.into_iter().collect(),
            slopes: None,
        }
    }

    /// What it is before the first and after the last point: without a value, unless this is given.
    #[must_use]
    pub fn outside(mut self, outside: Outside) -> Self {
        self.outside = Some(outside);
        self
    }

    /// The slopes of a cubic spline at its first and its last point.
    #[must_use]
    pub fn slopes(mut self, first: f64, last: f64) -> Self {
        self.slopes = Some([first, last]);
        self
    }

    pub(in crate::model) fn draft(self, name: &str) -> KnotsDraft {
        let place = |key: &str| format!("table.{name}.{key}");
        KnotsDraft {
            kind: self.kind,
            outside: (self.outside)
                .map(|outside| (outside, Place::whole(&place("outside"), outside.name()))),
            x: column(&place("x"), &self.x),
            y: column(&place("y"), &self.y),
            slopes: self.slopes.map(|slopes| column(&place("slopes"), &slopes)),
        }
    }
}

/// The numbers as they would stand in a file.
fn column(name: &str, values: &[f64]) -> Column {
    let mut text = String::from("[");
    let (mut numbers, mut spans) = (Vec::new(), Vec::new());
    for (index, value) in values.iter().enumerate() {
        if index > 0 {
            text += ", ";
        }
        let digits = value.to_string();
        let start = text.len();
        text += &digits;
        spans.push(start..text.len());
        numbers.push(digits.parse().unwrap_or(DoubleDouble::from(*value)));
    }
    text += "]";
    let name = name.to_owned();
    let span = 0..text.len();
    let source = Arc::new(SourceText { name, text });
    let place = Place {
        source: Arc::clone(&source),
        span,
        verbatim: None,
    };
    Column {
        place,
        numbers,
        source,
        spans,
    }
}
