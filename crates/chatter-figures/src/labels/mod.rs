//! Labels: what is written in a figure, its mathematics, and the glyphs that it is set in.

pub(crate) mod fonts;
pub(crate) mod html;
pub(crate) mod label;
pub(crate) mod text;
