//! The system itself near a border orbit, passage by passage, beside the prediction.

use super::super::coordinate::sequence::{Until, Verdict};
use super::super::error::BorderError;
use super::super::orbit::Border;
use super::super::problem::Problem;
use super::super::release::Turn;
use super::super::release::equations::{Place, ReleaseEquations};
use super::super::spec::BorderSpec;
use super::map::to_f64;
use crate::model::Model;
use crate::numerics::Real;
use serde::{Deserialize, Serialize};

/// Passages of the flow through the neighbourhood of release.
#[derive(Clone, Debug)]
pub struct Simulator {
    pub(in crate::analysis::border) problem: Problem,
    pub(in crate::analysis::border) long_flights: usize,
    pub(in crate::analysis::border) release: Place,
    /// By how many periods the phases of the border orbit advance.
    pub(in crate::analysis::border) turns: Vec<(usize, i64)>,
    /// Flights at least this long come before the chatter of the border orbit, or early in it, and how many there are.
    pub(in crate::analysis::border) long_flight: (f64, usize),
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

/// Impacts of the chatter sequence whose flights are looked at: they get shorter.
const FOLLOWED: usize = 8;

impl Simulator {
    /// For the system that a border was found in.
    ///
    /// # Errors
    /// As for [`borders_in`](super::super::borders_in).
    pub fn new<R: Real>(
        model: &Model,
        spec: &BorderSpec,
        border: &Border<R>,
    ) -> Result<Self, BorderError> {
        let problem = Problem::new(model, spec)?;
        let value = border.value.value.to_f64();
        let release = (border.release.contact, &*to_f64(&border.release.state));
        let until = Until {
            impacts: border.sequence_begins + FOLLOWED,
            ..Until::NEVER
        };
        let begin = (problem.plain).follow(&problem.parameters(value), release, until)?;
        Ok(Self {
            problem,
            long_flight: widest_gap(begin.flights().collect()),
            long_flights: border.long_flights,
            release: border.release.place(),
            turns: (border.turns.iter())
                .map(|turn| (turn.state, turn.count))
                .collect(),
        })
    }

    /// Where the contact ends.
    pub(in crate::analysis::border) fn equations(&self) -> &ReleaseEquations {
        &self.problem.releases[self.release.contact]
    }

    /// The phases, with the turns by which they advance in a loop.
    pub(super) fn turns(&self, parameters: &[f64]) -> Vec<Turn<f64>> {
        let mut turns = self.equations().turns(parameters);
        for turn in &mut turns {
            let known = self.turns.iter().find(|(state, _)| *state == turn.state);
            turn.count = known.map_or(0, |&(_, count)| count);
        }
        turns
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
        let release = self.problem.release_point(parameter, &self.release)?;
        let parameters = self.problem.parameters(parameter);
        let until = Until {
            arrivals: (transient + keep) * self.long_flights + 1,
            ..Until::NEVER
        };
        let follower = &self.problem.plain;
        let start = (release.contact, &*release.state);
        let sequence = follower.follow(&parameters, start, until)?;
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

/// A length in the middle of the widest gap between flights no longer than the first, as a ratio, and how many flights are
/// longer than that.
fn widest_gap(mut flights: Vec<f64>) -> (f64, usize) {
    let first = flights.first().copied().unwrap_or(0.0);
    flights.sort_by(|a, b| b.total_cmp(a));
    let gaps = flights.windows(2).enumerate();
    let widest = gaps
        .filter(|(_, pair)| pair[0] <= first)
        .max_by(|(_, a), (_, b)| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
    match widest {
        Some((place, pair)) => ((pair[0] * pair[1]).sqrt(), place + 1),
        None => (first, 1),
    }
}
