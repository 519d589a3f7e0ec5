//! What a diagram is going to take, said before it has taken it.

use super::job::Ready;
use crate::simulation::limiting;
use chatter::analysis::simulate::FastestRate;

/// Steps that are many: some ten seconds.
const MANY_STEPS: f64 = 1e8;

/// A step of the series is so many reciprocals of the fastest rate long, about.
const REACH: f64 = 10.0;

/// What there is to say of a stiff model. Each return is taken for as long as the slowest rate is.
pub fn stiffness(ready: &Ready) -> Option<String> {
    let fastest = FastestRate::at_start(&ready.model).filter(FastestRate::is_stiff)?;
    let spec = ready.sweep.spec();
    let returns = (spec.transient as f64 + spec.keep as f64) * spec.every as f64;
    let steps = ready.sweep.rows() as f64 * returns * fastest.rate / fastest.slowest / REACH;
    (steps > MANY_STEPS).then(|| {
        format!(
            "{}: the diagram takes some {steps:.0e} of them; Ctrl-C ends it and keeps what is done",
            limiting(&ready.model, &fastest)
        )
    })
}
