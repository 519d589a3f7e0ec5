//! What the one-dimensional map says about the system, beside the system itself.

pub(super) mod located;
pub(super) mod map;
pub(super) mod simulated;
pub(super) mod windows;
