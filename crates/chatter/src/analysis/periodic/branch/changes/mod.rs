//! From one sequence of events to the next: whether it still holds, and how it goes on where it does not.

pub(super) mod coincidence;
pub(super) mod corner;
mod cut_short;
pub(super) mod events;
pub(super) mod graze;
pub(super) mod holds;
mod rests;
mod root;
mod strike;
pub(super) mod together;
pub(super) mod touch;
pub(super) mod turn;
