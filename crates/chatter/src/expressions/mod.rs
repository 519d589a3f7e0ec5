//! Expression graphs, their parser, derivatives and tapes.

mod derivative;
mod eval;
mod graph;
mod number;
mod series;
mod simplify;
mod substitute;
mod tape;

pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use number::Number;
pub use series::{Expansion, MAX_ORDER};
pub use tape::{Operand, Tape};
