//! Expression graphs, their parser, derivatives and tapes.

mod derivative;
mod display;
mod eval;
mod graph;
mod lexer;
mod number;
mod number_text;
mod parse_error;
mod parser;
mod series;
mod simplify;
mod substitute;
mod suggest;
mod tape;
mod tex_name;

pub use display::Names;
pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use lexer::is_name;
pub use number::Number;
pub use parse_error::{ParseError, ParseErrorKind};
pub use parser::{DEEPEST_NESTING, LONGEST_TEXT, names};
pub use series::{Expansion, MAX_ORDER};
pub use suggest::{is_reserved, nearest};
pub use tape::{Operand, Tape};
pub use tex_name::tex_name;

#[cfg(test)]
mod tests;
