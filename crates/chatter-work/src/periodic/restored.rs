//! Special points from a table that was written before.

use super::same_model::difference;
use super::table::{MODEL, SET};
use crate::data_files::DataFiles;
use crate::options::Assignment;
use crate::refusal::Refusal;
use crate::source::{Source, set_parameters};
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

/// What the points of a table are to be of.
pub struct Asked<'a> {
    /// The model, with nothing set into it.
    pub model: &'a Model,
    /// The files that its tables stand in.
    pub data_files: &'a DataFiles,
    /// What is to be set into it: name and expression.
    pub set: Vec<(String, String)>,
}

impl Asked<'_> {
    /// The model of a table, if it is this one.
    fn model_of(&self, (file, path): (&NpzReader, &Path)) -> Result<Model, Refusal> {
        let path = path.display();
        let other = |how: String| Refusal::input(format!("`{path}` is of another model{how}"));
        let text = file.text(MODEL).map_err(Refusal::input)?;
        let there = Source::kept(&path.to_string(), &text, self.data_files.clone()).load();
        let there = there.map_err(|_| other(String::new()))?.model;
        match difference(&there, self.model) {
            Some(how) => Err(other(format!(": {how}"))),
            None => Ok(there),
        }
    }

    /// Takes over what was set into the model of a table, but for parameters that were free there: its points are no orbits at other
    /// values. Refuses what is set to others.
    fn takes_over(
        &mut self,
        (file, path): (&NpzReader, &Path),
        mut there: Model,
        point: &Restored,
    ) -> Result<(), Refusal> {
        let path = path.display();
        // Tables of others have no such text.
        let set_there: Vec<(String, String)> = match file.contains(SET) {
            true => {
                let text = file.text(SET).map_err(Refusal::input)?;
                serde_json::from_str(&text).map_err(|_| {
                    Refusal::input(format!("`{path}` is damaged: `{SET}` is no list"))
                })?
            }
            false => Vec::new(),
        };
        let was_free = |name: &String| point.parameters.iter().any(|(free, _)| free == name);
        for (name, text) in &set_there {
            if !was_free(name) && !self.set.iter().any(|(known, _)| known == name) {
                self.set.push((name.clone(), text.clone()));
            }
        }
        let mut here = self.model.clone();
        for (model, set) in [(&mut there, &set_there), (&mut here, &self.set)] {
            let set: Vec<Assignment> = (set.iter())
                .map(|(name, text)| Assignment::new(name, text))
                .collect();
            set_parameters(model, &set)?;
            for (name, value) in &point.parameters {
                let set = model.set_parameter(name, &format!("{value:?}"));
                set.map_err(Refusal::input)?;
            }
        }
        let values = [&there, &here].map(|model| model.parameter_values::<f64>(&[]));
        for (place, parameter) in there.parameters.iter().enumerate() {
            let name = &parameter.name;
            let own = here.parameter_index(name).map(|index| values[1][index]);
            let (was, Some(is)) = (values[0][place], own) else {
                continue;
            };
            if was != is {
                let message =
                    format!("the points in `{path}` are at {name} = {was}, and not at {is}");
                return Err(Refusal::input(message).help(format!("--set {name}={was}")));
            }
        }
        Ok(())
    }
}

/// Reads special points of a table in NPZ, and takes over what was set where it was written.
///
/// # Errors
/// There is no such file, or no such point in it, or it is of another model, or at other parameters.
pub fn restore(
    asked: &mut Asked<'_>,
    path: &Path,
    chosen: &Chosen,
) -> Result<Vec<Restored>, Refusal> {
    let model = asked.model;
    let file = NpzReader::open(path).map_err(Refusal::input)?;
    let kinds = file.texts("special_kind").map_err(|_| {
        Refusal::input(format!("`{}` holds no special points", path.display()))
            .help("write them with `chatter continue … --out FILE.npz`")
    })?;
    let there = asked.model_of((&file, path))?;
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
    let points: Result<Vec<Restored>, Refusal> = (places.into_iter())
        .map(|place| one(model, (&file, path), (place, &kinds[place])))
        .collect();
    let points = points?;
    if let Some(first) = points.first() {
        asked.takes_over((&file, path), there, first)?;
    }
    Ok(points)
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
