//! Axes: label, unit, scale and range, and the way from a number to a place on the page.

use super::figure_error::{AxisSide, FigureError};
use super::ticks::{self, Notation, Numbers, Ticks};

/// How numbers are laid out along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal differences are equal lengths.
    #[default]
    Linear,
    /// Equal ratios are equal lengths; what is not positive is not drawn.
    Logarithmic,
}

impl Scale {
    /// The coordinate that is linear along the axis; not-a-number where there is none.
    pub(super) fn forward(self, x: f64) -> f64 {
        match self {
            Scale::Linear => x,
            Scale::Logarithmic if x > 0.0 => libm::log10(x),
            Scale::Logarithmic => f64::NAN,
        }
    }

    /// Inverse of [`Scale::forward`].
    pub(super) fn backward(self, u: f64) -> f64 {
        match self {
            Scale::Linear => u,
            Scale::Logarithmic => libm::pow(10.0, u),
        }
    }
}

/// Which numbers an axis shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Range {
    /// All that the layers hold, and a little room beside it.
    #[default]
    Padded,
    /// From the least to the largest number that the layers hold.
    Tight,
    /// From the first to the second number, which must be larger.
    Given(f64, f64),
}

/// Which way numbers grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// To the right and upwards.
    #[default]
    Forward,
    /// To the left and downwards.
    Reversed,
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// What the numbers are, as a label.
    pub label: String,
    /// Their unit, written in parentheses after the label.
    pub unit: Option<String>,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Which numbers are shown.
    pub range: Range,
    /// Which way they grow.
    pub direction: Direction,
    /// Whether there are others than whole ones.
    pub numbers: Numbers,
}

impl Axis {
    /// A linear axis over all that the layers hold.
    pub fn new(label: impl Into<String>) -> Self {
        Axis {
            label: label.into(),
            ..Axis::default()
        }
    }

    /// With a unit.
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// Logarithmic.
    pub fn logarithmic(mut self) -> Self {
        self.scale = Scale::Logarithmic;
        self
    }

    /// From `low` to `high`.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Range::Given(low, high);
        self
    }

    /// Just as far as the layers reach.
    pub fn tight(mut self) -> Self {
        self.range = Range::Tight;
        self
    }

    /// Growing to the left or downwards.
    pub fn reversed(mut self) -> Self {
        self.direction = Direction::Reversed;
        self
    }

    /// Of whole numbers.
    pub fn whole(mut self) -> Self {
        self.numbers = Numbers::Whole;
        self
    }

    /// Label and unit.
    pub(super) fn full_label(&self) -> String {
        match &self.unit {
            Some(unit) => format!("{} ({unit})", self.label),
            None => self.label.clone(),
        }
    }

    /// The shown range, for layers that reach over `data` (in the scale's linear coordinate, if anywhere).
    pub(super) fn limits(&self, side: AxisSide, data: Extent) -> Result<Limits, FigureError> {
        let (low, high) = match self.range {
            Range::Given(low, high) => {
                let fail = |what| {
                    Err(FigureError::Range {
                        axis: side,
                        label: self.label.clone(),
                        low,
                        high,
                        what,
                    })
                };
                if !(low.is_finite() && high.is_finite()) {
                    return fail("is not finite");
                }
                if low > high {
                    return fail("is reversed; give the smaller number first and reverse the axis");
                }
                if low == high {
                    return fail("is empty");
                }
                if self.scale == Scale::Logarithmic && low <= 0.0 {
                    return fail("reaches zero or below on a logarithmic axis");
                }
                let ends = (self.scale.forward(low), self.scale.forward(high));
                if widened(ends.0, ends.1) != ends {
                    return fail("is too narrow for numbers in it to be told apart");
                }
                ends
            }
            Range::Tight => data.or_default(),
            Range::Padded => {
                let (low, high) = data.or_default();
                // Halves first: the difference of two huge numbers may overflow.
                let pad = 2.0 * PADDING * (0.5 * high - 0.5 * low);
                ((low - pad).max(f64::MIN), (high + pad).min(f64::MAX))
            }
        };
        let (low, high) = widened(low, high);
        Ok(Limits {
            scale: self.scale,
            direction: self.direction,
            numbers: self.numbers,
            centre: None,
            low,
            high,
        })
    }
}

/// Room beside the data, as a part of their range.
const PADDING: f64 = 0.04;
/// Narrowest range drawn, relative to the size of its numbers: narrower ones are lost in rounding.
const NARROWEST: f64 = 1e-13;

/// Narrowest range drawn at all: quotients of narrower ones are lost below the smallest number.
const NARROWEST_AT_ZERO: f64 = 1e-290;

/// The range widened, if need be, until numbers in it can be told apart.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if low == high {
        let by = if size < NARROWEST_AT_ZERO {
            0.5
        } else {
            0.05 * size
        };
        return ((low - by).max(f64::MIN), (high + by).min(f64::MAX));
    }
    let narrowest = (NARROWEST * size).max(NARROWEST_AT_ZERO);
    if 0.5 * high - 0.5 * low < 0.5 * narrowest {
        return (low - narrowest, high + narrowest);
    }
    (low, high)
}

