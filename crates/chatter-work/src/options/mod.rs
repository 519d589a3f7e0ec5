//! What can be asked, each read from text in one place.

mod assignment;
mod axes;
mod count;
mod counts;
mod decimal;
mod event;
mod orbit;
mod quantity;
mod section;
mod share;
mod sweep;

pub use assignment::Assignment;
pub use axes::AxesOption;
pub use count::{Count, Precision, ThreadCount, WholeNumber};
pub use counts::{Counts, Periods};
pub use decimal::Decimal;
pub use event::StopOption;
pub use orbit::{AtOption, ObserveOption, ShearOption, StartOption};
pub use quantity::{Quantity, Window};
pub use section::SectionOption;
pub use share::ShareOption;
pub use sweep::{SpanOption, SweepOption};
