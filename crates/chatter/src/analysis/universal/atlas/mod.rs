//! The atlas beyond fixed points: periodic orbits, cascades, chaos and basins of z -> Upsilon(K z + mu).
//!
//! Everything is in the coordinate x = K z + mu, in which the map reads x -> F(x) = K Upsilon(x) + mu.
//!
//! ```text
//! enclosure    where F takes an interval, and between which bounds its slope is: tight, since laps are concave
//! recurrence   all mu at which a given point is periodic, by bisection with these enclosures
//! orbit        an orbit, and mu at which a point is periodic
//! cycle        periodic orbits as a problem of continuation
//! follow       a family of periodic orbits through its stable part
//! window       windows of periodic orbits, as values: fold or doubling, superstable point, period doubling, graze
//! periodic     all windows of given laps and periods
//! search       where orbits are looked for, and all mu at which a point is periodic
//! superstable  windows that have a superstable orbit
//! collision    windows that begin where a point leaves a lap's end, and grazes
//! cascade      period doublings on a lap to their accumulation
//! chaos        for which n and K there is chaos, and where
//! basin        what is attracted by a window's orbit
//! ```

mod basin;
mod cascade;
mod chaos;
mod collision;
mod cycle;
mod enclosure;
mod follow;
mod orbit;
mod periodic;
mod recurrence;
mod search;
mod superstable;
#[cfg(test)]
mod tests;
mod window;

pub use basin::Basin;
pub use cascade::Cascade;
pub use chaos::{Chaos, Regime};
pub use window::{Edge, EdgeKind, PeriodicAtlas, PeriodicWindow};
