//! Which rows a table has.

use crate::options::{Count, Quantity};
use crate::refusal::Refusal;
use chatter::analysis::simulate::Sampling;
use chatter::expressions::nearest;
use chatter::model::Model;

/// Rows of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SampleOption {
    /// One an event.
    Events,
    /// So many in each step of the integration, and two at each event.
    Dense(u32),
    /// One in each interval of time.
    Every(Quantity),
}

/// Rows a step: enough for straight lines between them to look smooth.
const USUAL_DENSITY: u32 = 16;

impl Default for SampleOption {
    fn default() -> Self {
        Self::Dense(USUAL_DENSITY)
    }
}

impl std::str::FromStr for SampleOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "events" => Ok(Self::Events),
            None if text == "dense" => Ok(Self::default()),
            None => match nearest(text, ["events", "dense"]) {
                Some(meant) => Err(format!("did you mean `{meant}`?")),
                None => Ok(Self::Every(Quantity(text.to_owned()))),
            },
            Some(("dense", count)) => match count.parse() {
                Ok(Count(number)) => match u32::try_from(number) {
                    Ok(number) => Ok(Self::Dense(number)),
                    Err(_) => Err(format!("{number} samples a step are too many")),
                },
                Err(error) => Err(format!("`{count}` is no count: {error}")),
            },
            Some(_) => {
                Err("expected `events`, `dense`, `dense:N` or an interval of time".to_owned())
            }
        }
    }
}

impl SampleOption {
    /// What the run has to sample for it.
    pub fn sampling(&self, model: &mut Model) -> Result<Option<Sampling>, Refusal> {
        Ok(match self {
            Self::Events => None,
            Self::Dense(per_step) => Some(Sampling::Dense {
                per_step: *per_step,
            }),
            Self::Every(interval) => Some(Sampling::Every(interval.value(model, "--sample")?)),
        })
    }
}
