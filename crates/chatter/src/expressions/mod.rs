//! Expression graphs, their parser, derivatives and tapes.

mod call;
mod condition;
mod corners;
mod curve;
mod derivative;
mod display;
mod domain;
mod eval;
mod formula;
mod fraction;
mod graph;
mod lexer;
mod lowering;
mod machine;
mod number;
mod number_text;
mod operand;
mod parse_error;
mod parser;
mod piecewise;
mod product;
mod series;
mod singularity;
mod substitute;
mod suggest;
mod sum;
mod tape;
mod tex_name;
mod weighted;

pub use corners::{Corners, LOOKUP_SLOTS, LookedUpIn, Lookup, Side, Sides, Smooth, Surfaces};
pub use curve::{
    Axis, CURVE_KINDS, Curve, CurveError, CurveKind, MOST_KNOTS, OUTSIDES, Outside, Piece,
};
pub use display::Names;
pub use domain::Folding;
pub use formula::Formula;
pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use lexer::is_name;
pub use machine::Backend;
pub use number::Number;
pub use parse_error::{ParseError, ParseErrorKind};
pub use parser::{DEEPEST_NESTING, LONGEST_TEXT, names};
pub use piecewise::{Condition, CurveId, Edge};
pub(crate) use series::ORDER_CLASSES;
pub use series::{Expansion, MAX_ORDER};
pub(crate) use singularity::Negligible;
pub use singularity::Singularity;
pub use suggest::{is_reserved, nearest};
pub use tape::{Operand, Tape};
pub use tex_name::tex_name;

#[cfg(test)]
mod tests;
