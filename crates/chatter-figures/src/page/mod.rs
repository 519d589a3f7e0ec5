//! A figure on its page: where everything is, and the primitives that are drawn there.

pub(crate) mod draw;
pub(crate) mod layout;
mod simplify;
