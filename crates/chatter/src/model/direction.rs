//! Which crossings of a surface count, and what files call them.

/// Which crossings of a surface count: changes of the sign of its function, be it that the function runs through zero or that
/// an impact makes it jump. Zero is no sign: touching the surface, resting in it and starting on it are no crossings.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Direction {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both.
    Either,
}

/// What model files call the directions.
pub(super) const DIRECTIONS: &[&str] = &["rising", "falling", "either"];

impl Direction {
    /// The direction that model files call `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "rising" => Some(Self::Rising),
            "falling" => Some(Self::Falling),
            "either" => Some(Self::Either),
            _ => None,
        }
    }

    /// What model files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rising => "rising",
            Self::Falling => "falling",
            Self::Either => "either",
        }
    }
}
