//! A diagram read back from the NPZ file that it was written to.

use super::job::Job;
use super::source::{Class, Source};
use super::table::{MODEL, SPECIFICATION};
use crate::refusal::Refusal;
use crate::universal::UniversalJob;
use chatter::analysis::diagram::{Exponent, Outcome, Record, Spec, Sweep};
use chatter_files::tables::NpzReader;
use serde::Deserialize;
use std::path::Path;

/// What there are diagrams of.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Subject {
    /// The return map of a model.
    Flow(Job),
    /// The universal map.
    Universal(UniversalJob),
}

impl Subject {
    fn spec(&self) -> &Spec {
        match self {
            Self::Flow(job) => &job.diagram,
            Self::Universal(job) => &job.diagram,
        }
    }
}

/// An open file.
pub struct Stored {
    file: NpzReader,
    /// Rows of the diagram, once its arrays have been compared with what it says it is.
    rows: Option<u64>,
    /// What it holds.
    pub subject: Subject,
    /// Text of the model's file.
    pub model_text: String,
}

impl Stored {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self, Refusal> {
        let file = NpzReader::open(path).map_err(Refusal::input)?;
        let foreign = |why: String| {
            Refusal::input(format!(
                "`{}` holds no orbit diagram: {why}",
                path.display()
            ))
            .help("`chatter diagram … --out FILE.npz` writes one")
        };
        let text = |name: &str| file.text(name).map_err(|error| foreign(error.to_string()));
        // What a motion is sampled at, a diagram has no column of.
        let other = || match file.info("time").is_ok() {
            true => "it holds a motion, as `chatter simulate` writes it",
            false => "what it says of itself is no specification of one",
        };
        let subject =
            serde_json::from_str(&text(SPECIFICATION)?).map_err(|_| foreign(other().to_owned()))?;
        let model_text = text(MODEL)?;
        Ok(Self {
            file,
            rows: None,
            subject,
            model_text,
        })
    }

    /// Whether the arrays have the lengths of this diagram, which is the one that the file says it is. Nothing can be drawn
    /// of it before: what a specification claims may take for ever, what is there does not.
    pub fn check(&mut self, sweep: &Sweep) -> Result<(), Refusal> {
        let length = |name: &str| -> Result<u64, Refusal> {
            Ok(self.file.info(name).map_err(Refusal::input)?.len() as u64)
        };
        let expect = |name: &str, expected: u64, found: u64| {
            if found == expected {
                return Ok(());
            }
            Err(Refusal::input(format!(
                "array `{name}` has {found} values, where the specification beside it asks for {expected}"
            )))
        };
        let spec = sweep.spec();
        let [outcome, period, impacts, exponent, start, attractor] = Sweep::CLASS_NAMES;
        let mut classes = vec![outcome, period, impacts, start];
        if spec.exponent == Exponent::Largest {
            classes.push(exponent);
        }
        if self.file.contains(attractor) {
            classes.push(attractor);
        }
        for name in classes {
            expect(name, sweep.rows(), length(name)?)?;
        }
        if spec.record == Record::Samples {
            let samples = length(Sweep::COLUMN_NAME)?;
            for observed in &spec.observe {
                expect(&observed.name, samples, length(&observed.name)?)?;
            }
        }
        self.rows = Some(sweep.rows());
        Ok(())
    }

    fn checked_rows(&self) -> Result<u64, Refusal> {
        self.rows.ok_or_else(|| {
            Refusal::input("the arrays have not been compared with the specification")
        })
    }

    fn numbers(
        &self,
        name: &str,
    ) -> Result<impl Iterator<Item = Result<f64, Refusal>> + use<>, Refusal> {
        let stream = self.file.stream_floats(name).map_err(Refusal::input)?;
        Ok(stream.map(|number| number.map_err(Refusal::input)))
    }
}

/// The next of a stream that must be as long as another.
fn following(stream: &mut impl Iterator<Item = Result<f64, Refusal>>) -> Result<f64, Refusal> {
    let short = || Refusal::input("the table's columns differ in length");
    stream.next().ok_or_else(short)?
}

impl Source for Stored {
    fn samples(&mut self, visit: &mut dyn FnMut(u64, &[f64])) -> Result<(), Refusal> {
        let columns = self.numbers(Sweep::COLUMN_NAME)?;
        let mut streams = Vec::new();
        for observed in &self.subject.spec().observe {
            streams.push(self.numbers(&observed.name)?);
        }
        let mut sample = vec![0.0; streams.len()];
        let rows = self.checked_rows()?;
        for column in columns {
            for (value, stream) in sample.iter_mut().zip(&mut streams) {
                *value = following(stream)?;
            }
            let column = column?;
            if !(column >= 0.0 && column < rows as f64) {
                return Err(Refusal::input(format!(
                    "a sample belongs to column {column}, but there are {rows}"
                )));
            }
            visit(column as u64, &sample);
        }
        Ok(())
    }

    fn classes(&mut self, visit: &mut dyn FnMut(u64, &Class)) -> Result<(), Refusal> {
        let [outcome, period, impacts, exponent, _, attractor] = Sweep::CLASS_NAMES;
        self.checked_rows()?;
        let outcomes = self.file.stream_texts(outcome).map_err(Refusal::input)?;
        let mut periods = self.numbers(period)?;
        let mut impacts = self.numbers(impacts)?;
        let maybe = |name: &str| match self.file.contains(name) {
            true => self.numbers(name).map(Some),
            false => Ok(None),
        };
        let (mut exponents, mut attractors) = (maybe(exponent)?, maybe(attractor)?);
        for (row, name) in (0..).zip(outcomes) {
            let name = name.map_err(Refusal::input)?;
            let outcome = Outcome::ALL.into_iter().find(|known| known.name() == name);
            let unknown = || Refusal::input(format!("`{name}` is no known outcome"));
            let class = Class {
                outcome: outcome.ok_or_else(unknown)?,
                period: following(&mut periods)? as u64,
                impacts_per_return: following(&mut impacts)?,
                exponent: match &mut exponents {
                    Some(stream) => following(stream)?,
                    None => f64::NAN,
                },
                attractor: match &mut attractors {
                    Some(stream) => following(stream)? as u32,
                    None => 0,
                },
            };
            visit(row, &class);
        }
        Ok(())
    }
}
