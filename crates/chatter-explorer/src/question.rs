//! Questions: JSON whose parts are written as on the command line.

use chatter::analysis::diagram::Record;
use chatter_work::Refusal;
use chatter_work::data_files::DataFiles;
use chatter_work::diagram::Request;
use chatter_work::options::{
    Assignment, AtOption, AxesOption, Count, ObserveOption, Quantity, SpanOption, StartOption,
    SweepOption, Window,
};
use chatter_work::simulation::SampleOption;
use chatter_work::simulation::picture::Axes;
use chatter_work::source::{Loaded, Source, set_initial, set_parameters};
use core::str::FromStr;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// A question of this kind.
///
/// # Errors
/// It is none.
pub fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, Refusal> {
    serde_json::from_slice(body)
        .map_err(|error| Refusal::input(format!("this is no such question: {error}")))
}

/// The model that is asked about.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelQuestion {
    /// What it is called.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Parameters set: name and expression.
    #[serde(default)]
    pub set: Vec<(String, String)>,
    /// Initial values set: name and expression.
    #[serde(default)]
    pub initial: Vec<(String, String)>,
}

/// A range of a parameter.
///
/// # Errors
/// It is none.
pub fn range(from: f64, to: f64) -> Result<(f64, f64), Refusal> {
    match from < to && from.is_finite() && to.is_finite() {
        true => Ok((from, to)),
        false => Err(Refusal::input("expected a range, the smaller end first")),
    }
}

fn assignments(pairs: &[(String, String)]) -> Vec<Assignment> {
    let pairs = pairs.iter();
    pairs
        .map(|(name, text)| Assignment::new(name, text))
        .collect()
}

impl ModelQuestion {
    /// Where it comes from. A model that is asked about names no files: those that it may use were read before.
    pub fn source(&self, files: &DataFiles) -> Source {
        Source::kept(&self.name, &self.text, files.clone())
    }

    /// The model, with everything set into it.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn load(&self, files: &DataFiles) -> Result<Loaded, Refusal> {
        let mut loaded = self.source(files).load()?;
        set_parameters(&mut loaded.model, &assignments(&self.set))?;
        set_initial(&mut loaded.model, &assignments(&self.initial))?;
        Ok(loaded)
    }
}

/// What is asked about a diagram.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiagramQuestion {
    pub model: ModelQuestion,
    /// Sweeps, one after the other, each of one or two ranges.
    pub runs: Vec<Vec<String>>,
    #[serde(default)]
    pub section: Option<String>,
    #[serde(default)]
    pub at: Option<String>,
    #[serde(default)]
    pub period: Option<String>,
    #[serde(default)]
    pub every: Option<String>,
    #[serde(default)]
    pub observe: Vec<String>,
    #[serde(default)]
    pub transient: Option<u64>,
    #[serde(default)]
    pub keep: Option<String>,
    #[serde(default)]
    pub start: Option<String>,
    /// Between which bounds random starts are drawn.
    #[serde(default)]
    pub bounds: Vec<String>,
    #[serde(default)]
    pub seed: Option<u64>,
    #[serde(default)]
    pub exponent: bool,
}

/// A part of a question, as the option of this name.
pub fn option<T: FromStr<Err: ToString>>(name: &str, text: &str) -> Result<T, Refusal> {
    text.parse().map_err(|error: T::Err| {
        Refusal::input(format!("--{name} `{text}`: {}", error.to_string()))
    })
}

fn maybe<T: FromStr<Err: ToString>>(name: &str, text: Option<&str>) -> Result<Option<T>, Refusal> {
    text.map(|text| option(name, text)).transpose()
}

fn all<T: FromStr<Err: ToString>>(name: &str, texts: &[String]) -> Result<Vec<T>, Refusal> {
    texts.iter().map(|text| option(name, text)).collect()
}

