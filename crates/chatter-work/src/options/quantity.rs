//! Numbers on the command line: decimal numbers or expressions in the model's parameters.

use crate::refusal::Refusal;
use chatter::model::{Model, ModelError};
use chatter::numerics::DoubleDouble;

/// The text of a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity(pub String);

impl std::str::FromStr for Quantity {
    type Err = core::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self(text.to_owned()))
    }
}

impl Quantity {
    /// Its value at the model's parameters. `option` is where it was given.
    pub fn value(&self, model: &mut Model, option: &str) -> Result<DoubleDouble, Refusal> {
        let text = self.0.as_str();
        let parsed = model.parse_expression(text);
        let expr = parsed.map_err(|error| {
            ModelError::of_expression(option, text, error, &model.parameter_names())
        })?;
        if model.graph.depends_on_state(expr) {
            return Err(Refusal::input(format!(
                "{option}: `{text}` depends on the state; expected a number or an expression in parameters"
            )));
        }
        let parameters = model.parameter_values(&[]);
        let value: DoubleDouble = model.graph.evaluate(expr, &[], &parameters);
        if value.high().is_finite() {
            Ok(value)
        } else {
            Err(Refusal::input(format!(
                "{option}: `{text}` is {}; expected a finite number",
                value.high()
            )))
        }
    }
}

/// An interval, of time or of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    from: Quantity,
    to: Quantity,
}

impl std::str::FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (from, to) = text
            .split_once(':')
            .ok_or("expected FROM:TO, such as 10:20")?;
        Ok(Self::new(from, to))
    }
}

impl Window {
    /// Between two numbers.
    pub fn new(from: &str, to: &str) -> Self {
        Self {
            from: Quantity(from.to_owned()),
            to: Quantity(to.to_owned()),
        }
    }

    /// The texts of its ends.
    pub fn texts(&self) -> (&str, &str) {
        (&self.from.0, &self.to.0)
    }

    /// Its ends at the model's parameters. `option` is where it was given.
    pub fn values(&self, model: &mut Model, option: &str) -> Result<(f64, f64), Refusal> {
        let (from, to) = self.ends(model, option)?;
        if from < to {
            Ok((from, to))
        } else {
            Err(Refusal::input(format!(
                "{option}: {from}:{to} is no interval of time; expected the earlier time first"
            )))
        }
    }

    /// Its ends at the model's parameters, in whatever order they were given.
    pub fn ends(&self, model: &mut Model, option: &str) -> Result<(f64, f64), Refusal> {
        let from = self.from.value(model, option)?.high();
        Ok((from, self.to.value(model, option)?.high()))
    }
}
