//! Guards: functions of state that end a mode where they vanish, and what that leads to.
//!
//! A guard carries its [`Transition`], settled when its mode is compiled. Steps, roots and the mode machine read it there; none
//! of them works out again what the zero of a gap, a force or a surface means.

use super::closed::Grip;
use super::limits::Corner;
use crate::expressions::{Operand, Side, Tape};
use crate::flow::touching::Touching;
use crate::numerics::roots::Crossing;
use serde::{Deserialize, Serialize};

/// Which function a guard is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum GuardKind {
    /// The gap of an open contact closes: an impact.
    Gap(usize),
    /// The contact force of a closed contact vanishes: release. The guard is minus the reaction.
    Reaction(usize),
    /// A section is crossed.
    Section(usize),
    /// A surface is met from one of its sides.
    Switch(usize),
    /// Sliding along a surface, or sticking, ends towards a side.
    Leave(usize, Side),
    /// The argument of a lookup reaches the end of its piece on a side.
    Piece(usize, Side),
    /// The argument of a lookup leaves what it is looked up in on a side.
    Outside(usize, Side),
    /// The impulse of a contact that slides, with the friction that it brings about, ceases to change its rate.
    Jam(usize),
    /// What a root is taken of on a leg is negative beyond, where the equations have no value: by number among the model's
    /// [`radicands`](crate::model::Model::radicands).
    Root(usize),
}

impl GuardKind {
    /// The guard that ends a stay beyond one that was crossed, where that is a matter of sides.
    pub(crate) fn opposite(self) -> Option<Self> {
        match self {
            Self::Switch(surface) => Some(Self::Switch(surface)),
            Self::Piece(lookup, Side::Above) => Some(Self::Piece(lookup, Side::Below)),
            Self::Piece(lookup, Side::Below) => Some(Self::Piece(lookup, Side::Above)),
            _ => None,
        }
    }
}

/// What the zero of a guard leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Transition {
    /// It is told that a section was crossed, and the motion goes on.
    Cross { section: usize },
    /// The reset of an event is applied.
    Reset { section: usize },
    /// An impact that concerns one contact alone: the step that ends there applies it itself, where nothing else is met there.
    Impact { contact: usize },
    /// The same, whose map has corners that nothing else asks for: which piece of it holds is found at the impact.
    AskImpact { contact: usize },
    /// An impact that other contacts feel: one of several collisions.
    Collide { contact: usize },
    /// A contact opens.
    Open { contact: usize },
    /// A contact opens, or one that was idle carries in its place.
    HandOver { contact: usize },
    /// A surface is met, or the end of a piece: what follows there is asked of all modes that could.
    Meet(Corner),
    /// As [`Meet`](Self::Meet), where sliding or sticking ends: the field goes on without a jump.
    Part(Corner),
    /// The argument of a lookup has left its table: the run ends.
    LeaveTable { lookup: usize },
    /// The impulse of a contact is not determined any more: the run ends.
    Jam { contact: usize },
    /// The equations have no value beyond: the run ends.
    LeaveDomain,
}

impl Transition {
    /// What the zero of a function leads to, in a mode with these closed contacts.
    ///
    /// `is_alone` says of a contact whether its impulse leaves the rates of all closed ones as they are, `asks` whether the map of its
    /// impacts has corners of its own, `is_event` of a section whether it has a reset.
    pub fn new(
        kind: GuardKind,
        grip: Grip,
        (is_alone, asks): (impl Fn(usize) -> bool, impl Fn(usize) -> bool),
        is_event: impl Fn(usize) -> bool,
    ) -> Self {
        match kind {
            GuardKind::Gap(contact) if is_alone(contact) && asks(contact) => {
                Self::AskImpact { contact }
            }
            GuardKind::Gap(contact) if is_alone(contact) => Self::Impact { contact },
            GuardKind::Gap(contact) => Self::Collide { contact },
            GuardKind::Reaction(contact) if grip.has_idle() => Self::HandOver { contact },
            GuardKind::Reaction(contact) => Self::Open { contact },
            GuardKind::Section(section) if is_event(section) => Self::Reset { section },
            GuardKind::Section(section) => Self::Cross { section },
            GuardKind::Switch(index) => Self::Meet(Corner::Surface(index)),
            GuardKind::Piece(index, _) => Self::Meet(Corner::Lookup(index)),
            GuardKind::Outside(lookup, _) => Self::LeaveTable { lookup },
            GuardKind::Leave(index, _) => Self::Part(Corner::Surface(index)),
            GuardKind::Jam(contact) => Self::Jam { contact },
            GuardKind::Root(_) => Self::LeaveDomain,
        }
    }
}

/// A function of state whose zero ends a step. All but those of sections are positive until then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guard {
    /// Which function this is.
    pub kind: GuardKind,
    /// What its zero leads to.
    pub transition: Transition,
    /// Which zeros count, after a rising section's sign was turned.
    pub crossing: Crossing,
    pub series: Operand,
    /// The sign that it has in the mode, if that is on a side of this very surface; zero otherwise.
    pub side: f64,
    /// Whether its series may need shorter steps than those of the states.
    pub is_expanded: bool,
    /// Whether it is a combination of states, which are summed without rounding.
    pub is_affine: bool,
}

impl Guard {
    /// The contact that closes at its zero.
    #[inline(always)]
    pub fn closing(&self) -> Option<usize> {
        match self.transition {
            Transition::Impact { contact }
            | Transition::AskImpact { contact }
            | Transition::Collide { contact } => Some(contact),
            _ => None,
        }
    }

    /// The closed contact whose force vanishes at its zero.
    #[inline(always)]
    pub fn opening(&self) -> Option<usize> {
        match self.transition {
            Transition::Open { contact } | Transition::HandOver { contact } => Some(contact),
            _ => None,
        }
    }

    /// The section that is crossed at its zero: a function that may have either sign, whose side is remembered.
    #[inline(always)]
    pub fn section(&self) -> Option<usize> {
        match self.transition {
            Transition::Cross { section } | Transition::Reset { section } => Some(section),
            _ => None,
        }
    }

    /// Whether a corner that may hold the state exactly on it is met at its zero.
    pub fn meets_corner(&self) -> bool {
        matches!(self.transition, Transition::Meet(_))
    }

    /// Whether a root is taken of it on the side that ends where it vanishes.
    pub fn ends_a_root(&self, tape: &Tape) -> bool {
        self.meets_corner() && tape.takes_root_of(self.series)
    }

    /// Whether this is the reaction of a contact that stays closed without a force, and so no guard.
    pub fn is_balanced(&self, roots: u8) -> bool {
        roots == Touching::BALANCED && self.closing().is_none() && self.section().is_none()
    }
}
