//! What happens where several contacts touch at one instant, and what files call it.

/// The law of simultaneous impacts.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Simultaneous {
    /// One contact after the other, that which closes fastest first, until none that touches closes any more.
    #[default]
    Binary,
    /// All touching contacts at once (Moreau 1988): impulses p >= 0 with v+ + r v- >= 0 and p (v+ + r v-) = 0.
    Moreau,
}

/// What model files call the laws.
pub(super) const LAWS: &[&str] = &["binary", "moreau"];

impl Simultaneous {
    /// The law that model files call `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "binary" => Some(Self::Binary),
            "moreau" => Some(Self::Moreau),
            _ => None,
        }
    }

    /// What model files call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Binary => "binary",
            Self::Moreau => "moreau",
        }
    }
}
