//! What a model is written in: files and tables of points, read into a draft of named texts, which builders write, too.

pub(super) mod curve_table;
pub(super) mod data_file;
pub(super) mod draft;
pub(super) mod file;
mod syntax;
pub(super) mod table;
pub(super) mod tabulated;
