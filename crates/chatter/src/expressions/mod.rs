//! Expression graphs, their parser, derivatives and tapes.

mod corners;
mod curve;
mod graph;
mod lowering;
mod machine;
mod series;
mod singularity;
mod source;
mod tape;
mod text;

pub use corners::{
    Asked, Corners, LOOKUP_SLOTS, LookedUpIn, Lookup, Side, Sides, Smooth, Surfaces,
};
pub use curve::{
    Axis, CURVE_KINDS, Curve, CurveError, CurveKind, MOST_KNOTS, OUTSIDES, Outside, Piece,
};
pub(crate) use graph::disc::Disc;
pub use graph::domain::Folding;
pub use graph::number::Number;
pub use graph::piecewise::{Condition, CurveId, Edge};
pub use graph::{Expr, Function, Graph, Node, Symbol};
pub use machine::Backend;
pub(crate) use series::ORDER_CLASSES;
pub use series::{Expansion, MAX_ORDER};
pub(crate) use singularity::Negligible;
pub use singularity::Singularity;
pub use source::NoSource;
pub use tape::{Operand, Tape};
pub use text::display::Names;
pub use text::formula::Formula;
pub use text::lexer::is_name;
pub use text::parse_error::{ParseError, ParseErrorKind};
pub use text::parser::{DEEPEST_NESTING, LONGEST_TEXT, names};
pub use text::suggest::{is_reserved, nearest};
pub use text::tex_name::tex_name;

#[cfg(test)]
mod tests;
