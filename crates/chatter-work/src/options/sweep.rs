//! Ranges of a parameter, a quantity or a coordinate.

use super::{Assignment, Decimal, Quantity};
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Range, Spacing, Swept};
use chatter::model::Model;

/// `NAME=FROM:TO:COUNT`, with `:log` for equal ratios; `initial:NAME` for where a state starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepOption {
    name: String,
    swept: Swept,
    from: Quantity,
    to: Quantity,
    count: u64,
    spacing: Spacing,
}

impl std::str::FromStr for SweepOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected NAME=FROM:TO:COUNT, such as q=0.0201:0.0235:4000";
        let (name, range) = text.split_once('=').ok_or(EXPECTED)?;
        let parts: Vec<&str> = range.split(':').collect();
        let (&[from, to, count], spacing) = (match &parts[..] {
            [ends @ .., "log"] => (ends, Spacing::Logarithmic),
            ends => (ends, Spacing::Linear),
        }) else {
            return Err(EXPECTED.to_owned());
        };
        let count = count
            .trim()
            .parse()
            .map_err(|_| format!("`{count}` is no number of values: {EXPECTED}"))?;
        let (name, swept) = subject(name);
        Ok(Self {
            name,
            swept,
            from: Quantity(from.to_owned()),
            to: Quantity(to.to_owned()),
            count,
            spacing,
        })
    }
}

/// The parameter, or the state whose initial value is meant.
fn subject(name: &str) -> (String, Swept) {
    match name.trim().strip_prefix("initial:") {
        Some(state) => (state.trim().to_owned(), Swept::Initial),
        None => (name.trim().to_owned(), Swept::Parameter),
    }
}

impl SweepOption {
    /// The parameter or state that is swept.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What a sweep of one value sets: a parameter, or an initial value.
    pub fn assignment(&self) -> (Swept, Assignment) {
        (self.swept, Assignment::new(&self.name, &self.from.0))
    }

    /// `NAME=EXPR`: a sweep of one value.
    pub fn single(text: &str) -> Option<Self> {
        let (name, value) = text.split_once('=')?;
        let (name, swept) = subject(name);
        let value = Quantity(value.trim().to_owned());
        Some(Self {
            name,
            swept,
            from: value.clone(),
            to: value,
            count: 1,
            spacing: Spacing::Linear,
        })
    }

    /// The range where there is no model: its ends are numbers.
    pub fn plain(&self) -> Result<Range, Refusal> {
        Ok(Range {
            parameter: self.name.clone(),
            swept: self.swept,
            from: plain(&self.from, "--sweep")?,
            to: plain(&self.to, "--sweep")?,
            count: self.count,
            spacing: self.spacing,
        })
    }

    /// The range, its ends evaluated at the model's parameters.
    pub fn range(&self, model: &mut Model) -> Result<Range, Refusal> {
        let name = &self.name;
        let parameter = model.parameter_index(name).is_some();
        let state = model.state_index(name).is_some();
        match self.swept {
            Swept::Parameter if state && !parameter => {
                return Err(
                    Refusal::input(format!("`{name}` is a state, not a parameter")).help(format!(
                        "sweep its initial value: --sweep initial:{name}=FROM:TO:COUNT"
                    )),
                );
            }
            Swept::Initial if parameter && !state => {
                return Err(Refusal::input(format!(
                    "`{name}` is a parameter, not a state: it has no initial value"
                ))
                .help(format!("sweep the parameter: --sweep {name}=FROM:TO:COUNT")));
            }
            Swept::Parameter | Swept::Initial => {}
        }
        Ok(Range {
            parameter: name.clone(),
            swept: self.swept,
            from: self.from.value(model, "--sweep")?.high(),
            to: self.to.value(model, "--sweep")?.high(),
            count: self.count,
            spacing: self.spacing,
        })
    }
}

/// A number where there is no model.
fn plain(text: &Quantity, option: &str) -> Result<f64, Refusal> {
    let number = text.0.parse().map(Decimal::to_f64);
    number.map_err(|message: String| Refusal::input(format!("{option}: {message}")))
}

/// `NAME=FROM:TO`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpanOption {
    /// What it is a range of.
    pub name: String,
    from: Quantity,
    to: Quantity,
}

impl std::str::FromStr for SpanOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected NAME=FROM:TO, such as q=0.0203:0.0206";
        let (name, range) = text.split_once('=').ok_or(EXPECTED)?;
        let (from, to) = range.split_once(':').ok_or(EXPECTED)?;
        Ok(Self {
            name: name.trim().to_owned(),
            from: Quantity(from.to_owned()),
            to: Quantity(to.to_owned()),
        })
    }
}

impl SpanOption {
    /// Its ends where there is no model: numbers.
    pub fn plain_ends(&self, option: &str) -> Result<(f64, f64), Refusal> {
        Ok((plain(&self.from, option)?, plain(&self.to, option)?))
    }

    /// Its ends, evaluated at the model's parameters.
    pub fn ends(&self, model: &mut Model, option: &str) -> Result<(f64, f64), Refusal> {
        let from = self.from.value(model, option)?.high();
        let to = self.to.value(model, option)?.high();
        Ok((from, to))
    }
}
