//! Tables become curves.

use super::Assembly;
use crate::expressions::{Axis, Curve, CurveError, CurveKind};
use crate::model::error::{ModelError, ModelErrorKind};
use crate::model::source::curve_table::read_for;
use crate::model::source::draft::{Draft, KnotsDraft, Place, TableDraft};
use crate::numerics::DoubleDouble;
use std::sync::Arc;

impl<'a> Assembly<'a> {
    /// Makes the curves, before anything is read that may use them. One that cannot be made is reported, and another
    /// stands for it, so that the formulas that use it are read.
    pub(super) fn read_tables(&mut self, draft: &'a Draft) {
        for TableDraft { name, knots } in &draft.tables {
            if self.graph.curve_named(&name.text).is_some() {
                // Reported as a name that is given twice.
                continue;
            }
            let curve = knots.as_ref().and_then(|knots| {
                let made = knots.curve(&name.text);
                made.map_err(|error| self.errors.push(knots.error(&name.text, error)))
                    .ok()
            });
            if let Some(curve) = curve.or_else(|| stand_in(&name.text)) {
                self.graph.add_curve(curve);
            }
        }
    }
}

fn stand_in(name: &str) -> Option<Curve> {
    let ends = [0.0, 1.0].map(DoubleDouble::from);
    Curve::new(name, CurveKind::Linear, None, &ends, &ends, None).ok()
}

impl KnotsDraft {
    fn curve(&self, name: &str) -> Result<Curve, CurveError> {
        let outside = self.outside.as_ref().map(|(outside, _)| *outside);
        // Two, as was checked where they were read.
        let slopes = self
            .slopes
            .as_ref()
            .map(|slopes| [slopes.numbers[0], slopes.numbers[1]]);
        Curve::new(
            name,
            self.kind,
            outside,
            &self.x.numbers,
            &self.y.numbers,
            slopes,
        )
    }

    fn error(&self, name: &str, error: CurveError) -> ModelError {
        let slope = |end: usize| self.slopes.as_ref().map(|slopes| slopes.place_of(end));
        let place = match error {
            CurveError::Lengths { .. } => self.y.place.clone(),
            CurveError::TooFew { .. } | CurveError::TooMany { .. } => self.x.place.clone(),
            CurveError::NotFinite {
                axis: Axis::X,
                index,
                ..
            }
            | CurveError::NotIncreasing { index, .. }
            | CurveError::Overflow { index } => self.x.place_of(index),
            CurveError::NotFinite {
                axis: Axis::Y,
                index,
                ..
            }
            | CurveError::PeriodNotClosed { index, .. } => self.y.place_of(index),
            CurveError::OutsideOfPeriodic => {
                let outside = self.outside.as_ref().map(|(_, place)| place.clone());
                outside.unwrap_or_else(|| self.x.place.clone())
            }
            CurveError::SlopesOfKind { .. } => {
                let slopes = self.slopes.as_ref().map(|slopes| slopes.place.clone());
                slopes.unwrap_or_else(|| self.x.place.clone())
            }
            CurveError::SlopeNotFinite { end, .. } => {
                slope(end).unwrap_or_else(|| self.x.place.clone())
            }
        };
        let table = name.to_owned();
        let found = ModelError::new(ModelErrorKind::Curve { table, error }, &place);
        match self.named_at(&place) {
            Some(named) => found.with_related(named, read_for(name)),
            None => found,
        }
    }

    /// Where the model names the file that this place is in, if it is in one.
    fn named_at(&self, place: &Place) -> Option<&Place> {
        let named = &self.x.place;
        (!Arc::ptr_eq(&place.source, &named.source) && Arc::ptr_eq(&place.source, &self.x.source))
            .then_some(named)
    }
}
