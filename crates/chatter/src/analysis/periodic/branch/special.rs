//! Special points.

use super::Point;
use crate::analysis::periodic::shooting::Shooting;

/// Kinds of special points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpecialKind {
    /// The parameter turns: a multiplier passes 1.
    Fold,
    /// A multiplier passes -1.
    PeriodDoubling,
    /// A complex pair passes the unit circle.
    NeimarkSacker,
    /// Two branches meet.
    BranchPoint,
    /// An impact loses its rate.
    ImpactGraze,
    /// A flight touches a contact.
    FlightGraze,
    /// Complete chatter ends exactly at release.
    ChatterBorder,
    /// Another guard is touched: contact is lost or gained for an instant, or a surface is reached.
    Touch,
}

impl SpecialKind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Fold,
        Self::PeriodDoubling,
        Self::NeimarkSacker,
        Self::BranchPoint,
        Self::ImpactGraze,
        Self::FlightGraze,
        Self::ChatterBorder,
        Self::Touch,
    ];

    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::PeriodDoubling => "period_doubling",
            Self::NeimarkSacker => "neimark_sacker",
            Self::BranchPoint => "branch_point",
            Self::ImpactGraze => "impact_graze",
            Self::FlightGraze => "flight_graze",
            Self::ChatterBorder => "chatter_border",
            Self::Touch => "touch",
        }
    }
}

/// A special point.
#[derive(Clone, Debug)]
pub struct Special {
    /// Which kind.
    pub kind: SpecialKind,
    /// The orbit there.
    pub point: Point,
    /// Estimated error of its parameter.
    pub error: f64,
    /// What vanishes there.
    pub residual: f64,
    /// Of a graze: whether the branch goes on beyond it, rather than turning back.
    pub persists: Option<bool>,
    /// Where it is on its branch: after so many points.
    pub place: usize,
    /// Its equations.
    pub(crate) seed: Option<Seed>,
}

/// Equations and a solution of them.
#[derive(Clone, Debug)]
pub(crate) struct Seed {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
}
