//! Options that several commands have in common, each read in one place.

mod count;
mod event;
mod files;
mod model;
mod orbit;
mod quantity;
mod sweep;

pub use count::{Count, Precision};
pub use event::StopOption;
pub use files::{FigureFile, TableFile};
pub use model::{Assignment, Initial, Loaded, ModelOptions};
pub use orbit::{AtOption, ObserveOption, ShearOption, StartOption};
pub use quantity::{Quantity, Window};
pub use sweep::{SpanOption, SweepOption};
