//! The paper, computed again: Dankowicz & Fotsch 2017, its numbers, figures, and its theory against simulation.

mod cascade;
mod numbers;
mod restitution;
mod theory;
mod valve;
mod work;

pub use cascade::{fig2, fig3, fig4};
pub use numbers::{account as numbers_account, report as numbers_report};
pub use restitution::report as restitution_report;
pub use theory::report as theory_report;
pub use valve::{Valve, fig5, fig6};
pub use work::{Advance, Work};

use crate::failure::Failure;
use crate::terminal;
use chatter::analysis::diagram::{Ending, Row, Spec, Standing, Sweep, Threads, run};
use chatter::analysis::map::Map;
use chatter_figures::Figure;
use chatter_figures::reports::{Block, Picture};
use core::ops::ControlFlow;

/// A figure with its number in the paper, or none.
pub struct Plate {
    /// Name of its files.
    pub name: &'static str,
    /// What it is called in the report.
    pub label: &'static str,
    /// What it shows and how it was made, with markup.
    pub caption: String,
    /// The figure.
    pub figure: Figure,
}

impl Plate {
    /// For the report.
    pub fn picture(&self) -> Picture {
        Picture::new(self.label, &self.caption, self.figure.clone())
    }
}

/// What is computed together: what it adds to the report, and the figure among it.
pub struct Part {
    /// For the report.
    pub blocks: Vec<Block>,
    /// The figure, which gets files of its own too.
    pub plate: Plate,
}

impl From<Plate> for Part {
    fn from(plate: Plate) -> Self {
        Self {
            blocks: vec![plate.picture().into()],
            plate,
        }
    }
}

/// Width of a figure, in millimetres.
pub const WIDTH: f64 = 178.0;

/// Rows of a diagram in their order. `advance` hears what part of it has been done since it last heard; Ctrl-C ends the
/// program.
pub fn sweep(map: &dyn Map, spec: &Spec, advance: &Advance) -> Result<(Sweep, Vec<Row>), Failure> {
    let sweep = Sweep::new(map, spec).map_err(Failure::input)?;
    let mut rows = Vec::new();
    let row_share = 1.0 / sweep.rows() as f64;
    let ending = run(
        map,
        &sweep,
        &Standing::default(),
        &Threads::available(),
        terminal::interrupt_flag(),
        &mut |row| {
            rows.push(row);
            advance(row_share);
            ControlFlow::Continue(())
        },
    );
    if ending == Ending::Stopped {
        return Err(Failure::Interrupted);
    }
    rows.sort_unstable_by_key(|row| row.row);
    Ok((sweep, rows))
}
