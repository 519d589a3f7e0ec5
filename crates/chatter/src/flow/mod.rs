//! The hybrid flow: flight, impact, chatter, sticking, release.
//!
//! ```text
//! model -> System      modes, each a Program (field, guards, impact tapes) compiled when it is first met
//!          touch       all contacts at one state: rates, couplings, directions, for impacts of several at one instant
//!          variation   derivatives as further states of the same system: columns, saltation at impacts
//!       -> Trajectory  the mode machine: one state, its mode, what happened (Occurrence); impacts, rest, corners, roots
//!            step      expand, locate the first guard, move, collide: branch-free, any number type
//!              flight  what ordinary steps in free flight change beside the state, for one trajectory or lanes of many
//!              resolve the rare cases a step cannot certify, settled with full root isolation
//!            sections  where one is crossed, by the side of it that the trajectory comes from
//!            chatter   the end of an infinite impact sequence, extrapolated
//!       -> fleet       steps of many trajectories in lanes
//! leg      one mode by itself, past whatever would end it, for periodic orbits
//! ```

mod chatter;
mod error;
mod fleet;
pub(crate) mod leg;
mod modes;
mod occurrence;
mod reset;
mod sections;
mod step;
mod system;
mod touch;
mod touching;
mod trajectory;
mod variation;

pub(crate) use chatter::border_value::{fixed_point, multiplier};
pub use error::FlowError;
pub use fleet::{Next, run_fleet};
pub(crate) use modes::closed::Grip;
pub use modes::closed::{Closed, Held};
pub use modes::guard::GuardKind;
pub(crate) use modes::limits::Corner;
pub use occurrence::{EventKind, Occurrence, Place};
pub use step::Workspace;
pub use step::dense::Dense;
pub use system::{Settings, System, SystemError};
pub use trajectory::Trajectory;
pub(crate) use trajectory::{NoDerivative, SAME_DERIVATIVE, SAME_RATE, UNFELT, orders};
pub use variation::Column;
pub(crate) use variation::{
    Direction, FORGOTTEN, columns, impacts_may_forget, may_forget, with_identity,
};
