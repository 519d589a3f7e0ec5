//! Contacts of a trajectory at rest: which of them stay closed, what opens them, and what keeps the state on them.

mod contact;
mod first;
mod projection;
mod redundant;
pub(super) mod undecided;
