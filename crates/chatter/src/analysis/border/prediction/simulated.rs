//! The system itself near a border orbit, passage by passage, beside the prediction.

use super::super::coordinate::sequence::{Until, Verdict};
use super::super::error::BorderError;
use super::super::orbit::Border;
use super::super::problem::Problem;
use super::super::release::equations::Place;
use super::super::spec::BorderSpec;
use crate::model::Model;
use crate::numerics::Real;
use serde::{Deserialize, Serialize};

/// Passages of the flow through the neighbourhood of release.
#[derive(Clone, Debug)]
pub struct Simulator {
    pub(in crate::analysis::border) problem: Problem,
    pub(in crate::analysis::border) long_flights: usize,
    pub(in crate::analysis::border) release: Place,
}

/// One passage: a chatter sequence between two long flights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passage {
    /// State after its first impact.
    pub state: Vec<f64>,
    /// Impacts.
    pub impacts: u64,
}

/// A simulated orbit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// Passages after the transient.
    pub passages: Vec<Passage>,
    /// What ended it: not [`Stopped`](Verdict::Stopped) where chatter is complete, or impacts go on for ever without a long flight,
    /// as they may far from the border.
    pub verdict: Verdict,
}

impl Simulator {
    /// For the system that a border was found in.
    ///
    /// # Errors
    /// As for [`borders_in`](crate::analysis::border_search::borders_in).
    pub fn new<R: Real>(
        model: &Model,
        spec: &BorderSpec,
        border: &Border<R>,
    ) -> Result<Self, BorderError> {
        Ok(Self {
            problem: Problem::new(model, spec)?,
            long_flights: border.long_flights,
            release: border.release.place(),
        })
    }

    /// Follows the flow from release at a parameter value: `keep` passages after `transient` others.
    ///
    /// # Errors
    /// The trajectory cannot go on.
    pub fn orbit(
        &self,
        parameter: f64,
        transient: usize,
        keep: usize,
    ) -> Result<Simulated, BorderError> {
        let here = self.problem.at(parameter)?;
        let release = here.release(&self.release)?;
        let until = Until {
            arrivals: (transient + keep) * self.long_flights + 1,
            ..Until::NEVER
        };
        let sequence = here.follow((release.contact, &release.state), until)?;
        let arrivals = sequence.impacts.iter().enumerate();
        let arrivals = arrivals.filter(|(_, impact)| impact.arrives);
        let begins: Vec<usize> = (arrivals.map(|(place, _)| place))
            .step_by(self.long_flights)
            .collect();
        let passage = |ends: &[usize]| Passage {
            state: sequence.impacts[ends[0]].state.clone(),
            impacts: (ends[1] - ends[0]) as u64,
        };
        let all = begins.windows(2).skip(transient).take(keep);
        Ok(Simulated {
            passages: match sequence.verdict {
                Verdict::Stopped => all.map(passage).collect(),
                _ => Vec::new(),
            },
            verdict: sequence.verdict,
        })
    }
}
