//! Where a branch is over: back where it began, at a chatter border, at an equilibrium, or with a period or a state that grows without bound.

pub(super) mod accumulation;
pub(super) mod border;
pub(super) mod equilibrium;
mod family;
mod forced_rest;
pub(super) mod growth;
pub(super) mod hopf;
pub(super) mod returns;
pub(super) mod saddle;
pub(super) mod shrunk;
pub(super) mod unbounded;
