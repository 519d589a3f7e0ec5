//! What is to be computed, and what is to be written: all that a run needs to go on where another was broken off.

use super::picture::Shear;
use crate::data_files::{DataFiles, kept};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::{DiagramError, Range, Row, Spec, Sweep, Swept};
use chatter::analysis::return_map::{ReturnMap, ReturnMapError, ReturnSpec};
use chatter::model::{Model, ModelError};
use chatter_files::Format;
use serde::{Deserialize, Serialize};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// A diagram. Equal jobs have equal results, to the bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Version of this program.
    pub version: String,
    /// The model as the user named it, without the folder.
    pub model: String,
    /// Parameters set by the user: name and expression.
    pub set: Vec<(String, String)>,
    /// Initial values set by the user: name and expression.
    pub initial: Vec<(String, String)>,
    /// The map.
    pub returns: ReturnSpec,
    /// The diagram.
    pub diagram: Spec,
    /// The files that the model's tables stand in, as they were.
    #[serde(default, skip_serializing_if = "DataFiles::is_empty")]
    pub data_files: DataFiles,
}

/// A job and what becomes of its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// What is computed.
    pub job: Job,
    /// Text of the model's file.
    pub model_text: String,
    /// The table to be written.
    pub out: Option<PathBuf>,
    /// The figure to be drawn.
    pub plot: Option<PathBuf>,
    /// How the vertical axis of the figure is sheared.
    pub shear: Option<Shear>,
}

/// What a journal keeps of an order. It names no folder: files are written beside the one that is resumed, wherever that
/// is by then.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// What is computed.
    pub job: Job,
    /// In which form rows are kept: [`Row::FORMAT`].
    #[serde(default)]
    pub row_format: u32,
    /// Text of the model's file.
    pub model_text: String,
    /// The figure to be drawn beside the table.
    plot: Option<Figure>,
    /// How the vertical axis of the figure is sheared.
    shear: Option<Shear>,
}

/// Where a figure is to be drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Figure {
    /// In the folder of the journal, under this name.
    Beside(String),
    /// In another folder, which is to be named again.
    Elsewhere,
}

impl Order {
    /// Reads the model and checks everything.
    ///
    /// # Errors
    /// The model is wrong, or what is asked does not fit it.
    pub fn ready(&self) -> Result<Ready, Refusal> {
        self.job.prepare(&self.model_text)
    }

    /// The file that the journal is named after.
    pub fn target(&self) -> Option<&Path> {
        self.out.as_deref().or(self.plot.as_deref())
    }

    /// What a journal keeps of it.
    pub fn header(&self) -> Header {
        let beside = |plot: &PathBuf| {
            let folder = self.target().and_then(Path::parent);
            let name = plot.file_name().and_then(|name| name.to_str());
            match name {
                Some(name) if plot.parent() == folder => Figure::Beside(name.to_owned()),
                _ => Figure::Elsewhere,
            }
        };
        Header {
            job: self.job.clone(),
            row_format: Row::FORMAT,
            model_text: self.model_text.clone(),
            plot: self.plot.as_ref().map(beside),
            shear: self.shear,
        }
    }

    /// What to add to `--resume` so that nothing is left out.
    pub fn resume_options(&self) -> String {
        let target = self.target().map_or_else(String::new, shown);
        match (self.header().plot, &self.plot) {
            (Some(Figure::Elsewhere), Some(plot)) => format!("{target} --plot {}", shown(plot)),
            _ => target,
        }
    }
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

impl Header {
    /// The order that is gone on with: what was to be written to `target`, and a figure where the user says now.
    pub fn order(
        self,
        target: &Path,
        plot: Option<PathBuf>,
        observer: &dyn Observer,
    ) -> Result<Order, Refusal> {
        let is_table = Format::of_table(target).is_ok();
        let (out, drawn) = if is_table {
            let drawn = match (plot, self.plot) {
                (Some(plot), _) => Some(plot),
                (None, Some(Figure::Beside(name))) => Some(beside(target, &name)?),
                (None, Some(Figure::Elsewhere)) => {
                    observer.remark(
                        "the figure was to be drawn in another folder, and is left out; --plot FILE draws it",
                    );
                    None
                }
                (None, None) => None,
            };
            (Some(target.to_path_buf()), drawn)
        } else {
            Format::of_figure(target).map_err(Refusal::input)?;
            (None, Some(plot.unwrap_or_else(|| target.to_path_buf())))
        };
        Ok(Order {
            job: self.job,
            model_text: self.model_text,
            out,
            plot: drawn,
            shear: self.shear,
        })
    }
}

/// The figure of this name in the folder of `target`.
fn beside(target: &Path, name: &str) -> Result<PathBuf, Refusal> {
    let path = target.with_file_name(name);
    let bare = Path::new(name).file_name() == Some(OsStr::new(name));
    if bare && Format::of_figure(&path).is_ok() {
        return Ok(path);
    }
    Err(Refusal::input(format!(
        "the journal of `{}` names `{name}` as its figure, which is none beside it",
        target.display()
    ))
    .help("--plot FILE says where the figure is to be drawn"))
}

/// A job made ready.
pub struct Ready {
    /// The model, with everything set into it.
    pub model: Model,
    /// Its map.
    pub map: ReturnMap,
    /// The diagram's rows.
    pub sweep: Sweep,
}

impl Ready {
    /// A diagram of a model as it is.
    ///
    /// # Errors
    /// What is asked does not fit the model.
    pub fn new(model: Model, returns: &ReturnSpec, diagram: &Spec) -> Result<Self, Refusal> {
        let swept: Vec<usize> = (diagram.sweeps.iter())
            .filter_map(|range| model.parameter_index(&range.parameter))
            .collect();
        let amid = amid(&model, &diagram.sweeps).with_telling_numbers(&swept);
        let map = ReturnMap::new(&amid, returns).map_err(|error| look_failure(&error))?;
        let sweep = Sweep::new(&map, diagram).map_err(|error| refused(&error, &model))?;
        check_restitution(&model, &sweep)?;
        Ok(Self { model, map, sweep })
    }
}

impl Job {
    /// Reads the model and checks everything.
    pub fn prepare(&self, model_text: &str) -> Result<Ready, Refusal> {
        Ready::new(self.model(model_text)?, &self.returns, &self.diagram)
    }

