//! The one-dimensional map around a border orbit: its exact coefficients, and the paper's.

pub(super) mod exact;
pub(super) mod leading_order;
pub(super) mod section;