impl DiagramQuestion {
    /// What is asked of one of the sweeps.
    ///
    /// # Errors
    /// A part of it is wrong.
    pub fn request(&self, run: &[String]) -> Result<Request, Refusal> {
        let sweeps: Vec<SweepOption> = all("sweep", run)?;
        let observe: Vec<ObserveOption> = all("observe", &self.observe)?;
        // What is swept takes the place of what is set.
        let others = |pairs: &[(String, String)]| {
            let mut kept = assignments(pairs);
            kept.retain(|one| sweeps.iter().all(|sweep| sweep.name() != one.name));
            kept
        };
        Ok(Request {
            set: others(&self.model.set),
            initial: others(&self.model.initial),
            section: self.section.clone(),
            at: maybe::<AtOption>("at", self.at.as_deref())?
                .into_iter()
                .collect(),
            period: self.period.clone(),
            every: maybe::<Count>("every", self.every.as_deref())?,
            observe: observe.into_iter().map(|one| one.0).collect(),
            transient: self.transient,
            keep: maybe::<Count>("keep", self.keep.as_deref())?,
            start: maybe::<StartOption>("start", self.start.as_deref())?,
            bounds: all::<SpanOption>("box", &self.bounds)?,
            seed: self.seed,
            exponent: self.exponent,
            record: (sweeps.len() > 1).then_some(Record::Classes),
            sweeps,
            ..Request::default()
        })
    }
}

/// What is asked about a motion.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryQuestion {
    pub model: ModelQuestion,
    /// When it ends at the latest.
    #[serde(default)]
    pub until: Option<String>,
    /// What is shown of it.
    #[serde(default)]
    pub window: Option<String>,
    /// Panels of a picture.
    #[serde(default)]
    pub axes: Vec<String>,
    /// Rows of a table.
    #[serde(default)]
    pub sample: Option<String>,
}

impl HistoryQuestion {
    /// The end and what is shown.
    ///
    /// # Errors
    /// A part of it is wrong.
    pub fn times(&self) -> Result<(Option<Quantity>, Option<Window>), Refusal> {
        Ok((
            maybe("until", self.until.as_deref())?,
            maybe("window", self.window.as_deref())?,
        ))
    }

    /// The panels of its picture; the usual ones if there are none.
    ///
    /// # Errors
    /// One of them is none.
    pub fn panels(&self) -> Result<Vec<Axes>, Refusal> {
        let axes: Vec<AxesOption> = all("axes", &self.axes)?;
        Ok(axes.into_iter().map(|AxesOption(axes)| axes).collect())
    }

    /// The rows of its table.
    ///
    /// # Errors
    /// There are none like that.
    pub fn rows(&self) -> Result<SampleOption, Refusal> {
        Ok(maybe("sample", self.sample.as_deref())?.unwrap_or_default())
    }
}

/// What is asked about branches of periodic orbits.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchesQuestion {
    pub model: ModelQuestion,
    pub parameter: String,
    pub from: f64,
    pub to: f64,
    #[serde(default)]
    pub section: Option<String>,
    #[serde(default)]
    pub period: Option<String>,
    /// Whether branches are followed that leave at period doublings.
    #[serde(default)]
    pub doublings: u64,
}

/// What is asked about the curve of a special point in two parameters.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveQuestion {
    /// With the values of both parameters at the point.
    pub model: ModelQuestion,
    /// The parameter that is left free, and the one that is followed over the range.
    pub parameters: [String; 2],
    pub from: f64,
    pub to: f64,
    #[serde(default)]
    pub section: Option<String>,
    #[serde(default)]
    pub period: Option<String>,
    /// What kind of point it is.
    pub kind: String,
    /// The states of its orbit, in order.
    pub state: Vec<f64>,
    /// The period of its orbit.
    pub orbit_period: f64,
}

/// What is asked about border orbits: those of a range, or as a file the one near a value.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BorderQuestion {
    pub model: ModelQuestion,
    pub parameter: String,
    pub from: f64,
    pub to: f64,
    #[serde(default)]
    pub near: Option<f64>,
}

/// What is asked about the universal map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UniversalQuestion {
    pub restitution: f64,
    pub slope: f64,
    pub mu: f64,
}
