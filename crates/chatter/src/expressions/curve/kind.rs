//! How a curve runs from knot to knot, and what it is beyond them.

use core::fmt;

/// How a curve runs from knot to knot.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum CurveKind {
    /// Straight lines.
    #[default]
    Linear,
    /// The cubic spline, twice continuously differentiable: natural, its second derivative zero at both ends, or clamped,
    /// with given slopes there.
    Cubic,
    /// Monotone between the knots, once continuously differentiable (Fritsch and Carlson).
    Pchip,
    /// The cubic spline that is twice continuously differentiable as a periodic function.
    PeriodicCubic,
    /// Constant from each knot to the next.
    Steps,
}

/// What a curve is before its first knot and after its last.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Outside {
    /// Without a value.
    #[default]
    Error,
    /// What it is at that knot.
    Hold,
}

/// The kinds as they are written.
pub const CURVE_KINDS: &[&str] = &["linear", "cubic", "pchip", "periodic-cubic", "steps"];
/// What may happen outside, as it is written.
pub const OUTSIDES: &[&str] = &["error", "hold"];

impl CurveKind {
    const ALL: [Self; 5] = [
        Self::Linear,
        Self::Cubic,
        Self::Pchip,
        Self::PeriodicCubic,
        Self::Steps,
    ];

    /// As it is written.
    pub fn name(self) -> &'static str {
        CURVE_KINDS[self as usize]
    }

    /// The kind that is written so.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The least number of knots that make one.
    pub fn least_knots(self) -> usize {
        match self {
            Self::PeriodicCubic => 3,
            _ => 2,
        }
    }
}

impl fmt::Display for CurveKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Outside {
    /// As it is written.
    pub fn name(self) -> &'static str {
        OUTSIDES[self as usize]
    }

    /// What is written so.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Error, Self::Hold]
            .into_iter()
            .find(|outside| outside.name() == name)
    }
}
