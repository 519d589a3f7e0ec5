//! The universal map of chatter near a border orbit: Upsilon, z -> Upsilon(K z + mu) and its cascade.
//!
//! Source: Dankowicz & Fotsch 2017, section 2, with the equations as corrected in MATH.md 2, 3 and 7.
//!
//! Upsilon depends on the restitution alone. [`Universal`] prepares it once; then a value costs one look-up of the lap
//! and one short polynomial, without iteration, on one number or on several [`Lanes`](crate::numerics::Lanes) at once.

mod argument;
mod atlas;
mod chatter_map;
mod chebyshev;
mod constants;
mod doubling;
mod error;
mod evaluate;
mod lap;
mod map;
#[cfg(test)]
mod reference;
mod scales;
mod scaling;
mod sequence;
#[cfg(test)]
mod tests;
mod windows;

pub use argument::Argument;
pub use atlas::{Basin, Cascade, Chaos, Edge, EdgeKind, PeriodicAtlas, PeriodicWindow, Regime};
pub use chatter_map::{ChatterMap, GRAZE};
pub use constants::Constants;
pub use error::UniversalError;
pub use evaluate::{Evaluation, Universal};
pub use map::UniversalMap;
pub use scaling::Scaling;
pub use windows::{Located, Window};
