//! Which contacts are closed in a mode, and what else holds a state.

use serde::{Deserialize, Serialize};

/// A set of contacts in persistent contact, one bit each.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
pub struct Closed(pub u128);

impl Closed {
    /// No contact is closed: free flight.
    pub const NONE: Self = Self(0);

    /// Whether this contact is closed.
    pub fn contains(self, contact: usize) -> bool {
        self.0 >> contact & 1 == 1
    }

    /// The set with one more contact.
    #[must_use]
    pub fn with(self, contact: usize) -> Self {
        Self(self.0 | 1 << contact)
    }

    /// The set with one contact less.
    #[must_use]
    pub fn without(self, contact: usize) -> Self {
        Self(self.0 & !(1 << contact))
    }

    /// Contacts of the set, ascending.
    pub fn contacts(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let first = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            rest &= rest - 1;
            Some(first)
        })
    }
}

/// The closed contacts of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub(crate) struct Grip {
    /// All of them.
    pub closed: Closed,
    /// Those whose gaps stay zero as long as those of the others do: no force is asked of them, as of the third leg of a beam.
    pub idle: Closed,
}

impl Grip {
    /// No contact is closed.
    pub const NONE: Self = Self {
        closed: Closed::NONE,
        idle: Closed::NONE,
    };

    /// Whether a closed contact carries nothing.
    pub fn has_idle(self) -> bool {
        self.idle != Closed::NONE
    }

    /// The same, all idle.
    pub fn without_forces(self) -> Self {
        Self {
            idle: self.closed,
            ..self
        }
    }

    /// Contacts whose forces hold all.
    pub fn carrying(self) -> Closed {
        Closed(self.closed.0 & !self.idle.0)
    }
}

/// What holds a state beside the forces of closed contacts.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Held {
    /// Surfaces that are slid along, ascending.
    pub surfaces: Vec<usize>,
    /// Closed contacts whose friction sticks, by their surfaces.
    pub contacts: Vec<usize>,
}
