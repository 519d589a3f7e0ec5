//! Where contact ends, h = v = a = 0 and j > 0: at a parameter value, over the parameter, and up to turns of the forcing.

mod all;
pub(in crate::analysis::border) mod branches;
pub(in crate::analysis::border) mod equations;
pub(in crate::analysis::border) mod forcing;
mod orbits;

pub use equations::ReleasePoint;
pub use forcing::Turn;
