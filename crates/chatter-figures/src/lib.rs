//! Figures and reports as plain values, and their writers. Knows nothing of analyses.
//!
//! # Figures
//!
//! A [`Figure`] is a grid of [`Panel`]s, each two axes and layers: curves, markers, densities of
//! millions of points, bands, reference lines, maps over two parameters. It is 86 mm wide unless told otherwise.
//! Ranges, ticks, margins and the place of the legend follow from the data. Labels know a subset of TeX's mathematics.
//! One scene of drawing primitives feeds the writers of SVG, PDF and PNG; equal figures give equal bytes.
//!
//! ```
//! use chatter_figures::{Axis, Density, Figure, Line, Panel, Rule, Sharing, Spans};
//!
//! let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
//! let x: Vec<f64> = t.iter().map(|t| (2.0 - t % 4.0).abs()).collect();
//! let history = Figure::new()
//!     .sharing(Sharing::Horizontal)
//!     .panel(
//!         Panel::new(Axis::new("$t$").tight(), Axis::new("$y_1$").unit("mm"))
//!             .with(Spans::new(vec![(3.9, 4.1)]).label("contact"))
//!             .with(Line::new(t.clone(), x.clone()).label("displacement")),
//!     )
//!     .panel(Panel::new(Axis::new("$t$").tight(), Axis::new("$\\dot{y}_1$")).with(Rule::horizontal(0.0)))
//!     .caption("How it was made");
//! assert!(history.svg()?.ends_with("</svg>\n"));
//!
//! // An orbit diagram: points are counted as they come, and memory does not grow with them.
//! let mut density = Density::new((3.5, 4.0), (0.0, 1.0));
//! for k in 0..500 {
//!     let r = 3.5 + 0.001 * f64::from(k);
//!     let mut z = 0.5;
//!     for _ in 0..200 {
//!         z = r * z * (1.0 - z);
//!         density.add(r, z);
//!     }
//! }
//! let diagram = Figure::from(Panel::new(Axis::new("$\\mu$").tight(), Axis::new("$z$").tight()).with(density));
//! assert!(diagram.pdf()?.starts_with(b"%PDF"));
//! # Ok::<(), chatter_figures::FigureError>(())
//! ```
//!
//! # Reports
//!
//! A [`reports::Report`] gathers text, tables and figures in one HTML file that refers to nothing outside itself.

mod axis;
mod color;
mod density;
mod error;
mod figure;
mod figure_error;
mod labels;
mod layer;
mod legend;
mod map;
mod page;
mod panel;
pub mod reports;
mod scene;
mod ticks;
mod writers;

pub use axis::{Axis, Direction, Range, Scale};
pub use color::{Color, Colormap, PALETTE};
pub use density::{Density, Grain, Normalisation};
pub use error::Error;
pub use figure::{Figure, Letters, Sharing};
pub use figure_error::{AxisSide, FigureError};
pub use labels::label::{LabelError, check as check_label, variable};
pub use layer::{Dash, Layer, Line, Marker, Markers, Orientation, Rule, Spans};
pub use legend::Legend;
pub use map::{Category, CategoryMap, HeatMap};
pub use panel::Panel;
pub use scene::{Glyph, GlyphRun, Image, Path, Primitive, Rect, Scene, Segment, Stroke, Turn};
pub use ticks::Numbers;
pub use writers::png::Resolution;
