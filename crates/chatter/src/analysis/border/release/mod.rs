//! Where contact ends, h = v = a = 0 and j > 0: at a parameter value, and up to turns of the forcing.

pub(super) mod equations;
pub(super) mod forcing;
