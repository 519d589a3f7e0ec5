//! The hybrid flow: flight, impact, chatter, sticking, release.
//!
//! ```text
//! model -> System      a Program (field, guards, impact tapes) for each set of closed contacts that is met
//!          touch       all contacts at one state: rates, couplings, directions, for impacts of several at one instant
//!          variation derivatives as further states of the same system: columns, saltation at impacts
//!       -> Trajectory  the mode machine: one state, its mode, what happened (Occurrence)
//!            flight    what ordinary steps in free flight change beside the state, for one trajectory or lanes of many
//!            step      expand, locate the first guard, move, collide: branch-free, any number type
//!            resolve   the rare cases a step cannot certify, settled with full root isolation
//!            crossing  where a section is crossed, by the side of it that the trajectory comes from (sides)
//!            chatter   the end of an infinite impact sequence, extrapolated
//! ```

pub(crate) mod border_value;
mod certificates;
mod chatter;
mod crossing;
mod dense;
mod error;
mod fleet;
mod flight;
mod guard;
pub(crate) mod leg;
mod limits;
mod looked_up;
mod modes;
mod occurrence;
mod program;
mod reset;
mod resolve;
mod sides;
mod source;
mod step;
mod system;
mod touch;
mod touching;
mod trajectory;
mod variation;

pub use dense::Dense;
pub use error::FlowError;
pub use fleet::{Next, run_fleet};
pub use guard::GuardKind;
pub(crate) use limits::Corner;
pub use occurrence::{EventKind, Occurrence, Place};
pub(crate) use program::Grip;
pub use program::{Closed, Held};
pub use step::Workspace;
pub use system::{Settings, System, SystemError};
pub use trajectory::Trajectory;
pub(crate) use trajectory::{NoDerivative, SAME_DERIVATIVE, SAME_RATE, UNFELT, orders};
pub use variation::Column;
pub(crate) use variation::{
    Direction, FORGOTTEN, columns, impacts_may_forget, may_forget, with_identity,
};
