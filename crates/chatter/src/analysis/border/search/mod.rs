//! Where the verdict over a parameter changes, and which of these places are borders.

pub(super) mod borders;
pub(super) mod branches;
pub(super) mod breaks;
pub(super) mod closing_in;
pub(super) mod sample;
