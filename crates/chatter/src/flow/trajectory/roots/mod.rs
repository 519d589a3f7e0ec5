//! Where roots and powers in the field begin: there motion has no derivatives, and yet goes on in one way.

pub(super) mod flat_root;
mod off_root;
