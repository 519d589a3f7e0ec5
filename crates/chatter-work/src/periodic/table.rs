//! Branches as a table: a row for each orbit, and a row for each special point.

use super::Subject;
use crate::diagram::table::json;
use crate::refusal::Refusal;
use chatter::analysis::periodic::{Branch, Point, Special};
use chatter_files::tables::{Dataset, Table};
use std::path::{Path, PathBuf};

/// Complete chatter has infinitely many impacts.
const INFINITE: i64 = -1;

/// Names of the texts that hold the model's file and the parameters that were set into it.
pub(super) const MODEL: &str = "model";
pub(super) const SET: &str = "model_set";

/// Writes the table, with the model and what was set into it, but for the parameters that have columns.
///
/// # Errors
/// The file cannot be written.
pub fn write(
    subject: &Subject,
    set: &[(String, String)],
    branches: &[Branch],
    path: &Path,
) -> Result<Vec<PathBuf>, Refusal> {
    let points: Vec<(i64, &Point)> = (branches.iter().enumerate())
        .flat_map(|(index, branch)| branch.points.iter().map(move |point| (index as i64, point)))
        .collect();
    let specials: Vec<_> = (branches.iter().enumerate())
        .flat_map(|(index, branch)| {
            branch
                .special
                .iter()
                .map(move |special| (index as i64, special))
        })
        .collect();
    let special_points: Vec<(i64, &Point)> = (specials.iter())
        .map(|(index, special)| (*index, &special.point))
        .collect();
    // All columns of an NPZ file are in one place.
    let together = path.extension().is_some_and(|extension| extension == "npz");
    let prefix = if together { "special_" } else { "" };
    let kinds: Vec<&str> = specials
        .iter()
        .map(|(_, special)| special.kind.name())
        .collect();
    let function = |special: &Special| {
        let index = special.monitor?;
        subject.monitors.get(index).map(String::as_str)
    };
    let functions: Vec<&str> = (specials.iter())
        .map(|(_, special)| function(special).unwrap_or_default())
        .collect();
    let special = columns(subject, Table::new("special"), prefix, &special_points)
        .column(format!("{prefix}kind"), kinds)
        .column(format!("{prefix}monitor"), functions)
        .column(
            format!("{prefix}value_error"),
            specials.iter().map(|(_, s)| s.error).collect::<Vec<f64>>(),
        );
    let columns_of = subject.names();
    let kept = set
        .iter()
        .filter(|(name, _)| !columns_of.contains(&name.as_str()));
    let kept: Vec<&(String, String)> = kept.collect();
    Dataset::new()
        .table(columns(subject, Table::new("points"), "", &points))
        .table(special)
        .text(MODEL, subject.text)
        .text(SET, &json(&kept)?)
        .write(path)
        .map_err(Refusal::from)
}

fn columns(subject: &Subject, table: Table, prefix: &str, points: &[(i64, &Point)]) -> Table {
    let numbers = |value: &dyn Fn(&Point) -> f64| -> Vec<f64> {
        points.iter().map(|(_, point)| value(point)).collect()
    };
    let whether = |value: fn(&Point) -> bool| -> Vec<i64> {
        let told = points.iter().map(|(_, point)| i64::from(value(point)));
        told.collect()
    };
    let name = |name: &str| format!("{prefix}{name}");
    let branch: Vec<i64> = points.iter().map(|(index, _)| *index).collect();
    let mut table = table.column(name("branch"), branch);
    for (place, parameter) in subject.names().into_iter().enumerate() {
        table = table.column(name(parameter), numbers(&|point| point.parameters[place]));
    }
    table = table
        .column(name("period"), numbers(&|point| point.period))
        .column(
            name("impacts"),
            (points.iter())
                .map(|(_, point)| point.impacts.map_or(INFINITE, |count| count as i64))
                .collect::<Vec<i64>>(),
        )
        .column(name("stable"), whether(Point::is_stable))
        .column(name("neutral"), whether(Point::is_neutral));
    for (index, state) in subject.model.states.iter().enumerate() {
        table = table.column(name(&state.name), numbers(&|point| point.state[index]));
    }
    for (index, text) in subject.watched() {
        table = table.column(name(text), numbers(&|point| point.monitors[index]));
    }
    let most = points
        .iter()
        .map(|(_, point)| point.multipliers.len())
        .max()
        .unwrap_or(0);
    for k in 0..most {
        let part = |point: &Point, imaginary: bool| {
            point
                .multipliers
                .get(k)
                .map_or(f64::NAN, |m| if imaginary { m.im } else { m.re })
        };
        table = table
            .column(
                name(&format!("multiplier{}_re", k + 1)),
                numbers(&|point| part(point, false)),
            )
            .column(
                name(&format!("multiplier{}_im", k + 1)),
                numbers(&|point| part(point, true)),
            );
    }
    table.column(name("error"), numbers(&|point| point.correction))
}
