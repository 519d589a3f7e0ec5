//! From one sequence of events to the next: whether it still holds, and how it goes on where it does not.

mod beside_rest;
pub(super) mod coincidence;
pub(super) mod corner;
mod cut_short;
pub(super) mod events;
pub(super) mod graze;
pub(super) mod holds;
pub(super) mod opening;
mod released;
mod root;
mod strike;
pub(super) mod together;
pub(super) mod touch;
pub(super) mod turn;
