//! The system itself near a border orbit, passage by passage, beside the prediction.

use super::super::coordinate::sequence::{Until, Verdict};
use super::super::error::BorderError;
use super::super::orbit::Border;
use super::super::problem::Problem;
use super::super::release::equations::{Place, ReleaseEquations};
use super::super::spec::BorderSpec;
use super::map::{Settled, settle, to_f64};
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
    /// Where it settles.
    pub settled: Settled,
}

/// Impacts of the chatter sequence whose flights are looked at: they get shorter.
const FOLLOWED: usize = 8;

/// Two passages are the same if their states agree to this, relative to their size.
const SAME: f64 = 1e-9;

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
        let until = Until::Count(border.sequence_begins + FOLLOWED);
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
        let arrivals = (transient + keep) * self.long_flights + 1;
        let follower = &self.problem.plain;
        let start = (release.contact, &*release.state);
        let sequence = follower.follow(&parameters, start, Until::Arrivals(arrivals))?;
        if sequence.verdict != Verdict::Stopped {
            // Far from the border impacts may go on for ever without a long flight.
            let settled = match sequence.verdict {
                Verdict::Complete => Settled::Complete,
                _ => Settled::Unsettled,
            };
            let passages = Vec::new();
            return Ok(Simulated { passages, settled });
        }
        let mut passages: Vec<Passage> = Vec::new();
        let mut arrivals = 0;
        for impact in &sequence.impacts {
            if impact.arrives {
                if arrivals % self.long_flights == 0 {
                    passages.push(Passage {
                        state: impact.state.clone(),
                        impacts: 0,
                    });
                }
                arrivals += 1;
            }
            if let Some(passage) = passages.last_mut() {
                passage.impacts += 1;
            }
        }
        // The last one goes on.
        passages.pop();
        passages.drain(..transient.min(passages.len()));
        passages.truncate(keep);
        let scale: Vec<f64> = (0..release.slope.len())
            .map(|i| (passages.iter()).fold(0.0_f64, |most, p| most.max(p.state[i].abs())))
            .collect();
        let same = |a: &Passage, b: &Passage| {
            a.impacts == b.impacts
                && (0..scale.len())
                    .filter(|&i| !self.equations().is_phase(i))
                    .all(|i| (a.state[i] - b.state[i]).abs() <= SAME * scale[i])
        };
        let settled = settle(&passages, same, |passage| Some(passage.impacts));
        Ok(Simulated { passages, settled })
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
