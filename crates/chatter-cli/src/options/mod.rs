//! Options that several commands have in common, each read in one place.

mod event;
mod files;
mod model;
mod quantity;

pub use event::StopOption;
pub use files::{FigureFile, TableFile};
pub use model::{Initial, Loaded, ModelOptions};
pub use quantity::Quantity;
