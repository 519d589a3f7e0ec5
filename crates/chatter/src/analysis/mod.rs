//! Questions asked of a system: each a pure function from a specification that can be stored to a typed result.

pub mod border;
pub mod border_search;
pub mod continuation;
pub mod diagram;
pub mod exponents;
pub mod map;
pub mod periodic;
pub mod return_map;
pub mod simulate;
pub mod universal;
