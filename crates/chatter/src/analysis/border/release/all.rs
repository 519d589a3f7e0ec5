//! All release points at one parameter value.

use super::super::coordinate::sequence::NO_HORIZON;
use super::equations::{ReleaseEquations, ReleasePoint};
use super::forcing::Turn;
use crate::flow::{Occurrence, Settings, System, Trajectory};
use crate::model::Model;
use crate::numerics::root_between;

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
        self.apart(&a.state, &b.state, parameters) <= same
    }

    /// Where the acceleration of a state held in contact rises through zero over a period.
    fn along_contact(
        &self,
        parameters: &[f64],
        initial: &[f64],
        turn: &Turn<f64>,
    ) -> Vec<Vec<f64>> {
        let held_at = |near: &[f64], phase: f64| {
            let mut guess = near.to_vec();
            guess[turn.state] = phase;
            let state = self.converge(parameters, &guess, &[turn.state])?.at;
            let acceleration = self.acceleration(&state, parameters);
            Some((state, acceleration))
        };
        let mut near = initial.to_vec();
        let mut before: Option<(Vec<f64>, f64)> = None;
        let mut rises = Vec::new();
        for part in 0..=PHASES {
            let phase = initial[turn.state] + turn.period * (part as f64 / PHASES as f64);
            let held = held_at(&near, phase);
            if let (Some((low, falls)), Some((high, rising))) = (&before, &held)
                && *falls < 0.0
                && *rising >= 0.0
            {
                let acceleration = |phase| held_at(low, phase).map_or(f64::NAN, |(_, a)| a);
                let rise = root_between(acceleration, low[turn.state], phase);
                let there = rise.and_then(|phase| held_at(low, phase));
                rises.push(there.map_or_else(|| high.clone(), |(state, _)| state));
            }
            if let Some((state, _)) = &held {
                near.clone_from(state);
            }
            before = held;
        }
        rises
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
