//! The universal map: an orbit diagram of it, and how it is told as a JSON document, as a table, as a picture.

pub mod atlas;
pub mod branches;
mod cobweb;
mod document;
mod figure;
mod found;
mod job;
mod orbits;
pub mod picture;
mod request;
mod sheet;
pub mod table;
mod windows;

pub use cobweb::Cobweb;
pub use document::document;
pub use figure::figure;
pub use found::Atlas;
pub use job::UniversalJob;
pub use orbits::compute;
pub use request::{Request, refused};
pub use sheet::{Cell, Sheet};
pub use windows::{Window, window_sheet};

use crate::numbers::Digits;
use chatter::analysis::diagram::{Row, Sweep};
use chatter::analysis::universal::{Evaluation, PeriodicWindow, Scaling, Universal};
use chatter::numerics::{DoubleDouble, Real};

/// What was found.
pub struct Findings<'a, R> {
    /// The universal function.
    pub universal: &'a Universal<R>,
    /// The slope K of the map.
    pub slope: R,
    /// Upsilon where it was asked for.
    pub values: Option<Vec<(R, Evaluation<R>)>>,
    /// The windows asked for, to more digits than any output.
    pub windows: Option<Vec<Window<DoubleDouble>>>,
    /// What the windows tend to.
    pub scaling: Option<Scaling<DoubleDouble>>,
    /// Windows of periodic orbits.
    pub periodic: Vec<PeriodicWindow<DoubleDouble>>,
    /// What else of the atlas was asked for.
    pub sheets: Vec<Sheet>,
    /// Intervals of mu that may hold windows of periodic orbits and were given up.
    pub undecided: usize,
    /// The orbit diagram, without its samples.
    pub diagram: Option<(&'a Sweep, &'a [Row])>,
    /// A cobweb.
    pub cobweb: Option<Cobweb>,
    /// How many digits the user wants.
    pub digits: Digits,
}

impl<R: Real> Findings<'_, R> {
    /// Upsilon where it was asked for, as a sheet.
    pub fn value_sheet(&self) -> Option<Sheet> {
        let number = |value: R| Cell::Number(Some(value.to_double_double()));
        let row = |&(x, at): &(R, Evaluation<R>)| {
            let lap = at.lap.to_f64();
            vec![
                number(x),
                number(at.value),
                number(at.derivative),
                match lap.is_finite() {
                    true => Cell::Whole(lap as i64),
                    // Upsilon is zero for x <= 0, where the impacts never end.
                    false => Cell::Rough(Some(lap)),
                },
                number(at.u1),
            ]
        };
        Some(Sheet {
            name: "values",
            title: "values",
            columns: vec!["x", "upsilon", "derivative", "n", "u1"],
            rows: self.values.as_ref()?.iter().map(row).collect(),
        })
    }
}
