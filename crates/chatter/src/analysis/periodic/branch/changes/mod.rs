//! From one sequence of events to the next: whether it still holds, and how it goes on where it does not.

mod across;
pub(super) mod coincidence;
pub(super) mod corner;
mod cut_short;
pub(super) mod events;
pub(super) mod graze;
pub(super) mod holds;
mod led_onto;
mod moment;
mod rests;
mod root;
mod strike;
pub(super) mod together;
pub(super) mod touch;
pub(super) mod turn;
