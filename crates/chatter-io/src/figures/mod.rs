//! Figures: panels of curves, points, densities and maps as plain values, drawn as one scene and written as SVG, PDF
//! and PNG.

mod axis;
mod color;
mod density;
mod draw;
mod error;
mod figure;
mod fonts;
pub(crate) mod html;
mod label;
mod layer;
mod layout;
mod legend;
mod map;
mod panel;
mod pdf;
mod png;
mod raster;
mod scene;
mod simplify;
mod svg;
mod text;
mod ticks;

pub use axis::{Axis, Direction, Range, Scale};
pub use color::{Color, Colormap, PALETTE};
pub use density::{Compression, Density, Normalisation};
pub use error::{AxisSide, FigureError};
pub use figure::{Figure, Letters, Sharing};
pub use label::{LabelError, variable};
pub use layer::{Anchor, Dash, Layer, Line, Marker, Markers, Note, Orientation, Rule, Spans};
pub use legend::Legend;
pub use map::{Category, CategoryMap, HeatMap};
pub use panel::Panel;
pub use png::Resolution;
pub use scene::{Glyph, GlyphRun, Image, Path, Primitive, Rect, Scene, Segment, Stroke, Turn};
