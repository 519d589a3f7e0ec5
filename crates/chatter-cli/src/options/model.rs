//! Which model, with which parameters and initial values.

use super::Assignment;
use crate::failure::Failure;
use chatter::model::Model;
use chatter_work::source::{Loaded, Source, set_initial, set_parameters};
use clap::Args;

/// The model and its parameters.
#[derive(Args, Clone, Debug)]
pub struct ModelOptions {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL")]
    pub model: String,

    /// Give a parameter another value: a number or an expression in other parameters
    #[arg(long = "set", value_name = "NAME=EXPR")]
    pub set: Vec<Assignment>,
}

/// Where a trajectory starts.
#[derive(Args, Clone, Debug)]
pub struct Initial {
    /// Start a state elsewhere: a number or an expression in parameters; `t` is the time at the start
    #[arg(long = "initial", value_name = "NAME=EXPR")]
    pub initial: Vec<Assignment>,
}

impl ModelOptions {
    /// Reads the model and sets its parameters.
    pub fn load(&self) -> Result<Loaded, Failure> {
        let mut loaded = Source::named(&self.model)?.load()?;
        set_parameters(&mut loaded.model, &self.set)?;
        Ok(loaded)
    }
}

impl Initial {
    /// Sets the initial values.
    pub fn apply(&self, model: &mut Model) -> Result<(), Failure> {
        set_initial(model, &self.initial)
    }
}
