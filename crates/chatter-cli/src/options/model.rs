//! Which model, with which parameters and initial values.

use crate::data_files::{DataFiles, beside, text_of};
use crate::failure::Failure;
use crate::shipped;
use chatter::expressions::nearest;
use chatter::model::{Model, ModelError};
use clap::Args;
use std::path::Path;

/// Name and expression on either side of an equals sign.
#[derive(Clone, Debug)]
pub struct Assignment {
    name: String,
    text: String,
}

impl Assignment {
    /// Of an expression to a name.
    pub fn new(name: &str, text: &str) -> Self {
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
        }
    }

    /// Name and expression.
    pub fn pair(&self) -> (String, String) {
        (self.name.clone(), self.text.clone())
    }
}

impl std::str::FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or("expected NAME=EXPR, such as q=0.0195")?;
        Ok(Self {
            name: name.trim().to_owned(),
            text: value.trim().to_owned(),
        })
    }
}

/// The model and its parameters.
#[derive(Args, Clone, Debug)]
pub struct ModelOptions {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL")]
    pub model: String,

    /// Give a parameter another value: a number or an expression in other parameters
    #[arg(long = "set", value_name = "NAME=EXPR")]
    pub set: Vec<Assignment>,
}

/// Where a trajectory starts.
#[derive(Args, Clone, Debug)]
pub struct Initial {
    /// Start a state elsewhere: a number or an expression in parameters; `t` is the time at the start
    #[arg(long = "initial", value_name = "NAME=EXPR")]
    pub initial: Vec<Assignment>,
}

impl ModelOptions {
    /// Reads the model and sets its parameters.
    pub fn load(&self) -> Result<Loaded, Failure> {
        let (text, path) = read(&self.model)?;
        let mut data_files = DataFiles::new();
        let mut load = beside(path, &mut data_files);
        let mut model = Model::from_toml_with(&text, &self.model, &mut load)?;
        drop(load);
        for Assignment { name, text } in &self.set {
            if model.parameter_index(name).is_none() && model.state_index(name).is_some() {
                return Err(Failure::input(format!(
                    "`{name}` is a state, not a parameter: --set cannot change it"
                ))
                .help(format!("start it elsewhere with --initial {name}={text}")));
            }
            let from_option = |error: ModelError| error.with_source_name(&format!("--set {name}"));
            model.set_parameter(name, text).map_err(from_option)?;
        }
        // At the values of all of them: one at a time may lead through what none is meant to be.
        if let Some(last) = self.set.last() {
            let from_option =
                |error: ModelError| error.with_source_name(&format!("--set {}", last.name));
            model.check_defined().map_err(from_option)?;
        }
        Ok(Loaded {
            model,
            text,
            data_files,
        })
    }
}

/// A model and the file it came from.
pub struct Loaded {
    /// The model, with parameters set.
    pub model: Model,
    /// The text of its file.
    pub text: String,
    /// The files that its tables stand in.
    pub data_files: DataFiles,
}

impl Initial {
    /// Sets the initial values.
    pub fn apply(&self, model: &mut Model) -> Result<(), Failure> {
        for Assignment { name, text } in &self.initial {
            if model.state_index(name).is_none() {
                if model.parameter_index(name).is_some() {
                    return Err(Failure::input(format!(
                        "`{name}` is a parameter, not a state: --initial cannot change it"
                    ))
                    .help(format!("give it another value with --set {name}={text}")));
                }
                if name == "t" {
                    return Err(Failure::input(
                        "the equations do not depend on time: every trajectory starts at time 0",
                    ));
                }
            }
            let from_option =
                |error: ModelError| error.with_source_name(&format!("--initial {name}"));
            model.set_initial(name, text).map_err(from_option)?;
        }
        Ok(())
    }
}

/// The text of a file, and its path, else the text of a shipped model.
fn read(given: &str) -> Result<(String, Option<&Path>), Failure> {
    let path = Path::new(given);
    if !path.exists()
        && let Some(shipped) = shipped::find(given)
    {
        return Ok((shipped.text.to_owned(), None));
    }
    if path.is_dir() {
        return Err(Failure::input(format!(
            "`{given}` is a folder, not a model file"
        )));
    }
    match std::fs::read(path) {
        Ok(bytes) => match text_of(bytes) {
            Ok(text) => Ok((text, Some(path))),
            Err(line) => Err(Failure::input(format!(
                "`{given}` is no text: line {line} is not UTF-8"
            ))),
        },
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err(not_found(given, path)),
        Err(error) => Err(Failure::input(format!("cannot read `{given}`: {error}"))),
    }
}

fn not_found(given: &str, path: &Path) -> Failure {
    let looks_like_file = path.extension().is_some() || given.contains(['/', '\\']);
    if !looks_like_file {
        let failure = Failure::input(format!(
            "there is neither a file nor a shipped model called `{given}`"
        ));
        return match shipped::suggest(given) {
            Some(name) => failure.did_you_mean(Some(name)),
            None => failure.help("`chatter models` lists the shipped models"),
        };
    }
    let failure = Failure::input(format!("there is no file `{given}`"));
    let stem = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned());
    let shipped = stem.as_deref().and_then(shipped::find);
    if let Some(shipped) = shipped {
        return failure.help(format!(
            "the shipped model of this name is called `{}`, without folder and extension",
            shipped.name
        ));
    }
    failure.did_you_mean(neighbour(path, &|name| name.ends_with(".toml")))
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
