//! What can happen to a trajectory.

use crate::expressions::Side;
use crate::numerics::Real;
use core::fmt;
use serde::{Deserialize, Serialize};

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
        /// Whether it was without rebound, so that the contact is closed from here on.
        closes: bool,
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
    /// A contact is closed from here on, as an impact without rebound told before it, there or at a neighbour.
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
    /// An impact of one contact after which it is open, by the rates before and after.
    pub(crate) const fn ordinary_impact(
        (contact, (rate_before, rate_after)): (usize, (R, R)),
    ) -> Self
    where
        R: Copy,
    {
        Self::Impact {
            contact,
            rate_before,
            rate_after,
            closes: false,
        }
    }

    /// What kind of event it is; none where it tells of nothing that the equations made happen: the horizon, and the capture
    /// that an impact has told of.
    pub const fn kind(&self) -> Option<EventKind> {
        Some(match self {
            Self::Impact { .. } => EventKind::Impact,
            Self::Graze { .. } => EventKind::Graze,
            Self::Accumulation { .. } => EventKind::Accumulation,
            Self::Cascade { .. } => EventKind::Cascade,
            Self::Ambiguity { .. } => EventKind::Ambiguity,
            Self::Release { .. } => EventKind::Release,
            Self::Switch { .. } => EventKind::Switch,
            Self::Slide { .. } => EventKind::Slide,
            Self::Leave { .. } => EventKind::Leave,
            Self::Stick { .. } => EventKind::Stick,
            Self::Slip { .. } => EventKind::Slip,
            Self::Reset { .. } => EventKind::Reset,
            Self::Section { .. } => EventKind::Section,
            Self::Capture { .. } | Self::Horizon => return None,
        })
    }

    /// What of the model it happens at; none for the horizon.
    pub const fn place(&self) -> Option<Place> {
        Some(match *self {
            Self::Impact { contact, .. }
            | Self::Graze { contact, .. }
            | Self::Accumulation { contact, .. }
            | Self::Cascade { contact, .. }
            | Self::Ambiguity { contact, .. }
            | Self::Capture { contact }
            | Self::Release { contact }
            | Self::Stick { contact }
            | Self::Slip { contact, .. } => Place::Contact(contact),
            Self::Switch { surface, .. }
            | Self::Slide { surface }
            | Self::Leave { surface, .. } => Place::Surface(surface),
            Self::Reset { section } | Self::Section { section } => Place::Section(section),
            Self::Horizon => return None,
        })
    }

    /// Of a corner: the side that the trajectory is on now.
    pub const fn side(&self) -> Option<Side> {
        match *self {
            Self::Switch { side, .. } | Self::Leave { side, .. } | Self::Slip { side, .. } => {
                Some(side)
            }
            _ => None,
        }
    }
}

impl<R: Real> Occurrence<R> {
    /// With numbers rounded to doubles.
    pub fn to_f64(&self) -> Occurrence<f64> {
        match *self {
            Self::Impact {
                contact,
                rate_before,
                rate_after,
                closes,
            } => Occurrence::Impact {
                contact,
                rate_before: rate_before.to_f64(),
                rate_after: rate_after.to_f64(),
                closes,
            },
            Self::Graze { contact, rate } => Occurrence::Graze {
                contact,
                rate: rate.to_f64(),
            },
            Self::Accumulation {
                contact,
                impacts,
                error,
            } => Occurrence::Accumulation {
                contact,
                impacts,
                error,
            },
            Self::Cascade {
                contact,
                impacts,
                error,
            } => Occurrence::Cascade {
                contact,
                impacts,
                error,
            },
            Self::Ambiguity { contact, other } => Occurrence::Ambiguity { contact, other },
            Self::Capture { contact } => Occurrence::Capture { contact },
            Self::Release { contact } => Occurrence::Release { contact },
            Self::Switch { surface, side } => Occurrence::Switch { surface, side },
            Self::Slide { surface } => Occurrence::Slide { surface },
            Self::Leave { surface, side } => Occurrence::Leave { surface, side },
            Self::Stick { contact } => Occurrence::Stick { contact },
            Self::Slip { contact, side } => Occurrence::Slip { contact, side },
            Self::Reset { section } => Occurrence::Reset { section },
            Self::Section { section } => Occurrence::Section { section },
            Self::Horizon => Occurrence::Horizon,
        }
    }
}

/// What of a model something happens at, by its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A contact.
    Contact(usize),
    /// A surface where the equations change their form.
    Surface(usize),
    /// A section, or the surface of an event.
    Section(usize),
}

impl Place {
    /// The index among those of its sort.
    pub const fn index(self) -> usize {
        match self {
            Self::Contact(index) | Self::Surface(index) | Self::Section(index) => index,
        }
    }
}

/// A kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A collision.
    Impact,
    /// The end of a complete chatter sequence.
    Accumulation,
    /// The end of a contact phase.
    Release,
    /// A touch without impact.
    Graze,
    /// A section was crossed.
    Section,
    /// Collisions of several contacts at one instant without a last one.
    Cascade,
    /// Impacts of several contacts at one instant whose order matters.
    Ambiguity,
    /// A surface was crossed where the field changes its form.
    Switch,
    /// A surface is slid along from here on.
    Slide,
    /// Sliding along a surface ended.
    Leave,
    /// Friction holds a contact.
    Stick,
    /// A contact that stuck begins to slide.
    Slip,
    /// An event changed the state.
    Reset,
}

impl EventKind {
    /// All kinds.
    pub const ALL: [Self; 13] = [
        Self::Impact,
        Self::Accumulation,
        Self::Release,
        Self::Graze,
        Self::Section,
        Self::Cascade,
        Self::Ambiguity,
        Self::Switch,
        Self::Slide,
        Self::Leave,
        Self::Stick,
        Self::Slip,
        Self::Reset,
    ];

    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Impact => "impact",
            Self::Accumulation => "accumulation",
            Self::Release => "release",
            Self::Graze => "graze",
            Self::Section => "section",
            Self::Cascade => "cascade",
            Self::Ambiguity => "ambiguity",
            Self::Switch => "switch",
            Self::Slide => "slide",
            Self::Leave => "leave",
            Self::Stick => "stick",
            Self::Slip => "slip",
            Self::Reset => "reset",
        }
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}
