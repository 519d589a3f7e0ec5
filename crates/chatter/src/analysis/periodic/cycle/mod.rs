//! An orbit as it is read off the motion, nearly closed: its instants, the return at which it closes, and its legs.

pub(in crate::analysis::periodic) mod corners;
mod events;
pub mod itinerary;
pub(super) mod joint;
mod left;
pub mod reread;
pub mod rotate;
pub mod settle;
pub mod trace;
