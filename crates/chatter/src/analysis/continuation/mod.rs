//! Solution curves of systems with one equation less than unknowns.
//!
//! ```text
//! Problem      unknowns, free parameters last; residual and Jacobian, or why there is none here (Left)
//! newton       the one corrector: the problem bordered by linear conditions
//! Curve        stations along a curve by pseudo-arclength, each corrected to rounding
//! locate       where a function of the stations vanishes between two of them
//! differenced  derivatives of a function by differences along the solutions
//! Held         a problem with one more condition and one more free parameter: curves in two parameters are curves again
//! meeting      where two curves meet
//! coincidence  where two functions vanish at once and the equations are singular
//! ```

mod coincidence;
mod curve;
mod differences;
mod held;
mod locate;
mod map_orbit;
mod meeting;
mod newton;
mod problem;

#[cfg(test)]
mod tests;

pub use coincidence::{Coincidence, Coincident, coincidence, coincidence_along};
pub use curve::{Curve, Settings, Station, StepError, tangent};
pub use differences::differenced;
pub use held::{Held, Singular};
pub use locate::locate;
pub use map_orbit::{ImageWithSlopes, MapOrbit, MapWithSlopes};
pub use meeting::{meeting, other_direction};
pub use newton::{Condition, Corrected, NewtonError, approach, newton};
pub use problem::{Left, Linearised, Problem, Wrap};
