//! Where a model comes from: a file with its tables beside it, a text, or the models that are shipped.

use crate::data_files::{DataFiles, beside, kept, text_of};
use crate::options::Assignment;
use crate::refusal::Refusal;
use crate::shipped;
use chatter::expressions::nearest;
use chatter::model::{Model, ModelError};
use chatter_figures::check_label;
use std::path::{Path, PathBuf};

/// The text of a model, not read yet.
#[derive(Clone, Debug)]
pub struct Source {
    /// What it is called in messages.
    pub name: String,
    /// The text.
    pub text: String,
    tables: Tables,
}

/// Where the tables of a model stand that are in files.
#[derive(Clone, Debug)]
enum Tables {
    /// Nowhere: it came from no file.
    Nowhere,
    /// Beside this file.
    Beside(PathBuf),
    /// They were read before.
    Kept(DataFiles),
}

/// A model and the file it came from.
pub struct Loaded {
    /// The model.
    pub model: Model,
    /// The text of its file.
    pub text: String,
    /// The files that its tables stand in.
    pub data_files: DataFiles,
}

impl Source {
    /// What a user means by this: a file, else a shipped model.
    ///
    /// # Errors
    /// There is neither, or the file cannot be read.
    pub fn named(given: &str) -> Result<Self, Refusal> {
        if !Path::new(given).exists()
            && let Some(shipped) = shipped::find(given)
        {
            return Ok(Self::text(given, shipped.text));
        }
        Self::file(given)
    }

    /// A shipped model.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn shipped(name: &str) -> Result<Self, Refusal> {
        match shipped::find(name) {
            Some(shipped) => Ok(Self::text(name, shipped.text)),
            None => Err(
                Refusal::input(format!("there is no shipped model called `{name}`"))
                    .did_you_mean(shipped::suggest(name)),
            ),
        }
    }

    /// A text that stands in no file.
    pub fn text(name: &str, text: &str) -> Self {
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
            tables: Tables::Nowhere,
        }
    }

    /// A text that came from a file, with the texts of the files beside it.
    pub fn kept(name: &str, text: &str, data_files: DataFiles) -> Self {
        Self {
            tables: Tables::Kept(data_files),
            ..Self::text(name, text)
        }
    }

    /// A file.
    ///
    /// # Errors
    /// It is not there, or is no text.
    pub fn file(given: &str) -> Result<Self, Refusal> {
        let path = Path::new(given);
        if path.is_dir() {
            return Err(Refusal::input(format!(
                "`{given}` is a folder, not a model file"
            )));
        }
        match std::fs::read(path) {
            Ok(bytes) => match text_of(bytes) {
                Ok(text) => Ok(Self {
                    name: given.to_owned(),
                    text,
                    tables: Tables::Beside(path.to_path_buf()),
                }),
                Err(line) => Err(Refusal::input(format!(
                    "`{given}` is no text: line {line} is not UTF-8"
                ))),
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                Err(not_found(given, path))
            }
            Err(error) => Err(Refusal::input(format!("cannot read `{given}`: {error}"))),
        }
    }

    /// Reads the model, and the files that its tables stand in.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn load(self) -> Result<Loaded, Refusal> {
        let path = match self.tables {
            Tables::Kept(data_files) => {
                let mut load = kept(&data_files);
                let model = Model::from_toml_with(&self.text, &self.name, &mut load)?;
                drop(load);
                check_labels(&model, &self.name)?;
                return Ok(Loaded {
                    model,
                    text: self.text,
                    data_files,
                });
            }
            Tables::Beside(path) => Some(path),
            Tables::Nowhere => None,
        };
        let mut data_files = DataFiles::new();
        let mut load = beside(path.as_deref(), &mut data_files);
        let model = Model::from_toml_with(&self.text, &self.name, &mut load)?;
        drop(load);
        check_labels(&model, &self.name)?;
        Ok(Loaded {
            model,
            text: self.text,
            data_files,
        })
    }
}

