//! Impacting systems: states, parameters, contacts, sections, and the files that hold them.
//!
//! A [`Model`] is equations and nothing else. [`Mechanics`] derives from them what an impacting system needs: rate,
//! acceleration, jerk, the impact map and the sticking field.

mod dependency;
mod identically_zero;
mod mechanics;
#[expect(
    clippy::module_inception,
    reason = "the floor is named after what it holds"
)]
mod model;

pub use mechanics::{ContactMechanics, Mechanics, MechanicsError, Sticking};
pub use model::{Contact, Definition, Direction, Label, Model, Parameter, Section, State};
