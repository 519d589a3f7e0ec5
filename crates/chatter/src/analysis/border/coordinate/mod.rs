//! The exact coordinate X of what follows release: impacts, their limits, and the root X(p) = 0.

pub(super) mod limits;
pub(super) mod local;
pub(super) mod root;
pub(super) mod sequence;
