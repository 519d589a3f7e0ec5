//! Images of intervals under F(x) = K Upsilon(x) + mu.

use super::super::evaluate::Universal;

/// A closed interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    pub(super) const WHOLE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    pub(super) fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    pub(super) fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    pub(super) fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    pub(super) fn hull(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }

    pub(super) fn meet(self, other: Self) -> Self {
        Self::new(self.low.max(other.low), self.high.min(other.high))
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self::new(self.low + other.low, self.high + other.high)
    }

    fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// All products; everything where a factor is unbounded.
    pub(super) fn times(self, other: Self) -> Self {
        if !self.is_bounded() || !other.is_bounded() {
            return Self::WHOLE;
        }
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        Self::new(
            products.iter().fold(f64::INFINITY, |a, &b| a.min(b)),
            products.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)),
        )
    }
}

/// Upsilon on intervals. Bounds hold up to rounding errors.
pub(super) struct Enclosing<'a> {
    pub universal: &'a Universal<f64>,
    lambda_squared: f64,
    slope_ratio: f64,
    /// Values at the critical point and at the end of lap 0, and the slope where it begins.
    peak: f64,
    trough: f64,
    greatest_slope: f64,
}

impl<'a> Enclosing<'a> {
    pub(super) fn new(universal: &'a Universal<f64>) -> Self {
        let c = universal.constants();
        let lambda_squared = c.lambda * c.lambda;
        Self {
            universal,
            lambda_squared,
            slope_ratio: lambda_squared / c.eta,
            peak: universal.value(universal.critical_point(0)),
            trough: universal.value(universal.lap_end()),
            greatest_slope: universal.greatest_slope(),
        }
    }

    fn peak(&self, lap: f64) -> f64 {
        self.peak * libm::pow(self.lambda_squared, lap)
    }

    /// Values of Upsilon over an interval, and of its derivative.
    pub(super) fn image(&self, x: Interval) -> (Interval, Interval) {
        let (a, b) = (self.universal.at(x.low), self.universal.at(x.high));
        let ends = Interval::new(a.value.min(b.value), a.value.max(b.value));
        if x.high <= 0.0 {
            return (Interval::point(0.0), Interval::point(0.0));
        }
        if a.lap == b.lap {
            // Concave: the slope falls, and the greatest value is at an end or where the slope is zero.
            let turns = a.derivative > 0.0 && b.derivative < 0.0;
            let high = if turns { self.peak(a.lap) } else { ends.high };
            return (
                Interval::new(ends.low, high),
                Interval::new(b.derivative, a.derivative),
            );
        }
        // Of the peaks and ends of laps inside, those furthest to the right are the greatest.
        let peak = if b.derivative < 0.0 {
            self.peak(b.lap)
        } else if a.lap > b.lap + 1.0 || a.derivative > 0.0 {
            self.peak(b.lap + 1.0)
        } else {
            ends.high
        };
        let trough = self.trough * libm::pow(self.lambda_squared, b.lap + 1.0);
        let steepest = self.greatest_slope * libm::pow(self.slope_ratio, b.lap);
        (
            Interval::new(ends.low.min(trough), ends.high.max(peak)),
            Interval::new(f64::NEG_INFINITY, steepest),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn images_hold_the_values(
            r in 0.05_f64..0.97,
            low in -6.0_f64..1.0,
            length in -6.0_f64..1.0,
            part in 0.0_f64..1.0,
        ) {
            let universal = Universal::new(r).unwrap();
            let low = libm::exp10(low) * universal.lap_end();
            let x = Interval::new(low, low + libm::exp10(length) * universal.lap_end());
            let (values, slopes) = Enclosing::new(&universal).image(x);
            let at = universal.at(x.low + part * (x.high - x.low));
            let room = 1e-13 * (values.high - values.low).abs() + 1e-15 * values.high.abs();
            prop_assert!(values.low - room <= at.value && at.value <= values.high + room);
            prop_assert!(slopes.low - 1e-9 <= at.derivative && at.derivative <= slopes.high + 1e-9);
        }
    }
}
