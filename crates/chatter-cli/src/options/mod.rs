//! Options that several commands have in common, each read in one place.

mod count;
mod counts;
mod decimal;
mod event;
mod files;
mod model;
mod orbit;
mod quantity;
mod section;
mod sweep;

pub use count::{Count, Precision, ThreadCount};
pub use counts::{Counts, Periods};
pub use decimal::Decimal;
pub use event::StopOption;
pub use files::{FigureFile, TableFile};
pub use model::{Assignment, Initial, Loaded, ModelOptions, neighbour};
pub use orbit::{AtOption, ObserveOption, ShearOption, StartOption};
pub use quantity::{Quantity, Window};
pub use section::SectionOption;
pub use sweep::{SpanOption, SweepOption};
