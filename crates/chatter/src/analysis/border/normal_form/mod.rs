//! The one-dimensional map around a border orbit: its exact coefficients, and the paper's.

pub(in crate::analysis::border) mod exact;
pub(in crate::analysis::border) mod leading_order;
mod section;

pub use exact::{Exact, Memory};
pub use leading_order::{LeadingOrder, ReleaseSection, leading_order_at};
pub use section::section_states;