    /// The model, with everything set into it.
    pub fn model(&self, text: &str) -> Result<Model, Refusal> {
        let mut model = Model::from_toml_with(text, &self.model, &mut kept(&self.data_files))?;
        for (name, text) in &self.set {
            let from_option = |error: ModelError| error.with_source_name(&format!("--set {name}"));
            model.set_parameter(name, text).map_err(from_option)?;
        }
        for (name, text) in &self.initial {
            let from_option =
                |error: ModelError| error.with_source_name(&format!("--initial {name}"));
            model.set_initial(name, text).map_err(from_option)?;
        }
        Ok(model)
    }

    /// What the model is called.
    pub fn title<'a>(&'a self, model: &'a Model) -> &'a str {
        model.title.as_deref().unwrap_or(&self.model)
    }

    /// What another job differs in, in words.
    pub fn difference(&self, other: &Self) -> &'static str {
        if self.version != other.version {
            "another version of chatter"
        } else if (&self.set, &self.initial) != (&other.set, &other.initial) {
            "other parameters or initial values"
        } else if self.data_files != other.data_files {
            "other tables in the model's files"
        } else if self.returns != other.returns {
            "another section or other limits"
        } else if self.diagram.sweeps != other.diagram.sweeps {
            "another sweep"
        } else {
            "other options"
        }
    }
}

/// The model in the middle of the sweep: what is to be checked of it holds there if anywhere, and may not hold where
/// its file puts the swept parameters.
fn amid(model: &Model, sweeps: &[Range]) -> Model {
    let mut amid = model.clone();
    for range in sweeps {
        let middle = range.value(range.count / 2);
        // What cannot be set is told by the sweep.
        if range.swept == Swept::Parameter {
            drop(amid.set_parameter(&range.parameter, &format!("{middle:e}")));
        }
    }
    amid
}

fn refused(error: &DiagramError, model: &Model) -> Refusal {
    match error {
        DiagramError::Observable { text, error } => {
            let mut known = model.state_names();
            known.extend(model.parameter_names());
            known.extend(chatter::analysis::map::Passage::NAMES);
            ModelError::of_expression("--observe", text, error.clone(), &known).into()
        }
        DiagramError::PhaseLost(lost) => Refusal::input(error).help(format!(
            "sample once in a period of the equations, --period EXPR, and `{time}` goes on in the same phase; or make \
             the phase a state of the model, with its rate as derivative; or start afresh, without --start carry",
            time = lost.coordinate
        )),
        DiagramError::CarriedInitial { .. } => {
            Refusal::input(error).help("leave out --start carry, or sweep a parameter")
        }
        _ => Refusal::input(error).did_you_mean(error.suggestion()),
    }
}

/// A restitution that depends on parameters alone is wrong from the start, at the corners of the sweep if anywhere.
fn check_restitution(model: &Model, sweep: &Sweep) -> Result<(), Refusal> {
    let ranges = &sweep.spec().sweeps;
    for corner in 0..1_u32 << ranges.len() {
        let mut overrides = Vec::new();
        let mut told = Vec::new();
        for (place, range) in ranges.iter().enumerate() {
            let upper = corner >> place & 1 == 1;
            let value = if upper { range.to } else { range.from };
            if range.swept == Swept::Parameter {
                let index = model.parameter_index(&range.parameter);
                overrides.extend(index.map(|index| (index, value)));
            }
            told.push(format!("{} = {value}", range.name()));
        }
        let parameters: Vec<f64> = model.parameter_values(&overrides);
        let state = model.initial_state(&parameters);
        for contact in &model.contacts {
            let value: f64 = model
                .graph
                .evaluate(contact.restitution, &state, &parameters);
            if !model.graph.depends_on_state(contact.restitution) && !(0.0..=1.0).contains(&value) {
                return Err(Refusal::input(format!(
                    "at {} contact `{}` has restitution {value}, outside 0 <= r <= 1",
                    told.join(", "),
                    contact.name
                )));
            }
        }
    }
    Ok(())
}

fn look_failure(error: &ReturnMapError) -> Refusal {
    match error {
        ReturnMapError::Period { text, error } => {
            ModelError::of_expression("--period", text, error.clone(), &[]).into()
        }
        _ => Refusal::input(error).did_you_mean(error.suggestion()),
    }
}
