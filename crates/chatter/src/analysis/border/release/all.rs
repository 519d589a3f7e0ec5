//! All release points at one parameter value.

use super::super::coordinate::sequence::NO_HORIZON;
use super::equations::{ReleaseEquations, ReleasePoint};
use super::forcing::Turn;
use crate::flow::{Occurrence, Settings, System, Trajectory};
use crate::model::Model;

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

impl ReleaseEquations {
    /// The release points in a period of the forcing, from the initial phase on; without forcing those that are found from
    /// the initial state and along a trajectory, in this order.
    pub(crate) fn all(
        &self,
        model: &Model,
        system: &System,
        parameters: &[f64],
    ) -> Vec<ReleasePoint<f64>> {
        let initial = model.initial_state(parameters);
        let start = model.time.map_or(0.0, |index| initial[index]);
        let turn = self.turns(parameters).first().copied();
        let mut guesses = turn.map_or_else(Vec::new, |turn| {
            self.along_contact(parameters, &initial, &turn)
        });
        guesses.push(initial.clone());
        guesses.extend(along_trajectory(system, parameters, &initial, start));
        let mut found: Vec<ReleasePoint<f64>> = Vec::new();
        for guess in &guesses {
            let point = self.solve(parameters, guess);
            let is_new = |point: &ReleasePoint<f64>| {
                !(found.iter()).any(|known| self.is_same(known, point, parameters))
            };
            found.extend(point.filter(is_new));
        }
        if let Some(turn) = turn {
            let phase = |point: &ReleasePoint<f64>| point.state[turn.state];
            found.sort_by(|a, b| phase(a).total_cmp(&phase(b)));
        }
        found
    }

    /// Whether two release points are one.
    pub(crate) fn is_same(
        &self,
        a: &ReleasePoint<f64>,
        b: &ReleasePoint<f64>,
        parameters: &[f64],
    ) -> bool {
        let same = if a.free.is_empty() { SAME } else { SAME_ORBIT };
        self.apart(&a.state, &b.state, parameters).1 <= same
    }

    /// Just beyond where the acceleration of a state held in contact rises through zero over a period.
    fn along_contact(
        &self,
        parameters: &[f64],
        initial: &[f64],
        turn: &Turn<f64>,
    ) -> Vec<Vec<f64>> {
        let mut near = initial.to_vec();
        let held = (0..=PHASES).filter_map(|part| {
            let phase = turn.period * (part as f64 / PHASES as f64);
            near[turn.state] = initial[turn.state] + phase;
            near = self.converge(parameters, &near, &[turn.state])?.at;
            Some((near.clone(), self.acceleration(&near, parameters)))
        });
        let held: Vec<(Vec<f64>, f64)> = held.collect();
        let rises = |pair: &&[(Vec<f64>, f64)]| pair[0].1 < 0.0 && pair[1].1 >= 0.0;
        let beyond = held.windows(2).filter(rises);
        beyond.map(|pair| pair[1].0.clone()).collect()
    }
}

/// States along the trajectory from the initial state, the last one at a release if there is one; none if it cannot start
/// there.
fn along_trajectory(
    system: &System,
    parameters: &[f64],
    initial: &[f64],
    start: f64,
) -> Vec<Vec<f64>> {
    let mut seeds = Vec::new();
    let mut work = system.workspace::<f64>(&Settings::default());
    let Ok(mut trajectory) = Trajectory::start(system, &mut work, parameters, start, initial)
    else {
        return seeds;
    };
    for _ in 0..SEED_STEPS {
        match trajectory.advance(system, &mut work, NO_HORIZON) {
            Ok(Some(Occurrence::Release { .. })) => {
                seeds.push(trajectory.state().to_vec());
                break;
            }
            Ok(_) if seeds.len() < SEEDS => seeds.push(trajectory.state().to_vec()),
            Ok(_) => {}
            Err(_) => break,
        }
    }
    seeds
}
