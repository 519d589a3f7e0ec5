//! Options that several commands have in common: what can be asked anywhere, and what only a command line asks.

mod files;
mod model;
mod periodic;

pub use chatter_work::options::*;
pub use chatter_work::source::Loaded;
pub use files::{FigureFile, TableFile};
pub use model::{Initial, ModelOptions};
pub use periodic::{PeriodBegins, PeriodicOptions};
