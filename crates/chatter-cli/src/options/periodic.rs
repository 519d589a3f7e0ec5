//! Which periodic orbits are meant.

use super::{Initial, ModelOptions};
use crate::failure::Failure;
use chatter::analysis::periodic::Spec;
use chatter_work::periodic::specification;
use chatter_work::source::Loaded;
use clap::Args;

/// A model, where its motion starts, and where a period begins.
#[derive(Args, Clone, Debug)]
pub struct PeriodicOptions {
    #[command(flatten)]
    pub model: ModelOptions,

    #[command(flatten)]
    initial: Initial,

    #[command(flatten)]
    begins: PeriodBegins,
}

/// Where a period begins.
#[derive(Args, Clone, Debug)]
pub struct PeriodBegins {
    /// Period of the forcing, an expression in parameters, where the equations do not tell it
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub period: Option<String>,

    /// The section at which states are told [default: the first of the model; where it is not crossed, an event]
    #[arg(long, value_name = "NAME")]
    pub section: Option<String>,
}

impl PeriodicOptions {
    /// Reads the model and sets it up; these functions are watched.
    pub fn load(&self, monitors: &[String]) -> Result<(Loaded, Spec), Failure> {
        let mut loaded = self.model.load()?;
        self.initial.apply(&mut loaded.model)?;
        let (period, section) = (
            self.begins.period.as_deref(),
            self.begins.section.as_deref(),
        );
        let spec = specification(&mut loaded.model, period, (section, monitors))?;
        Ok((loaded, spec))
    }
}
