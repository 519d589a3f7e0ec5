//! What `chatter universal --out` writes.

use super::{Findings, UniversalJob, window_sheet};
use crate::diagram::{Store, table as orbit_table};
use crate::named::Named;
use crate::refusal::Refusal;
use chatter::numerics::Real;
use chatter_files::tables::Dataset;
use std::path::{Path, PathBuf};

/// Writes what `--out` holds: the last thing asked for.
pub fn write<R: Real>(
    findings: &Findings<R>,
    diagram: Option<(&UniversalJob, &mut Store)>,
    path: &Path,
) -> Result<Vec<PathBuf>, Refusal> {
    let Some((job, store)) = diagram else {
        let data = dataset(findings, path)?;
        return data
            .write(path)
            .map_err(|error| Refusal::Output(error.to_string()));
    };
    let parameters = Named::new(
        ["restitution", "slope", "mu"],
        [job.restitution, job.slope, job.mu],
    );
    let texts = [
        (orbit_table::SPECIFICATION, orbit_table::json(job)?),
        (orbit_table::MODEL, "z -> Upsilon(K z + mu)".to_owned()),
        (orbit_table::PARAMETERS, orbit_table::json(&parameters)?),
        (orbit_table::VERSION, job.version.clone()),
    ];
    orbit_table::write(store, &texts, path)
}

/// What else `--out` may hold: with windows all of the atlas.
fn dataset<R: Real>(findings: &Findings<R>, path: &Path) -> Result<Dataset, Refusal> {
    let data = Dataset::new();
    if let Some(windows) = &findings.windows {
        // All columns of an NPZ file are in one place.
        let together =
            !findings.sheets.is_empty() && path.extension().is_some_and(|ext| ext == "npz");
        let prefix = |name: &str| {
            if together {
                format!("{name}_")
            } else {
                String::new()
            }
        };
        let start = data.table(window_sheet(windows).table(&prefix("windows")));
        let sheets = findings.sheets.iter();
        return Ok(sheets.fold(start, |data, sheet| {
            data.table(sheet.table(&prefix(sheet.name)))
        }));
    }
    if let Some(values) = findings.value_sheet() {
        return Ok(data.table(values.table("")));
    }
    let cobweb = findings.cobweb.as_ref().ok_or_else(|| {
        Refusal::input("--out has nothing to write")
            .help("ask for --at, --windows, --sweep or --cobweb")
    })?;
    Ok(cobweb.dataset())
}
