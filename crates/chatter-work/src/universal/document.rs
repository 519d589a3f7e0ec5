//! The universal map as one JSON document.

use super::atlas::limits;
use super::{Findings, window_sheet};
use crate::json::{Json, Object};
use chatter::analysis::diagram::{Row, Sweep};
use chatter::numerics::Real;

/// The whole document.
pub fn document<R: Real>(findings: &Findings<R>) -> Object {
    let digits = findings.digits;
    let constants = findings.universal.constants();
    let (begin, end) = findings.universal.window();
    let mut object = Object::new(digits)
        .number("restitution", constants.restitution)
        .number("chatter_fixed_point", constants.chatter_fixed_point)
        .number("lambda", constants.lambda)
        .number("eta", constants.eta)
        .number("exponent", constants.exponent)
        .number("lap_end", end)
        .number("lap_begin", begin);
    if let Some(values) = findings.value_sheet() {
        object = object.with(values.name, values.json(digits));
    }
    if findings.windows.is_some() || findings.diagram.is_some() {
        object = object.number("slope", findings.slope);
    }
    if let Some(windows) = &findings.windows {
        object = object.with("windows", window_sheet(windows).json(digits));
    }
    if let Some(scaling) = &findings.scaling {
        let start = Object::new(digits);
        let limits = limits(scaling)
            .iter()
            .fold(start, |limits, &(name, value, _)| {
                limits.number(name, value)
            });
        object = object.with("scaling", limits);
    }
    for sheet in &findings.sheets {
        object = object.with(sheet.name, sheet.json(digits));
    }
    if findings.sheets.iter().any(|sheet| sheet.name == "periodic") {
        object = object.with("undecided", findings.undecided as i64);
    }
    if let Some((sweep, rows)) = &findings.diagram {
        let columns = rows.iter().map(|row| column(findings, sweep, row).into());
        object = object.with("columns", columns.collect::<Vec<Json>>());
    }
    object.with("version", env!("CARGO_PKG_VERSION"))
}

fn column<R: Real>(findings: &Findings<R>, sweep: &Sweep, row: &Row) -> Object {
    let parameter = sweep.spec().sweeps[0].name();
    let value = sweep.values(row.row)[0];
    Object::new(findings.digits)
        .with(&parameter, value)
        .with("outcome", row.outcome.name())
        .with("period", row.period as i64)
        .with("exponent", row.exponent)
}
