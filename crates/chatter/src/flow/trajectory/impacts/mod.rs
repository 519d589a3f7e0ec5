//! Impacts of a trajectory: the sequence that one belongs to, several at one instant, and those that are none.

mod burst;
mod cascade;
pub(super) mod collisions;
mod contacts;
mod friction;
mod grazing;
mod known_gap;
pub(super) mod orders;
mod sequence;
pub(super) mod stall;
pub(super) mod tops;
