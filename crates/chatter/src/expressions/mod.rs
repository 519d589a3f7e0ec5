//! Expression graphs, their parser, derivatives and tapes.

mod graph;
mod number;
mod simplify;

pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use number::Number;
