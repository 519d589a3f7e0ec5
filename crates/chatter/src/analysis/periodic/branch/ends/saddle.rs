//! Where a branch ends since its orbit comes to an equilibrium: the time beside that grows without bound, as the logarithm of how far away
//! the orbit passes it.

use super::unbounded::Unbounded;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::Settings;
use crate::flow::leg::{Jump, LegKind};
use crate::numerics::eigenvalues;
use crate::numerics::stored::{list, number};
use core::fmt;
use serde::{Deserialize, Serialize};

/// An equilibrium that orbits come to, the longer the nearer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saddle {
    /// The names of the states that it is an equilibrium of: those that something depends on.
    pub names: Vec<String>,
    /// Their values.
    #[serde(with = "list")]
    pub state: Vec<f64>,
    /// How fast the motion leaves it: what is beside it grows as exp(rate t).
    #[serde(with = "number")]
    pub rate: f64,
    /// How near the last orbit passes it, against the size of its states.
    #[serde(with = "number")]
    pub distance: f64,
    /// The period of the last orbit.
    #[serde(with = "number")]
    pub period: f64,
    /// How the period grows, where enough orbits are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unbounded: Option<Box<Unbounded>>,
}

impl fmt::Display for Saddle {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "the period, {:.6} here, grows without bound: at {:.1e} of its size the orbit passes a saddle at ",
            self.period, self.distance
        )?;
        for (index, (name, value)) in self.names.iter().zip(&self.state).enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            write!(out, "{comma}{name} = {value:.6}")?;
        }
        write!(out, ", which it leaves at the rate {:.6}", self.rate)?;
        match self.unbounded.as_deref() {
            Some(Unbounded {
                name, value, error, ..
            }) => write!(out, "; {name} comes to {value} (error {error:.0e})"),
            None => Ok(()),
        }
    }
}

/// An orbit this near to an equilibrium, against its size, is on its way there.
const NEAR: f64 = 1e-3;
/// A leg is looked at in so many places: beside an equilibrium it spends most of its time.
const PLACES: usize = 64;
/// What rests goes no farther than this part of its size in a period, for this part of it.
const RESTS: f64 = 0.1;
/// A state of the equilibrium that is less than this part of its size is zero.
const NOTHING: f64 = 1e-12;

impl Shooting<f64> {
    /// The saddle that an orbit nearly comes to on one of its flights.
    pub(in crate::analysis::periodic::branch) fn saddle(&mut self, at: &[f64]) -> Option<Saddle> {
        (0..self.steps.len()).find_map(|index| self.saddle_beside(at, index))
    }

    /// States that are passed on a flight by itself, at even times.
    fn way(&self, at: &[f64], index: usize, parameters: &[f64]) -> Option<Vec<Vec<f64>>> {
        let flight = self.workshop.leg(LegKind {
            ends_at: None,
            jump: Jump::None,
            ..self.steps[index].flight()?
        })?;
        let duration = at[self.duration_place(index)?];
        let mut flyer = flight.flyer(&Settings::default());
        let start = self.node(at, index);
        let passed = (1..PLACES).filter_map(|k| {
            let time = duration * k as f64 / PLACES as f64;
            let landing = flight.fly(&mut flyer, parameters, start, time).ok()?;
            Some(landing.image)
        });
        Some(passed.collect())
    }

    /// Whether an orbit all but rests for a while, as far as its flights are known: for a tenth of its period it would go no farther in a
    /// whole one than a tenth of its size. On a canard, along which the parameter stands still just so, motion is slow and goes on.
    pub(in crate::analysis::periodic::branch) fn all_but_rests(&self, at: &[f64]) -> bool {
        let (sizes, period) = (self.state_sizes(), self.period());
        let mut passed = Vec::new();
        for index in 0..self.steps.len() {
            let Some(equilibria) = self.equilibria(at, index) else {
                return true;
            };
            let Some(way) = self.way(at, index, &equilibria.parameters) else {
                return true;
            };
            let Some(place) = self.duration_place(index) else {
                return true;
            };
            let time = at[place] / way.len() as f64;
            passed.extend(
                way.iter()
                    .map(|state| (equilibria.speed(state, &sizes), time)),
            );
        }
        passed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = RESTS * period;
        let slow = passed.iter().find(|(_, time)| {
            left -= time;
            left <= 0.0
        });
        slow.is_none_or(|(speed, _)| speed * period <= RESTS)
    }

    fn saddle_beside(&mut self, at: &[f64], index: usize) -> Option<Saddle> {
        let workshop = self.workshop.clone();
        let equilibria = self.equilibria(at, index)?;
        let (sizes, period) = (self.state_sizes(), self.period());
        let parameters = &equilibria.parameters;
        let way = self.way(at, index, parameters)?.into_iter();
        let slower = |a: &Vec<f64>, b: &Vec<f64>| {
            let speed = |state: &[f64]| equilibria.speed(state, &sizes);
            speed(a).total_cmp(&speed(b))
        };
        let slowest = way.min_by(slower)?;
        let found = equilibria.near(&slowest, &sizes)?;
        let distance = (found.state.iter().zip(&slowest).zip(&sizes))
            .fold(0.0_f64, |most, ((x, y), size)| {
                most.max((x - y).abs() / size)
            });
        let rates = eigenvalues(&found.slopes);
        let rate = rates
            .iter()
            .fold(f64::NEG_INFINITY, |most, rate| most.max(rate.re));
        let is_saddle = rate > 0.0 && rates.iter().any(|rate| rate.re < 0.0);
        // Beside a saddle time goes as the logarithm of the distance; an orbit that shrinks to it does so in a time of its own.
        let stays = rate * period >= -libm::log(distance);
        let states = &equilibria.states;
        (is_saddle && stays && distance <= NEAR).then(|| Saddle {
            names: states
                .iter()
                .map(|&state| workshop.model.states[state].name.clone())
                .collect(),
            state: states
                .iter()
                .map(|&state| {
                    let x = found.state[state];
                    if x.abs() <= NOTHING * sizes[state] {
                        0.0
                    } else {
                        x
                    }
                })
                .collect(),
            rate,
            distance,
            period,
            unbounded: None,
        })
    }
}
