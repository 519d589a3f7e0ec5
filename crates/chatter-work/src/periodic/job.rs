//! Which branches are to be found: all that a run needs to go on where another was broken off.

use super::check_names;
use super::request::{free_parameter, specification};
use super::restored::Restored;
use super::wanted::{Branches, Reach, beside, search};
use crate::data_files::DataFiles;
use crate::options::{Assignment, Quantity, Window};
use crate::refusal::Refusal;
use crate::source::{Source, set_initial, set_parameters};
use chatter::analysis::periodic::BranchSpec;
use chatter::model::Model;
use chatter::numerics::Real;
use serde::{Deserialize, Serialize};

/// Branches of a model, as they were asked for. Equal jobs have equal results, to the bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Version of this program.
    pub version: String,
    /// The model as the user named it.
    pub model: String,
    /// Text of the model's file.
    pub model_text: String,
    /// The files that the model's tables stand in, as they were.
    #[serde(default, skip_serializing_if = "DataFiles::is_empty")]
    pub data_files: DataFiles,
    /// Parameters set by the user: name and expression.
    pub set: Vec<(String, String)>,
    /// Initial values set by the user: name and expression.
    pub initial: Vec<(String, String)>,
    /// From every orbit that such a search finds; without it from the one that the motion settles to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<Sought>,
    /// Period of the forcing.
    pub period: Option<String>,
    /// The section at which states are told.
    pub section: Option<String>,
    /// Functions that are watched.
    pub monitors: Vec<String>,
    /// The parameter that is varied, …
    pub parameter: String,
    /// … and its range, from and to.
    pub range: (String, String),
    /// Impacts a period, at most.
    pub impacts: Option<u64>,
    /// Orbits of one branch to either side, at most.
    pub points: Option<u64>,
    /// The longest step, in parts of the range.
    pub step: Option<String>,
    /// How often a branch is left for another at period doublings, …
    pub doublings: u64,
    /// … and at branch points.
    pub branch_points: u64,
    /// The curves of these special points in two parameters, and no branches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
}

/// Special points that are followed in two parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// The parameter that is free beside the one that is varied.
    pub other: String,
    /// Its range, from and to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<(String, String)>,
    /// The points.
    pub points: Vec<Restored>,
}

/// A search for orbits, as it was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sought {
    /// Of so many periods, at most, …
    pub periods: u64,
    /// … from so many starts …
    pub starts: Option<u64>,
    /// … that this seed draws.
    pub seed: Option<u64>,
}

/// A job made ready.
pub struct Ready {
    /// The model, with everything set into it.
    pub model: Model,
    /// Which branches; of curves the limits.
    pub wanted: Branches,
    /// Positions of the parameters that are free.
    pub free: Vec<usize>,
}

fn assignments(all: &[(String, String)]) -> Vec<Assignment> {
    all.iter()
        .map(|(name, text)| Assignment::new(name, text))
        .collect()
}

impl Job {
    /// Reads the model and checks everything.
    ///
    /// # Errors
    /// The model is wrong, or what is asked does not fit it.
    pub fn ready(&self) -> Result<Ready, Refusal> {
        let source = Source::kept(&self.model, &self.model_text, self.data_files.clone());
        let mut model = source.load()?.model;
        set_parameters(&mut model, &assignments(&self.set))?;
        set_initial(&mut model, &assignments(&self.initial))?;
        let (period, section) = (self.period.as_deref(), self.section.as_deref());
        let spec = specification(&mut model, period, (section, &self.monitors))?;
        let parameter = free_parameter(&model, &self.parameter)?;
        let (from, to) = &self.range;
        let range = Window::new(from, to).ends(&mut model, "--sweep")?;
        let step = match &self.step {
            Some(step) => Some(Quantity(step.clone()).value(&mut model, "--step")?.to_f64()),
            None => None,
        };
        let reach = Reach {
            impacts: self.impacts,
            points: self.points,
            step,
        };
        let mut limits = reach.over(range)?;
        if let Some(Plane {
            range: Some((from, to)),
            ..
        }) = &self.plane
        {
            let range = Window::new(from, to).ends(&mut model, "--sweep")?;
            limits.other = Some(reach.over(range)?.range);
        }
        let over = BranchSpec {
            parameter,
            limits,
            beside: beside(self.doublings, self.branch_points)?,
        };
        let sought = |Sought {
                          periods,
                          starts,
                          seed,
                      }: Sought| search(periods, starts, seed);
        let search = self.search.map(sought).transpose()?;
        let wanted = Branches { spec, over, search };
        let other = self.plane.as_ref().map(|plane| &plane.other);
        let other = other.map(|name| free_parameter(&model, name)).transpose()?;
        let free: Vec<usize> = other.into_iter().chain([parameter]).collect();
        check_names(&model, &free)?;
        Ok(Ready {
            model,
            wanted,
            free,
        })
    }

    /// What another job differs in, in words.
    pub(super) fn difference(&self, other: &Self) -> &'static str {
        if (&self.model, &self.model_text) != (&other.model, &other.model_text) {
            "another model"
        } else if self.version != other.version {
            "another version of chatter"
        } else if (&self.set, &self.initial) != (&other.set, &other.initial) {
            "other parameters or initial values"
        } else if self.data_files != other.data_files {
            "other tables in the model's files"
        } else if (&self.parameter, &self.range) != (&other.parameter, &other.range) {
            "another sweep"
        } else if self.plane != other.plane {
            "other curves"
        } else if self.search != other.search {
            "another search"
        } else {
            "other options"
        }
    }
}
