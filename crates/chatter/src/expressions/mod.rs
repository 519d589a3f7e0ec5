//! Expression graphs, their parser, derivatives and tapes.

mod derivative;
mod eval;
mod graph;
mod lexer;
mod number;
mod series;
mod tape;
mod parse_error;
mod parser;
mod simplify;
mod substitute;
mod suggest;

pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use lexer::is_name;
pub use number::Number;
pub use series::{Expansion, MAX_ORDER};
pub use tape::{Operand, Tape};
pub use parse_error::{ParseError, ParseErrorKind};
pub use parser::{DEEPEST_NESTING, LONGEST_TEXT, names};
pub use suggest::{is_reserved, nearest};

#[cfg(test)]
mod tests;
