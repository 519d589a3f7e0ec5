//! Expression graphs, their parser, derivatives and tapes.

mod derivative;
mod eval;
mod graph;
mod number;
mod simplify;
mod substitute;

pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use number::Number;
