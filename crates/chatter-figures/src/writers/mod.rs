//! Scenes as files.

pub(crate) mod pdf;
pub(crate) mod png;
mod raster;
pub(crate) mod svg;
