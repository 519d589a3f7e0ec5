//! Options that several commands have in common, each read in one place.

mod count;
mod event;
mod files;
mod model;
mod quantity;

pub use count::{Count, Precision};
pub use event::StopOption;
pub use files::{FigureFile, TableFile};
pub use model::{Initial, Loaded, ModelOptions};
pub use quantity::{Quantity, Window};
