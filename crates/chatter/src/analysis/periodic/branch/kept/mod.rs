//! How far one side of a branch has come, as it is kept for another walk to go on from.
//!
//! ```text
//! record   what came about since the record before, and all that a walk knows between two of its steps
//! ledger   reads and writes the records of a side
//! ```

mod ledger;
mod record;

pub use record::Record;

pub(in crate::analysis::periodic) use ledger::{Kept, Ledger};
pub(in crate::analysis::periodic) use record::{Along, Of, Stand, Standing, Then, Walked, damaged};
