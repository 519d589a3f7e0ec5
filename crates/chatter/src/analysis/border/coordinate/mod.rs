//! The exact coordinate X of what follows release: impacts, their limits, and the root X(p) = 0.

pub(in crate::analysis::border) mod limits;
pub(in crate::analysis::border) mod local;
pub(in crate::analysis::border) mod root;
pub(in crate::analysis::border) mod sequence;

pub use limits::Extrapolation;
pub use local::LocalCoordinate;
pub use sequence::Verdict;
