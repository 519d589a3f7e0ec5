//! Reports: text, tables and figures in one self-contained page.
//!
//! A [`Report`] is written as one HTML file that needs nothing else: no scripts, no fonts or pictures from elsewhere, so
//! it can be mailed, archived and printed. Text has the markup of figure labels: mathematics between dollar signs.

mod html;
mod report;
mod report_error;

pub use report::{Align, Block, Column, Grid, Picture, Report};
pub use report_error::{ReportError, ReportPart};
