//! `STATE=LEVEL`: where a state has a value.

use super::Quantity;
use crate::refusal::Refusal;
use chatter::analysis::border::ReleaseSection;
use chatter::expressions::nearest;
use chatter::model::Model;

/// A state and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SectionOption {
    state: String,
    level: Quantity,
}

impl std::str::FromStr for SectionOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (state, level) = text
            .split_once('=')
            .ok_or("expected STATE=LEVEL, such as y3=10.1")?;
        Ok(Self {
            state: state.trim().to_owned(),
            level: Quantity(level.trim().to_owned()),
        })
    }
}

impl SectionOption {
    /// The section, its level at the model's parameters.
    pub fn section(&self, model: &mut Model) -> Result<ReleaseSection, Refusal> {
        if model.state_index(&self.state).is_none() {
            let known = nearest(&self.state, model.state_names());
            let failure = Refusal::input(format!("the model has no state `{}`", self.state));
            return Err(failure.did_you_mean(known));
        }
        Ok(ReleaseSection {
            state: self.state.clone(),
            level: self.level.value(model, "--section")?.high(),
        })
    }
}
