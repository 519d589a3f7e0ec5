//! Tables, figures and reports as plain values, and their writers. Knows nothing of analyses.
//!
//! # Tables
//!
//! A [`tables::Dataset`] holds tables of named columns and text about them, and is written as CSV or NPZ, whichever the
//! extension says. [`tables::NpzWriter`] writes arrays of any length in flat memory, [`tables::NpzReader`] reads them.
//!
//! ```
//! use chatter_io::tables::{Dataset, NpzReader, Table};
//! # let folder = std::env::temp_dir().join(format!("chatter-io-doc-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//!
//! let data = Dataset::new()
//!     .table(
//!         Table::new("columns")
//!             .column("q", vec![0.0203, 0.0204])
//!             .column("period", vec![1i64, 2])
//!             .column("outcome", vec!["periodic", "periodic"]),
//!     )
//!     .table(Table::new("samples").column("y2", vec![0.1, 0.2, 0.3]))
//!     .text("model", "title = \"Pressure relief valve\"");
//! data.write(folder.join("fig5.npz"))?;
//!
//! let file = NpzReader::open(folder.join("fig5.npz"))?;
//! assert_eq!(file.floats("y2")?, [0.1, 0.2, 0.3]);
//! assert_eq!(file.text("model")?, "title = \"Pressure relief valve\"");
//! # std::fs::remove_dir_all(folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Figures
//!
//! A [`figures::Figure`] is a grid of [`figures::Panel`]s, each two axes and layers: curves, markers, densities of
//! millions of points, bands, reference lines, notes, maps over two parameters. It is 86 mm wide unless told otherwise.
//! Ranges, ticks, margins and the place of the legend follow from the data. Labels know a subset of TeX's mathematics.
//! One scene of drawing primitives feeds the writers of SVG, PDF and PNG; equal figures give equal bytes.
//!
//! ```
//! use chatter_io::figures::{Axis, Density, Figure, Line, Panel, Rule, Sharing, Spans};
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
//! # Ok::<(), chatter_io::figures::FigureError>(())
//! ```
//!
//! # Reports
//!
//! A [`reports::Report`] gathers text, tables and figures in one HTML file that refers to nothing outside itself.
//!
//! # Files
//!
//! A long computation keeps its results in a [`journal`], which survives being killed.
//!
//! Every other file is written beside its place under a temporary name and then renamed ([`atomic_file`]): it appears whole or
//! not at all. Errors ([`Error`]) name the path and the reason.

pub mod atomic_file;
mod crc32;
mod error;
pub mod figures;
mod format;
pub mod journal;
pub mod record_log;
pub mod reports;
pub mod tables;

#[cfg(test)]
mod scratch;

pub use error::{Error, FileAction, FileError};
pub use format::{Content, Format, FormatError};
