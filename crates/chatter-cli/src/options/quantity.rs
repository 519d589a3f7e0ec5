//! Numbers on the command line: decimal numbers or expressions in the model's parameters.

use crate::failure::Failure;
use chatter::model::Model;
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
    pub fn value(&self, model: &mut Model, option: &str) -> Result<DoubleDouble, Failure> {
        let text = self.0.as_str();
        let expr = model.parse_expression(text).map_err(|error| {
            let start = text
                .get(..error.span.start)
                .map_or(0, |before| before.chars().count());
            let length = text
                .get(error.span.clone())
                .map_or(0, |part| part.chars().count());
            let mut message = format!("{option}: {}\n  {text}\n  ", error.kind);
            message.extend(core::iter::repeat_n(' ', start));
            message.extend(core::iter::repeat_n('^', length.max(1)));
            let failure = Failure::input(message);
            match error.help() {
                Some(help) => failure.help(help),
                None => failure,
            }
        })?;
        if model.graph.depends_on_state(expr) {
            return Err(Failure::input(format!(
                "{option}: `{text}` depends on the state; expected a number or an expression in parameters"
            )));
        }
        let parameters = model.parameter_values(&[]);
        let value: DoubleDouble = model.graph.evaluate(expr, &[], &parameters);
        if value.high().is_finite() {
            Ok(value)
        } else {
            Err(Failure::input(format!(
                "{option}: `{text}` is {}; expected a finite number",
                value.high()
            )))
        }
    }
}
