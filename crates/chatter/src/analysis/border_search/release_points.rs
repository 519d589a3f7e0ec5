//! All release points at one parameter value.

use crate::analysis::border::{BorderError, Here, Lack, NO_HORIZON, ReleasePoint};
use crate::analysis::periodic::closure::Turn;
use crate::flow::{FlowError, Occurrence};

/// How many steps of a trajectory are looked through for places near a release.
const SEED_STEPS: usize = 4000;

/// How many of its states serve as first guesses.
const SEEDS: usize = 100;

/// The forcing period is looked through at so many phases: a shorter lift of the acceleration above zero may be missed.
const PHASES: usize = 256;

/// Release points this near to each other, relative to their size, are one.
const SAME: f64 = 1e-7;
/// The same of those that orbits return to: they are closed less well where chatter ends in flight.
const SAME_ORBIT: f64 = 1e-3;

impl Here<'_, f64> {
    /// All release points: at least one.
    pub(super) fn release_points(&self) -> Result<Vec<ReleasePoint<f64>>, BorderError> {
        let (mut found, mut failure) = (Vec::new(), None);
        for contact in 0..self.problem.releases.len() {
            let (points, failed) = match self.problem.dimensions() {
                0 => self.all(contact),
                _ => self.settled(contact)?,
            };
            found.extend(points);
            failure = failure.or(failed);
        }
        match failure {
            // Where the motion ends there may be more, which it has not come to.
            Some(error) if found.is_empty() => Err(self.lacks(Lack::Motion(error))),
            _ if found.is_empty() => Err(self.lacks(Lack::Release)),
            _ => Ok(found),
        }
    }

    /// The release points of a contact in a period of the forcing, from the initial phase on; without forcing those that are
    /// found from the initial state and along a trajectory, in this order. Also why that trajectory ends, if it does.
    fn all(&self, contact: usize) -> (Vec<ReleasePoint<f64>>, Option<FlowError>) {
        let initial = self.problem.model.initial_state(&self.parameters);
        let forcing = self.phases.first();
        let held = forcing.map(|phase| self.along_contact(contact, &initial, phase));
        let mut guesses = held.unwrap_or_default();
        guesses.push(initial.clone());
        let (along, failure) = self.along_trajectory(&initial);
        guesses.extend(along);
        let mut found: Vec<ReleasePoint<f64>> = Vec::new();
        for guess in &guesses {
            let point = self.solve(contact, guess);
            found.extend(point.filter(|point| self.is_new(point, &found)));
        }
        if let Some(phase) = forcing {
            found.sort_by(|a, b| a.state[phase.state].total_cmp(&b.state[phase.state]));
        }
        (found, failure)
    }

    /// Whether a release point is none of these.
    pub(super) fn is_new<'k>(
        &self,
        point: &ReleasePoint<f64>,
        known: impl IntoIterator<Item = &'k ReleasePoint<f64>>,
    ) -> bool {
        let same = if point.free.is_empty() {
            SAME
        } else {
            SAME_ORBIT
        };
        known.into_iter().all(|known| {
            known.contact != point.contact || self.apart(&known.state, &point.state).1 > same
        })
    }

    /// Just beyond where the acceleration of a state held in contact rises through zero over a period.
    fn along_contact(&self, contact: usize, initial: &[f64], phase: &Turn<f64>) -> Vec<Vec<f64>> {
        let equations = &self.problem.releases[contact];
        let mut near = initial.to_vec();
        let held = (0..=PHASES).filter_map(|part| {
            let turned = phase.period * (part as f64 / PHASES as f64);
            near[phase.state] = initial[phase.state] + turned;
            near = (equations.converge(&self.parameters, &near, &[phase.state])?).at;
            Some((
                near.clone(),
                equations.acceleration(&near, &self.parameters),
            ))
        });
        let held: Vec<(Vec<f64>, f64)> = held.collect();
        let rises = |pair: &&[(Vec<f64>, f64)]| pair[0].1 < 0.0 && pair[1].1 >= 0.0;
        let beyond = held.windows(2).filter(rises);
        beyond.map(|pair| pair[1].0.clone()).collect()
    }

    /// States along the trajectory from the initial state, the last one at a release if there is one; and why it ends, if it does.
    fn along_trajectory(&self, initial: &[f64]) -> (Vec<Vec<f64>>, Option<FlowError>) {
        let system = &self.problem.plain.system;
        let mut seeds = Vec::new();
        let (mut work, mut trajectory) = match system.trajectory_from(&self.parameters, initial) {
            Ok(started) => started,
            Err(error) => return (seeds, Some(error)),
        };
        for _ in 0..SEED_STEPS {
            match trajectory.advance(system, &mut work, NO_HORIZON) {
                Ok(Some(Occurrence::Release { .. })) => {
                    seeds.push(trajectory.state().to_vec());
                    break;
                }
                Ok(_) if seeds.len() < SEEDS => seeds.push(trajectory.state().to_vec()),
                Ok(_) => {}
                Err(error) => return (seeds, Some(error)),
            }
        }
        (seeds, None)
    }
}
