//! Sections: on which side of each a trajectory is, and where it crosses one.

pub(super) mod crossing;
pub(super) mod sides;
