//! What can happen to a trajectory.

use crate::expressions::Side;

/// One event, told after the trajectory has moved to it. Contacts and sections are indices into the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Occurrence<R> {
    /// A collision: the state is now the one after it.
    Impact {
        /// Where.
        contact: usize,
        /// Gap rate before, negative.
        rate_before: R,
        /// Gap rate after.
        rate_after: R,
    },
    /// A contact is touched with no rate that could be told from zero: nothing changes.
    Graze {
        /// Where.
        contact: usize,
        /// Gap rate there.
        rate: R,
    },
    /// An infinite sequence of impacts came to its end: the contact is closed from here on.
    Accumulation {
        /// Where.
        contact: usize,
        /// How many impacts of the sequence were integrated one by one.
        impacts: u64,
        /// Estimated local error of its time: of the completion, and of rounding (or the tolerance) in the impacts before it, but
        /// not of the state that the sequence began from.
        error: f64,
    },
    /// Binary collisions at one instant that have no last one, as of plastic bodies between others, converged: their limit
    /// is taken.
    Cascade {
        /// The contact of the latest of them.
        contact: usize,
        /// How many were carried out one by one.
        impacts: u64,
        /// Estimated error of the rates, in units of the greatest of them before the first collision.
        error: f64,
    },
    /// Two contacts close at one instant, and what follows depends on which of them collides first: the equations do not
    /// say it. The contact that closes fastest goes first.
    Ambiguity {
        /// The contact that collides first.
        contact: usize,
        /// The contact that could as well.
        other: usize,
    },
    /// An impact without rebound: the contact is closed from here on.
    Capture {
        /// Where.
        contact: usize,
    },
    /// The contact force vanished and the contact opens.
    Release {
        /// Where.
        contact: usize,
    },
    /// A surface was crossed: the field is now that of this side.
    Switch {
        /// Which.
        surface: usize,
        /// The side that the trajectory is on now.
        side: Side,
    },
    /// A surface is slid along from here on, held by the fields on both sides.
    Slide {
        /// Which.
        surface: usize,
    },
    /// Sliding along a surface ended.
    Leave {
        /// Which.
        surface: usize,
        /// The side that the trajectory is on now.
        side: Side,
    },
    /// Friction holds a closed contact.
    Stick {
        /// Which.
        contact: usize,
    },
    /// A contact that stuck begins to slide.
    Slip {
        /// Which.
        contact: usize,
        /// Above where it slides forwards.
        side: Side,
    },
    /// An event changed the state.
    Reset {
        /// The section that is its surface.
        section: usize,
    },
    /// A section was crossed in its direction: the sign of its function has changed. At the instant of another event that it
    /// cannot be told apart from it comes after that; the state then lies on the section only if nothing made its function
    /// jump.
    Section {
        /// Which.
        section: usize,
    },
    /// The time asked for was reached.
    Horizon,
}

impl<R> Occurrence<R> {
    /// Of a corner, or an event: where, and the side that the trajectory is on now.
    pub fn corner(&self) -> Option<(usize, Option<Side>)> {
        match *self {
            Self::Switch { surface, side } | Self::Leave { surface, side } => {
                Some((surface, Some(side)))
            }
            Self::Slide { surface } => Some((surface, None)),
            Self::Slip { contact, side } => Some((contact, Some(side))),
            Self::Stick { contact } => Some((contact, None)),
            Self::Reset { section } => Some((section, None)),
            _ => None,
        }
    }
}
