//! Special points.

use super::Point;
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::Complex;
use crate::numerics::stored::{list, number};
use serde::{Deserialize, Serialize};

/// Kinds of special points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SpecialKind {
    /// The parameter turns: a multiplier passes 1.
    Fold,
    /// A multiplier passes -1.
    PeriodDoubling,
    /// A complex pair passes the unit circle.
    NeimarkSacker,
    /// The orbit shrinks to an equilibrium, of which a pair of eigenvalues passes the imaginary axis.
    Hopf,
    /// Two branches meet.
    BranchPoint,
    /// An impact loses its rate as the parameter grows: the flight that it parts is free of the contact where the parameter is
    /// greater.
    ImpactGraze,
    /// A flight touches a contact as the parameter grows: it is free of it where the parameter is less.
    FlightGraze,
    /// Complete chatter ends exactly at release.
    ChatterBorder,
    /// Another guard is touched: contact is lost or gained for an instant, or a surface is reached.
    Touch,
    /// A function of the user's vanishes.
    Monitor,
    /// Two folds meet.
    Cusp,
    /// Multipliers 1 and -1.
    FoldFlip,
    /// A period doubling changes the side to which the doubled orbit goes.
    GeneralisedDoubling,
    /// Two multipliers 1.
    Resonance11,
    /// Two multipliers -1.
    Resonance12,
    /// A pair at a third of a turn.
    Resonance13,
    /// A pair at a quarter of a turn.
    Resonance14,
    /// A multiplier 1 and a pair on the unit circle.
    FoldTorus,
    /// A multiplier -1 and a pair on the unit circle.
    FlipTorus,
    /// A fold where an impact has no rate.
    GrazeFold,
    /// A period doubling where an impact has no rate.
    GrazeDoubling,
    /// A pair on the unit circle where an impact has no rate.
    GrazeTorus,
    /// Two impacts without rate.
    DoubleGraze,
    /// A fold where complete chatter ends exactly at release.
    BorderFold,
    /// A period doubling where complete chatter ends exactly at release.
    BorderDoubling,
}

impl SpecialKind {
    /// All kinds.
    pub const ALL: [Self; 25] = [
        Self::Fold,
        Self::PeriodDoubling,
        Self::NeimarkSacker,
        Self::Hopf,
        Self::BranchPoint,
        Self::ImpactGraze,
        Self::FlightGraze,
        Self::ChatterBorder,
        Self::Touch,
        Self::Monitor,
        Self::Cusp,
        Self::FoldFlip,
        Self::GeneralisedDoubling,
        Self::Resonance11,
        Self::Resonance12,
        Self::Resonance13,
        Self::Resonance14,
        Self::FoldTorus,
        Self::FlipTorus,
        Self::GrazeFold,
        Self::GrazeDoubling,
        Self::GrazeTorus,
        Self::DoubleGraze,
        Self::BorderFold,
        Self::BorderDoubling,
    ];

    /// Whether an orbit at a point of this kind, which curves are of, has a multiplier on the unit circle.
    pub(crate) fn has_neutral_multiplier(self) -> bool {
        matches!(
            self,
            Self::Fold | Self::PeriodDoubling | Self::NeimarkSacker | Self::BranchPoint
        )
    }

    /// Whether curves in two parameters of points of this kind are followed.
    pub(in crate::analysis::periodic) const fn has_curve(self) -> bool {
        matches!(
            self,
            Self::Fold
                | Self::PeriodDoubling
                | Self::NeimarkSacker
                | Self::ImpactGraze
                | Self::FlightGraze
                | Self::ChatterBorder
                | Self::Monitor
        )
    }

    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::PeriodDoubling => "period_doubling",
            Self::NeimarkSacker => "neimark_sacker",
            Self::Hopf => "hopf",
            Self::BranchPoint => "branch_point",
            Self::ImpactGraze => "impact_graze",
            Self::FlightGraze => "flight_graze",
            Self::ChatterBorder => "chatter_border",
            Self::Touch => "touch",
            Self::Monitor => "monitor",
            Self::Cusp => "cusp",
            Self::FoldFlip => "fold_flip",
            Self::GeneralisedDoubling => "generalised_doubling",
            Self::Resonance11 => "resonance_1_1",
            Self::Resonance12 => "resonance_1_2",
            Self::Resonance13 => "resonance_1_3",
            Self::Resonance14 => "resonance_1_4",
            Self::FoldTorus => "fold_torus",
            Self::FlipTorus => "flip_torus",
            Self::GrazeFold => "graze_fold",
            Self::GrazeDoubling => "graze_doubling",
            Self::GrazeTorus => "graze_torus",
            Self::DoubleGraze => "double_graze",
            Self::BorderFold => "border_fold",
            Self::BorderDoubling => "border_doubling",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Whether more than one branch goes through special points of this kind: a monitor vanishes wherever it does.
    pub(in crate::analysis::periodic) const fn meets(self) -> bool {
        matches!(
            self,
            Self::BranchPoint | Self::PeriodDoubling | Self::Monitor
        )
    }

    /// Whether an impact or a flight grazes.
    pub const fn is_graze(self) -> bool {
        matches!(self, Self::ImpactGraze | Self::FlightGraze)
    }

