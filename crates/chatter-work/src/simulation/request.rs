//! What is asked of a simulation.

use crate::options::{Count, Quantity};
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Spec, Stop};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real as _};

/// What ends a run, and how exactly it is followed. What is none is as usual.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// When it ends at the latest.
    pub until: Option<Quantity>,
    /// After how many impacts.
    pub impacts: Option<Count>,
    /// At which events.
    pub stops: Vec<Stop>,
    /// Relative error of a step.
    pub tolerance: Option<Quantity>,
}

/// Units of time within which an event that is waited for should come.
const LONG_TIME: f64 = 1e6;

impl Request {
    /// Units of time that a run lasts if nothing else is said.
    pub const USUAL_TIME: f64 = 100.0;

    /// The specification, without samples. A run that is not told when to end does so at rest.
    ///
    /// # Errors
    /// A number is none, or not in its range.
    pub fn spec(&self, model: &mut Model) -> Result<Spec, Refusal> {
        let start = start_time(model);
        let mut stops = self.stops.clone();
        let until = match &self.until {
            Some(until) => until.value(model, "--until")?,
            None => {
                let waits = !stops.is_empty() || self.impacts.is_some();
                let lasts = if waits { LONG_TIME } else { Self::USUAL_TIME };
                stops.push(Stop::Rest);
                start + DoubleDouble::from(lasts)
            }
        };
        let tolerance = match &self.tolerance {
            Some(tolerance) => tolerance.value(model, "--tolerance")?.high(),
            None => 0.0,
        };
        // What is told of it is named by what it is at these values.
        *model = model.with_telling_numbers(&[]);
        Ok(Spec {
            impacts: self.impacts.map_or(Spec::IMPACT_BUDGET, |count| count.0),
            stops,
            tolerance,
            ..Spec::until(until)
        })
    }
}

/// The time at which trajectories of a model start.
pub fn start_time(model: &Model) -> DoubleDouble {
    let parameters = model.parameter_values::<DoubleDouble>(&[]);
    let initial = model.initial_state(&parameters);
    model.time.map_or(DoubleDouble::ZERO, |time| initial[time])
}
