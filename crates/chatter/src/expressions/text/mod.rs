//! Expressions as text: how they are read, what is wrong with them, and how they are told.

mod call;
pub(super) mod display;
pub(super) mod formula;
mod fraction;
pub(super) mod lexer;
mod number_text;
pub(super) mod parse_error;
pub(super) mod parser;
pub(super) mod suggest;
pub(super) mod tex_name;
