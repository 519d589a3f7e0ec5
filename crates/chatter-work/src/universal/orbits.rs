//! The orbit diagram of the universal map.

use crate::diagram::{Store, check_size};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{self, Row, Standing, Sweep, Threads};
use chatter::analysis::map::Map;
use core::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// The rows of the diagram without their samples, and on the disk of `folder` with them.
///
/// # Errors
/// There are too many, or they cannot be kept.
pub fn compute(
    map: &dyn Map,
    sweep: &Sweep,
    folder: &Path,
    observer: &dyn Observer,
) -> Result<(Vec<Row>, Store), Refusal> {
    check_size(sweep, true)?;
    let mut store = Store::scratch(folder, sweep)?;
    let mut rows = Vec::new();
    let mut broken = None;
    let spec = sweep.spec();
    let iterates = spec.transient.saturating_add(spec.keep) as f64;
    let began = Instant::now();
    let (standing, threads) = (Standing::default(), Threads::available());
    let stop = observer.stop();
    diagram::run(map, sweep, &standing, &threads, stop, &mut |mut row| {
        if let Err(error) = store.append(&row) {
            broken = Some(Refusal::Output(error.to_string()));
            return ControlFlow::Break(());
        }
        row.samples = Vec::new();
        rows.push(row);
        let done = rows.len() as f64;
        observer.progress(done / sweep.rows() as f64, &|| {
            let rate = done * iterates / began.elapsed().as_secs_f64();
            format!("{done} of {} orbits, {rate:.2e} iterates/s", sweep.rows())
        });
        ControlFlow::Continue(())
    });
    if let Some(refusal) = broken {
        return Err(refusal);
    }
    rows.sort_unstable_by_key(|row| row.row);
    Ok((rows, store))
}
