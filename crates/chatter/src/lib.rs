//! Analysis of mechanical systems with impacts.
//!
//! Each module may use those above it in this list, never those below:
//! `numerics`, `expressions`, `model`, `flow`, `analysis`.

pub mod analysis;
pub mod expressions;
pub mod flow;
pub mod model;
pub mod numerics;