/// From where to where the data of an axis reach; nowhere at first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Extent {
    pub(super) const NOWHERE: Extent = Extent {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    /// Takes in a number, unless it is not finite.
    pub(super) fn add(&mut self, x: f64) {
        if x.is_finite() {
            self.low = self.low.min(x);
            self.high = self.high.max(x);
        }
    }

    pub(super) fn join(&mut self, other: Extent) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    fn or_default(self) -> (f64, f64) {
        if self.low <= self.high {
            (self.low, self.high)
        } else {
            (0.0, 1.0)
        }
    }
}

/// What an axis shows, in its scale's linear coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    pub(super) scale: Scale,
    pub(super) direction: Direction,
    numbers: Numbers,
    /// What stands in the middle, each side of it having a unit of its own.
    pub(super) centre: Option<f64>,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Limits {
    pub(super) fn ticks(&self, most: usize, notation: Notation) -> Ticks {
        match self.scale {
            Scale::Linear if let Some(centre) = self.centre => {
                ticks::two_sided(self.low, centre, self.high, most)
            }
            Scale::Linear => ticks::linear(self.low, self.high, most, self.numbers, notation),
            Scale::Logarithmic => {
                let least = f64::MIN_POSITIVE;
                let low = self.scale.backward(self.low).clamp(least, f64::MAX);
                let high = self.scale.backward(self.high).clamp(least, f64::MAX);
                ticks::logarithmic(low, high, most, notation)
            }
        }
    }

    /// Lays the axis along the page from `start` to `end`.
    pub(super) fn place(&self, start: f64, end: f64) -> Placed {
        let (start, end) = match self.direction {
            Direction::Forward => (start, end),
            Direction::Reversed => (end, start),
        };
        Placed {
            limits: *self,
            start,
            end,
        }
    }
}

/// An axis on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placed {
    pub(super) limits: Limits,
    start: f64,
    end: f64,
}

impl Placed {
    /// Where a number is, in points; not-a-number if nowhere.
    pub(super) fn at(&self, x: f64) -> f64 {
        self.at_linear(self.limits.scale.forward(x))
    }

    /// Where a linear coordinate is.
    pub(super) fn at_linear(&self, u: f64) -> f64 {
        let (low, high) = (self.limits.low, self.limits.high);
        // Halves, since the range of two huge numbers may overflow.
        let part = |low: f64, high: f64| (0.5 * u - 0.5 * low) / (0.5 * high - 0.5 * low);
        let t = match self.limits.centre {
            None => part(low, high),
            Some(centre) if u < centre => 0.5 * part(low, centre),
            Some(centre) => 0.5 + 0.5 * part(centre, high),
        };
        self.start + t * (self.end - self.start)
    }

    /// The linear coordinate at a place.
    pub(super) fn linear_at(&self, place: f64) -> f64 {
        let t = (place - self.start) / (self.end - self.start);
        let (low, high) = (self.limits.low, self.limits.high);
        match self.limits.centre {
            None => low + t * (high - low),
            Some(centre) if t < 0.5 => low + 2.0 * t * (centre - low),
            Some(centre) => centre + (2.0 * t - 1.0) * (high - centre),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(low: f64, high: f64) -> Extent {
        Extent { low, high }
    }

    #[test]
    fn wrong_ranges_are_refused_with_their_numbers() {
        let text = |axis: Axis| {
            axis.limits(AxisSide::X, Extent::NOWHERE)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            text(Axis::new("$q$").range(2.0, 1.0)),
            "horizontal axis `$q$`: range 2 to 1 is reversed; give the smaller number first and reverse the axis"
        );
        assert!(text(Axis::new("").range(1.0, 1.0)).ends_with("is empty"));
        assert!(text(Axis::new("").range(0.0, 5e-324)).ends_with("to be told apart"));
        assert!(text(Axis::new("").range(0.0, f64::NAN)).ends_with("is not finite"));
        assert!(text(Axis::new("").logarithmic().range(0.0, 1.0)).ends_with("logarithmic axis"));
    }

    #[test]
    fn degenerate_and_extreme_data_get_a_range_of_some_width() {
        for data in [
            extent(0.0, 0.0),
            extent(5.0, 5.0),
            extent(1.0, 1.0 + f64::EPSILON),
            extent(-f64::MAX, f64::MAX),
            extent(0.0, 5e-324),
            extent(5e-324, 5e-324),
            extent(-1e-300, 1e-295),
            extent(1e300, 1e300),
            Extent::NOWHERE,
        ] {
            for axis in [Axis::new(""), Axis::new("").tight()] {
                let limits = axis.limits(AxisSide::Y, data).unwrap();
                assert!(
                    limits.low < limits.high && limits.low.is_finite() && limits.high.is_finite()
                );
                assert!(
                    !limits.ticks(5, Notation::Plain).major.is_empty(),
                    "{data:?}"
                );
                let placed = limits.place(0.0, 100.0);
                let middle = placed.at_linear(0.5 * limits.low + 0.5 * limits.high);
                assert!((middle - 50.0).abs() < 1.0, "{middle}");
            }
        }
    }
}
