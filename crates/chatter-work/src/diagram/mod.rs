//! Orbit diagrams as files: what is wanted, the journal that holds what is there already, tables, pictures.

mod columns;
pub mod document;
mod expectation;
mod hysteresis;
pub mod job;
mod order;
pub mod picture;
mod produce;
mod shards;
mod source;
mod store;
mod stored;
pub mod table;
pub mod tally;
mod watched;

pub use crate::journals::{journal_of, shard_journal};
pub use columns::{Columns, columns};
pub use hysteresis::{Hysteresis, hysteresis};
pub use job::{Header, Job, Order, Ready};
pub use order::Request;
pub use picture::{Shear, Show, View, Zoom};
pub use produce::{
    Beginning, Produced, Take, Work, Written, produce, produce_in_memory, produce_rows, rows_of,
};
pub use shards::{merge, small_share};
pub use source::{Class, InMemory, Rows, Source};
pub use store::{Begun, Found, Store, check_size};
pub use stored::{Stored, Subject};