/// Refuses labels that no picture can show: found when one is drawn, they would cost what was computed for it.
fn check_labels(model: &Model, source: &str) -> Result<(), Refusal> {
    let states = (model.states.iter()).map(|state| (&state.name, &state.label));
    let parameters = (model.parameters.iter()).map(|one| (&one.name, &one.label));
    for (name, label) in states.chain(parameters) {
        let texts = label.iter().flat_map(|label| [&label.text, &label.unit]);
        for text in texts.flatten() {
            check_label(text).map_err(|error| {
                Refusal::input(format!("[labels] of {source}: `{name}` has a {error}"))
            })?;
        }
    }
    Ok(())
}

/// Sets parameters.
///
/// # Errors
/// A name is none of a parameter, or an expression is wrong or has no value.
pub fn set_parameters(model: &mut Model, set: &[Assignment]) -> Result<(), Refusal> {
    once_each("--set", set)?;
    for Assignment { name, text } in set {
        if model.parameter_index(name).is_none() && model.state_index(name).is_some() {
            return Err(Refusal::input(format!(
                "`{name}` is a state, not a parameter: --set cannot change it"
            ))
            .help(format!("start it elsewhere with --initial {name}={text}")));
        }
        let from_option = |error: ModelError| error.with_source_name(&format!("--set {name}"));
        model.set_parameter(name, text).map_err(from_option)?;
    }
    // At the values of all of them: one at a time may lead through what none is meant to be.
    if let Some(last) = set.last() {
        let from_option =
            |error: ModelError| error.with_source_name(&format!("--set {}", last.name));
        model.check_defined().map_err(from_option)?;
    }
    Ok(())
}

/// That no name is given two values.
fn once_each(option: &str, all: &[Assignment]) -> Result<(), Refusal> {
    for (place, Assignment { name, text }) in all.iter().enumerate() {
        if let Some(before) = all[..place].iter().find(|before| before.name == *name) {
            return Err(Refusal::input(format!(
                "`{name}` is given twice: {option} {name}={} and {option} {name}={text}",
                before.text
            )));
        }
    }
    Ok(())
}

/// Sets initial values.
///
/// # Errors
/// A name is none of a state or given twice, or an expression is wrong.
pub fn set_initial(model: &mut Model, initial: &[Assignment]) -> Result<(), Refusal> {
    once_each("--initial", initial)?;
    for Assignment { name, text } in initial {
        if model.state_index(name).is_none() {
            if model.parameter_index(name).is_some() {
                return Err(Refusal::input(format!(
                    "`{name}` is a parameter, not a state: --initial cannot change it"
                ))
                .help(format!("give it another value with --set {name}={text}")));
            }
            if name == "t" {
                return Err(Refusal::input(
                    "the equations do not depend on time: every trajectory starts at time 0",
                ));
            }
        }
        let from_option = |error: ModelError| error.with_source_name(&format!("--initial {name}"));
        model.set_initial(name, text).map_err(from_option)?;
    }
    Ok(())
}

fn not_found(given: &str, path: &Path) -> Refusal {
    let looks_like_file = path.extension().is_some() || given.contains(['/', '\\']);
    if !looks_like_file {
        let refusal = Refusal::input(format!(
            "there is neither a file nor a shipped model called `{given}`"
        ));
        return match shipped::suggest(given) {
            Some(name) => refusal.did_you_mean(Some(name)),
            None => refusal.help("`chatter models` lists the shipped models"),
        };
    }
    let refusal = Refusal::input(format!("there is no file `{given}`"));
    let stem = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned());
    let shipped = stem.as_deref().and_then(shipped::find);
    if let Some(shipped) = shipped {
        return refusal.help(format!(
            "the shipped model of this name is called `{}`, without folder and extension",
            shipped.name
        ));
    }
    refusal.did_you_mean(neighbour(path, &|name| name.ends_with(".toml")))
}

/// The file of the same folder whose name is nearest, among those that fit.
pub fn neighbour(path: &Path, fits: &dyn Fn(&str) -> bool) -> Option<String> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let name = path.file_name()?.to_string_lossy().into_owned();
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|name| fits(name))
        .collect();
    names.sort();
    let best = nearest(&name, names.iter().map(String::as_str))?;
    Some(path.with_file_name(best).display().to_string())
}
