//! Functions from tables: piecewise polynomials through knots.
//!
//! All coefficients are computed in double-double, so that a run to thirty digits has a curve of thirty digits; what the
//! kinds are is in `docs/tables.md`.

mod build;
mod error;
mod kind;

pub use build::MOST_KNOTS;
pub use error::{Axis, CurveError};
pub use kind::{CURVE_KINDS, CurveKind, OUTSIDES, Outside};

use crate::numerics::{DoubleDouble, Real, last_where};

/// A named function of one argument: a polynomial of degree three at most between each knot and the next.
#[derive(Clone, PartialEq, Debug)]
pub struct Curve {
    name: String,
    kind: CurveKind,
    outside: Option<Outside>,
    /// Arguments of the knots, increasing.
    knots: Vec<DoubleDouble>,
    /// One polynomial for each knot but the last, in powers of the distance from that knot.
    coefficients: Vec<[DoubleDouble; 4]>,
    /// The value at the last knot.
    last: DoubleDouble,
}

/// One polynomial of a [`Curve`], and where it holds: from `low`, included, to `high`, not included.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Piece {
    /// Where it begins; `None` where it has held for ever.
    pub low: Option<DoubleDouble>,
    /// Where it ends; `None` where it never does.
    pub high: Option<DoubleDouble>,
    /// What its argument is counted from.
    pub origin: DoubleDouble,
    /// The value is the sum of `coefficients[k] * (x - origin)^k`.
    pub coefficients: [DoubleDouble; 4],
}

/// So many periods to either side of its table a periodic curve goes on: their numbers, times that of the knots, are
/// integers that are added without loss, and an `f64` that is further away does not know its phase to four digits.
const MOST_LAPS: i64 = 1 << 42;

impl Curve {
    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it runs from knot to knot.
    pub fn kind(&self) -> CurveKind {
        self.kind
    }

    /// What it is beyond its knots; `None` for a periodic curve, which has no beyond.
    pub fn outside(&self) -> Option<Outside> {
        self.outside
    }

    /// Arguments of its knots, increasing.
    pub fn knots(&self) -> &[DoubleDouble] {
        &self.knots
    }

    /// The first and the last knot.
    pub fn range(&self) -> [DoubleDouble; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }

    /// Where its arguments end, the first and the last knot; `None` where it goes on beyond them.
    pub fn bounds(&self) -> Option<[DoubleDouble; 2]> {
        (self.outside == Some(Outside::Error)).then(|| self.range())
    }

    /// The period of a periodic curve.
    pub fn period(&self) -> Option<DoubleDouble> {
        let [first, last] = self.range();
        self.outside.is_none().then(|| last - first)
    }

    /// Highest degree of its polynomials.
    pub fn degree(&self) -> usize {
        match self.kind {
            CurveKind::Steps => 0,
            CurveKind::Linear => 1,
            CurveKind::Cubic | CurveKind::Pchip | CurveKind::PeriodicCubic => 3,
        }
    }

    /// How many derivatives are continuous at the knots between the first and the last; -1 where not even the value is.
    pub fn smoothness(&self) -> i32 {
        match self.kind {
            CurveKind::Steps => -1,
            CurveKind::Linear => 0,
            CurveKind::Pchip => 1,
            CurveKind::Cubic | CurveKind::PeriodicCubic => 2,
        }
    }

    /// How many pieces there are between the first knot and the last.
    fn inner(&self) -> i64 {
        self.coefficients.len() as i64
    }

    /// Number of the piece that holds `x`: 0 from the first knot to the second, and so on, -1 before all. In a periodic
    /// curve numbers go on from period to period. The last knot belongs to what follows it, unless that is outside.
    pub fn piece_at(&self, x: DoubleDouble) -> i64 {
        let Some(period) = self.period() else {
            let number = self.knots.partition_point(|&knot| knot <= x) as i64 - 1;
            let at_end = number == self.inner() && x == self.range()[1];
            return match self.outside {
                Some(Outside::Error) if at_end => number - 1,
                _ => number,
            };
        };
        let lap = libm::floor(((x - self.knots[0]) / period).high());
        if lap.abs() >= MOST_LAPS as f64 {
            return if lap < 0.0 { i64::MIN } else { i64::MAX };
        }
        // The quotient is rounded: the ends of the period decide.
        let mut lap = lap as i64;
        lap -= i64::from(x < self.knot(lap * self.inner()));
        lap += i64::from(self.knot((lap + 1) * self.inner()) <= x);
        let first = lap * self.inner();
        // Knot `first` is at or below x.
        last_where(first, first + self.inner(), |number| self.knot(number) <= x)
    }

    /// Where piece `number` of a periodic curve begins.
    fn knot(&self, number: i64) -> DoubleDouble {
        let [first, last] = self.range();
        let (lap, place) = (
            number.div_euclid(self.inner()),
            number.rem_euclid(self.inner()),
        );
        self.knots[place as usize] + (last - first) * DoubleDouble::from(lap as f64)
    }

    /// Piece `number`; `None` where the curve has no value.
    pub fn piece(&self, number: i64) -> Option<Piece> {
        let inner = self.inner();
        if self.outside.is_none() {
            // One lap more: rounding may have put the number there.
            if number.checked_abs()? > (MOST_LAPS + 1) * inner {
                return None;
            }
            let origin = self.knot(number);
            return Some(Piece {
                low: Some(origin),
                high: Some(self.knot(number + 1)),
                origin,
                coefficients: self.coefficients[number.rem_euclid(inner) as usize],
            });
        }
        let [first, last] = self.range();
        if (0..inner).contains(&number) {
            let place = number as usize;
            return Some(Piece {
                low: Some(self.knots[place]),
                high: Some(self.knots[place + 1]),
                origin: self.knots[place],
                coefficients: self.coefficients[place],
            });
        }
        if self.outside == Some(Outside::Error) {
            return None;
        }
        let zero = DoubleDouble::ZERO;
        let held = |value| [value, zero, zero, zero];
        Some(if number < 0 {
            Piece {
                low: None,
                high: Some(first),
                origin: first,
                coefficients: held(self.coefficients[0][0]),
            }
        } else {
            Piece {
                low: Some(last),
                high: None,
                origin: last,
                coefficients: held(self.last),
            }
        })
    }

    /// The value at `x`, or a derivative of it; NaN outside where the curve has none. At a knot derivatives are those of
    /// the piece that begins there.
    pub fn value<R: Real>(&self, x: R, derivative: u8) -> R {
        let at = x.to_double_double();
        match self.piece(self.piece_at(at)) {
            Some(piece) if !at.high().is_nan() => piece.value(x, derivative),
            _ => R::splat(f64::NAN),
        }
    }
}

impl Piece {
    /// The polynomial's value at `x`, or a derivative of it, whether or not it holds there.
    pub fn value<R: Real>(&self, x: R, derivative: u8) -> R {
        let order = usize::from(derivative);
        let derived = |power: usize| {
            // power! / (power - order)!
            let factor: usize = (power - order + 1..=power).product();
            R::from_double_double(self.coefficients[power] * DoubleDouble::from(factor as f64))
        };
        // A constant is multiplied with no distance, which may be infinite.
        let significant = |c: &DoubleDouble| *c != DoubleDouble::ZERO;
        let top = self.coefficients.iter().rposition(significant);
        let Some(top) = top.filter(|&top| top >= order) else {
            return R::ZERO;
        };
        let distance = R::from_double_double(x.to_double_double() - self.origin);
        (order..top).rev().fold(derived(top), |value, power| {
            value.mul_add(distance, derived(power))
        })
    }
}

#[cfg(test)]
mod tests;
