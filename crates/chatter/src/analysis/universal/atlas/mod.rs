//! The atlas beyond fixed points: periodic orbits, cascades, chaos and basins of z -> Upsilon(K z + mu).
//!
//! Everything is in the coordinate x = K z + mu, in which the map reads x -> F(x) = K Upsilon(x) + mu.
//!
//! ```text
//! enclosure    where F takes an interval, and between which bounds its slope is: tight, since laps are concave
//! recurrence   all mu at which a given point is periodic, by bisection with these enclosures
//! orbit        an orbit with its first and second derivatives: what Newton's method needs
//! follow       a family of periodic orbits through its stable part
//! periodic     windows of period 2 and higher: fold or doubling, superstable point, period doubling, graze
//! cascade      period doublings on a lap to their accumulation
//! chaos        for which n and K there is chaos, and where
//! basin        what is attracted by a window's orbit
//! ```

mod basin;
mod cascade;
mod chaos;
mod enclosure;
mod follow;
mod orbit;
mod periodic;
mod recurrence;
#[cfg(test)]
mod tests;

pub use basin::Basin;
pub use cascade::Cascade;
pub use chaos::{Chaos, Regime};
pub use periodic::{Edge, EdgeKind, PeriodicAtlas, PeriodicWindow};
