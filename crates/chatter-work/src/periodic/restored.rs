//! Special points from a table that was written before.

use crate::refusal::Refusal;
use chatter::analysis::periodic::{Known, SpecialKind};
use chatter::model::Model;
use chatter_files::Format;
use chatter_files::tables::NpzReader;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A special point, and the values of the parameters that were free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restored {
    /// The point.
    pub known: Known,
    /// The function that vanishes there, of a point where one of the user's does.
    pub function: Option<String>,
    /// Name and value of each parameter that the table has.
    pub parameters: Vec<(String, f64)>,
}

/// Which special points of a table are meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Chosen {
    /// The one with this number, from 1.
    Number(usize),
    /// All of a kind.
    All(SpecialKind),
}

/// Reads special points of a table in NPZ.
///
/// # Errors
/// There is no such file, or no such point in it, or it is of another model.
pub fn restore(model: &Model, path: &Path, chosen: &Chosen) -> Result<Vec<Restored>, Refusal> {
    let file = NpzReader::open(path).map_err(Refusal::input)?;
    let kinds = file.texts("special_kind").map_err(|_| {
        Refusal::input(format!("`{}` holds no special points", path.display()))
            .help("write them with `chatter continue … --out FILE.npz`")
    })?;
    let places: Vec<usize> = match chosen {
        Chosen::Number(index) => (0..kinds.len())
            .filter(|place| place + 1 == *index)
            .collect(),
        Chosen::All(kind) => (0..kinds.len())
            .filter(|&place| kinds[place] == kind.name())
            .collect(),
    };
    if places.is_empty() {
        let path = path.display();
        return Err(Refusal::input(match chosen {
            Chosen::Number(index) => format!(
                "`{path}` has special points 1 to {}, and no {index}",
                kinds.len()
            ),
            Chosen::All(kind) => format!(
                "none of the {} special points in `{path}` is of the kind {}",
                kinds.len(),
                kind.name()
            ),
        }));
    }
    (places.into_iter())
        .map(|place| one(model, (&file, path), (place, &kinds[place])))
        .collect()
}

/// The special point in a row of a table.
fn one(
    model: &Model,
    (file, path): (&NpzReader, &Path),
    (place, kind): (usize, &str),
) -> Result<Restored, Refusal> {
    let number = |name: &str| -> Result<f64, Refusal> {
        let values = file.floats(name).map_err(Refusal::input)?;
        values.get(place).copied().ok_or_else(|| {
            Refusal::input(format!(
                "`{}` is damaged: `{name}` is too short",
                path.display()
            ))
        })
    };
    let kind = SpecialKind::named(kind).ok_or_else(|| {
        Refusal::input(format!(
            "`{}` has a point of unknown kind `{kind}`",
            path.display()
        ))
    })?;
    let states: Result<Vec<f64>, Refusal> = (model.states.iter())
        .map(|state| number(&format!("special_{}", state.name)))
        .collect();
    let mut parameters = Vec::new();
    for parameter in &model.parameters {
        let name = format!("special_{}", parameter.name);
        if file.contains(&name) {
            parameters.push((parameter.name.clone(), number(&name)?));
        }
    }
    let function = match kind {
        SpecialKind::Monitor => {
            let all = file.texts("special_monitor").map_err(Refusal::input)?;
            all.into_iter().nth(place)
        }
        _ => None,
    };
    Ok(Restored {
        function,
        known: Known {
            kind,
            monitor: None,
            state: states?,
            period: number("special_period")?,
        },
        parameters,
    })
}

/// Whether a table of branches stands there.
///
/// # Errors
/// Something else does.
pub fn holds_branches(path: &Path) -> Result<bool, Refusal> {
    let foreign = || Refusal::input(format!("`{}` is no table of branches", path.display()));
    match Format::of_table(path) {
        // The tables have names of their own, made from this one.
        Ok(Format::Csv) => {
            let points = path.with_extension("points.csv");
            match std::fs::read_to_string(points) {
                Ok(text) if text.starts_with("branch,") => Ok(true),
                Ok(_) => Err(foreign()),
                Err(_) => Ok(false),
            }
        }
        _ if !path.exists() => Ok(false),
        Ok(Format::Npz) => {
            let file = NpzReader::open(path).map_err(Refusal::input)?;
            let whole = file.contains("special_kind") && file.contains("stable");
            whole.then_some(true).ok_or_else(foreign)
        }
        _ => Err(foreign()),
    }
}
