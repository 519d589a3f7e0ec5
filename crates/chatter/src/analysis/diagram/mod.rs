//! Orbit diagrams: what the orbits of a map settle to, for many parameter values.
//!
//! ```text
//! Spec            which parameters are swept, what is kept of each orbit, where orbits start
//!   Sweep         rows and pieces: a piece is a run of rows that have to be computed one after the other
//!   run           workers of an Executor take pieces; each follows hundreds of orbits at once
//!     Column      one orbit: transient, samples
//!     exponent    what a displacement grows by beside the samples, by the map's tangent map
//!     classify    what it has settled to, if it has; aperiodic: chaotic, quasi-periodic, or neither
//!   Row           the result for one orbit, which says itself where it belongs
//!   Attractors    which rows settled to the same orbit
//! ```
//!
//! Rows come in any order; each is the same to the bit whatever the number of threads, the width of the lanes or the
//! company in which it was computed. So a diagram can be broken off and resumed, and its pieces can be computed anywhere.

mod attractors;
mod column;
mod error;
mod run;
mod spec;
mod sweep;

#[cfg(test)]
mod tests;

pub use attractors::{Attractors, Collector};
pub use error::DiagramError;
pub use run::executor::{Executor, Threads};
pub use run::row::{Outcome, Row, RowError, Started};
pub use run::share::Share;
pub use run::standing::Standing;
pub use run::{Ending, run, run_share};
pub use spec::observable::Observable;
pub(crate) use spec::random::Generator;
pub use spec::range::{Range, Spacing, Swept, initial_name};
pub use spec::{Bounds, Exponent, Observed, Record, Spec, Start};
pub use sweep::Sweep;

use super::map::Map;
use core::ops::ControlFlow;
use core::sync::atomic::AtomicBool;

/// Computes a whole diagram into memory: its rows in order.
///
/// # Errors
/// The specification is wrong by itself or does not fit the map.
pub fn diagram(
    map: &dyn Map,
    spec: &Spec,
    executor: &dyn Executor,
) -> Result<Vec<Row>, DiagramError> {
    let sweep = Sweep::new(map, spec)?;
    let mut rows = Vec::new();
    let stop = AtomicBool::new(false);
    run(
        map,
        &sweep,
        &Standing::default(),
        executor,
        &stop,
        &mut |row| {
            rows.push(row);
            ControlFlow::Continue(())
        },
    );
    rows.sort_unstable_by_key(|row| row.row);
    Ok(rows)
}