    /// Whether points of both kinds may lie on one curve in two parameters: which of its names a graze has is a matter of which way the gap
    /// goes over one of them, and that may change along the curve.
    pub(in crate::analysis::periodic) fn shares_curves(self, other: Self) -> bool {
        self == other || (self.is_graze() && other.is_graze())
    }
}

/// A special point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Special {
    /// Which kind.
    pub kind: SpecialKind,
    /// The orbit there.
    pub point: Point,
    /// Estimated error of its parameter.
    #[serde(with = "number")]
    pub error: f64,
    /// What vanishes there.
    #[serde(with = "number")]
    pub residual: f64,
    /// Of a graze: whether the branch goes on beyond it, rather than turning back.
    pub persists: Option<bool>,
    /// Of a fold and of a period doubling: whether the orbits that it joins, or the doubled ones, are where the parameter is
    /// greater.
    pub above: Option<bool>,
    /// Which of the user's functions vanishes.
    pub monitor: Option<usize>,
    /// The direction in which to go on from there, as that of a station: of a branch point that of the other branch, of a chatter border its own.
    #[serde(with = "list")]
    pub leaves: Vec<f64>,
    /// Where it is on its branch: after so many points.
    pub place: usize,
    /// Its equations.
    #[serde(skip)]
    pub(crate) seed: Option<Seed>,
}

/// How near two special points are that are one.
#[derive(Clone, Copy, Debug)]
pub(in crate::analysis::periodic) struct Near {
    /// Their parameters.
    pub parameter: f64,
    /// States of their orbits, against their size.
    pub state: f64,
}

impl Near {
    /// On branches that were followed from different orbits over such a range: where orbits fold they change much with the parameter.
    pub(in crate::analysis::periodic) fn over((low, high): (f64, f64)) -> Self {
        Self {
            parameter: 1e-9 * (high - low),
            state: 1e-5,
        }
    }

    /// On one branch: as far as both parameters are known.
    pub(super) fn known(one: &Special, other: &Special) -> Self {
        Self {
            parameter: one.error + other.error,
            state: 1e-8,
        }
    }
}

impl Special {
    /// Whether it is the same point of the same branch.
    pub(in crate::analysis::periodic) fn is_that_of(&self, other: &Self, near: Near) -> bool {
        self.is_like(other, near) && self.shares_orbit(other, near)
    }

    /// Whether it is that, or the mirror image of that: all but the states are the same.
    pub(super) fn is_like(&self, other: &Self, near: Near) -> bool {
        let (own, others) = (self.point.period, other.point.period);
        self.kind == other.kind
            && self.point.impacts == other.point.impacts
            && (own - others).abs() <= near.state * own.abs()
            && self.is_at(other, near)
    }

    /// Whether it is the same point or its mirror image, of branches of which all is the same but states: multipliers as well.
    pub(in crate::analysis::periodic) fn is_image_of(&self, other: &Self, near: Near) -> bool {
        let (own, others) = (&self.point.multipliers, &other.point.multipliers);
        let are_one = |(a, b): (&Complex, &Complex)| {
            (a.re - b.re).hypot(a.im - b.im) <= near.state * (1.0 + a.modulus())
        };
        self.is_like(other, near)
            && own.len() == others.len()
            && own.iter().zip(others).all(are_one)
    }

    /// How many of a branch's special points are this one: those of impacts that lose their rates at once.
    pub(super) fn events_among(&self, all: &[Self]) -> usize {
        let is_this =
            |other: &&Self| other.place == self.place && other.told_as() == self.told_as();
        all.iter().filter(is_this).count()
    }

    /// What those share that were told as one: their kind, and the parameter to the bit.
    pub(in crate::analysis::periodic) fn told_as(&self) -> (SpecialKind, u64) {
        (self.kind, self.point.parameter().to_bits())
    }

    /// Whether both are at one value of the parameter.
    fn is_at(&self, other: &Self, near: Near) -> bool {
        (self.point.parameter() - other.point.parameter()).abs() <= near.parameter
    }

    /// Whether both have one orbit, be it that one of them goes around it more often. It may be told from any of its events, and of
    /// whatever turn of its phases.
    pub(in crate::analysis::periodic) fn shares_orbit(&self, other: &Self, near: Near) -> bool {
        if !self.is_at(other, near) {
            return false;
        }
        let (Some(own), Some(others)) = (&self.seed, &other.seed) else {
            return false;
        };
        let shooting = &own.shooting;
        let parameters = shooting.workshop.parameters(shooting.free(&own.at));
        let closure = &shooting.workshop.closure;
        let Ok(turns) = closure.turns(&parameters) else {
            return false;
        };
        let states = (&*own.landmarks(), &*others.landmarks());
        closure.share(&turns, states, &shooting.state_sizes(), near.state)
    }
}

/// Equations and a solution of them.
#[derive(Clone, Debug)]
pub(crate) struct Seed {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
}

impl Seed {
    /// The states that its orbit is known by.
    pub(in crate::analysis::periodic) fn landmarks(&self) -> Vec<Vec<f64>> {
        self.shooting.clone().landmarks(&self.at)
    }
}
