//! Orbit diagrams as files: what is wanted, the journal that holds what is there already, tables, pictures.

pub mod account;
pub mod document;
pub mod job;
pub mod picture;
mod source;
mod store;
mod stored;
pub mod table;
pub mod tally;

pub use job::{Job, Order};
pub use picture::{Shear, Show, View, Zoom};
pub use source::{Class, InMemory, Source};
pub use store::{Begun, Found, Store, check_size, journal_of};
pub use stored::{Stored, Subject};
