//! The system's own return map from first impact to first impact, and its fixed points by Newton's method.

use super::super::coordinate::local::Slopes;
use super::super::coordinate::sequence::Until;
use super::super::normal_form::exact::SectionChart;
use super::simulated::Simulator;
use crate::flow::with_identity;
use crate::numerics::Matrix;
use crate::numerics::linear::solve;

/// What the map found for one loop.
struct Loop {
    /// The coordinates after it.
    image: Vec<f64>,
    /// Derivatives by the coordinates and the parameter.
    slopes: Vec<Vec<f64>>,
    rate: f64,
    rate_slopes: Vec<f64>,
}

impl Loop {
    /// Derivatives of image - point, and one more row.
    fn fixed_point_rows(&self, last: Vec<f64>) -> Vec<Vec<f64>> {
        let mut rows = self.slopes.clone();
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] -= 1.0;
        }
        rows.push(last);
        rows
    }
}

/// A fixed point of the return map.
#[derive(Clone)]
pub(in crate::analysis::border) struct FixedPoint {
    /// The coordinates and the parameter.
    pub at: Vec<f64>,
    /// After the last impact.
    pub rate: f64,
    /// Derivative of the map, by the coordinates.
    pub slopes: Vec<Vec<f64>>,
    /// d at / d rate.
    pub direction: Vec<f64>,
    /// Of the parameter.
    pub error: f64,
}

impl FixedPoint {
    /// The parameter.
    pub fn parameter(&self) -> f64 {
        self.at[self.at.len() - 1]
    }

    /// By how much a multiplier m exceeds a `target` of 1 or -1: -target det(1 - target J), which is (m - target) times
    /// 1 - target n for each other one, n, next to nothing near a border orbit but for what is remembered. Zero just where a
    /// multiplier is that; a complex pair has none, though its real part may pass the target.
    pub fn excess(&self, target: f64) -> f64 {
        let mut rows = Matrix::from_rows(&self.slopes);
        for i in 0..self.slopes.len() {
            let row = rows.row_mut(i);
            row.iter_mut().for_each(|entry| *entry *= -target);
            row[i] += 1.0;
        }
        -target * rows.factored().map_or(0.0, |factors| factors.determinant())
    }

    /// On which side of 0 multipliers lie.
    pub fn trace(&self) -> f64 {
        self.slopes.iter().enumerate().map(|(i, row)| row[i]).sum()
    }
}

const NEWTON_STEPS: usize = 40;
/// A Newton step is halved so often while it leaves the orbits with this number of impacts.
const STEP_HALVINGS: usize = 12;
/// A correction is none below this, relative to the distance from the border orbit, or below so many roundoffs of the
/// coordinates; where it no longer shrinks it may be this much larger.
const NEWTON_DONE: f64 = 1e-11;
const ROUNDOFFS: f64 = 16.0;
const STALLED: f64 = 1e3;
/// What hardly leaves the border orbit is measured by this part of what does.
const LEAST_OFF: f64 = 1e-6;
/// However near to the border orbit, no more of a correction is let pass.
const VAGUE: f64 = 1e-6;

/// The return map of the system near its border orbit.
#[derive(Clone)]
pub(in crate::analysis::border) struct ReturnMap<'a> {
    pub simulator: &'a Simulator,
    pub border: f64,
    /// The state after the first impact of the border orbit.
    pub origin: &'a [f64],
    /// The coordinates, and the state that follows from them.
    pub free: Vec<usize>,
    pub bound: usize,
    /// In a loop.
    pub impacts: usize,
}

impl ReturnMap<'_> {
    /// By how much a component of the state grows in a loop beyond what it was, and the derivative of that by the
    /// parameter: zero but for phases.
    fn turn(&self, parameters: &[f64], component: usize) -> (f64, f64) {
        let turns = self.simulator.equations().turns(parameters);
        let count = (self.simulator.turns.iter()).find(|(state, _)| *state == component);
        match (turns.iter().find(|turn| turn.state == component), count) {
            (Some(turn), Some(&(_, count))) => {
                let count = count as f64;
                (turn.period * count, turn.period_slope * count)
            }
            _ => (0.0, 0.0),
        }
    }

    /// One loop from a first impact to the next; `None` if it has another number of impacts.
    fn follow(&self, at: &[f64]) -> Option<Loop> {
        let (problem, equations) = (&self.simulator.problem, self.simulator.equations());
        let contact = equations.contact;
        let coordinates = self.free.len();
        let parameters = problem.parameters(at[coordinates]);
        let mut state = self.origin.to_vec();
        for (&i, &x) in self.free.iter().zip(at) {
            state[i] = x;
        }
        let state = equations.onto_surface(&parameters, &state, self.bound)?;
        let chart = SectionChart::with_bound(problem, (contact, self.bound), &parameters, &state);
        let start = with_identity(&state, state.len() + 1);
        let count = self.impacts;
        let sequence = problem
            .variational
            .follow(&parameters, (contact, &start), Until::Count(count))
            .ok()?;
        let impacts = &sequence.impacts;
        let (long, count_long) = self.simulator.long_flight;
        let is_long: Vec<bool> = sequence.flights().map(|flight| flight >= long).collect();
        if impacts.len() != count
            || count < 2
            || is_long.last() != Some(&true)
            || is_long.iter().filter(|&&is_long| is_long).count() != count_long
        {
            return None;
        }
        let (last, next) = (&impacts[count - 2].local, &impacts[count - 1].local);
        let weights: Vec<Vec<f64>> = (0..=coordinates)
            .map(|along| chart.weights(along))
            .collect();
        let sum = |of: &dyn Fn(&Slopes<f64>) -> f64, slopes: &[Slopes<f64>], weights: &[f64]| {
            slopes
                .iter()
                .zip(weights)
                .map(|(slope, weight)| of(slope) * weight)
                .sum::<f64>()
        };
        let (mut image, mut slopes) = (Vec::new(), Vec::new());
        for &i in &self.free {
            let (turn, turn_slope) = self.turn(&parameters, i);
            image.push(impacts[count - 1].state[i] - turn);
            let along = |weights: &Vec<f64>| sum(&|slope| slope.state[i], &next.slopes, weights);
            let mut row: Vec<f64> = weights.iter().map(along).collect();
            row[coordinates] -= turn_slope;
            slopes.push(row);
        }
        let rate = |weights: &Vec<f64>| sum(&|slope| slope.rate, &last.slopes, weights);
        Some(Loop {
            image,
            slopes,
            rate: last.rate,
            rate_slopes: weights.iter().map(rate).collect(),
        })
    }

    /// The fixed point at this rate after the last impact, or at the guess's own parameter if none is given.
    pub fn solve(&self, guess: &[f64], rate: Option<f64>) -> Option<FixedPoint> {
        let last = self.free.len();
        let unit = |length: f64| {
            let mut unit = vec![0.0; last + 1];
            unit[last] = length;
            unit
        };
        let origin: Vec<f64> = (self.free.iter().map(|&i| self.origin[i]))
            .chain([self.border])
            .collect();
        let mut at = guess.to_vec();
        let mut found = self.follow(&at)?;
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let (row, off) = match rate {
                Some(rate) => (found.rate_slopes.clone(), rate - found.rate),
                None => (unit(1.0), guess[last] - at[last]),
            };
            let missed = at.iter().zip(&found.image).map(|(x, image)| x - image);
            let right: Vec<f64> = missed.chain([off]).collect();
            let step = solve(&found.fixed_point_rows(row), &right)?;
            let off = |i: usize| (at[i] - origin[i]).abs();
            let relative = (0..=last).map(|i| off(i) / (1.0 + origin[i].abs()));
            let least = LEAST_OFF * relative.fold(0.0, f64::max);
            let largest = |values: &[f64]| {
                let parts = values
                    .iter()
                    .enumerate()
                    .map(|(i, value)| value.abs() / off(i).max(least * (1.0 + origin[i].abs())));
                parts.fold(0.0, f64::max)
            };
            let size = largest(&step);
            let done = NEWTON_DONE
                .max(ROUNDOFFS * f64::EPSILON * largest(&at))
                .min(VAGUE);
            let mut part = 1.0;
            let mut moved = None;
            for _ in 0..STEP_HALVINGS {
                let trial: Vec<f64> = at.iter().zip(&step).map(|(x, dx)| x + part * dx).collect();
                if let Some(good) = self.follow(&trial) {
                    moved = Some((trial, good));
                    break;
                }
                part *= 0.5;
            }
            (at, found) = moved?;
            if size <= done || (size <= STALLED * done && size >= before) {
                let rows = found.fixed_point_rows(found.rate_slopes.clone());
                return Some(FixedPoint {
                    rate: found.rate,
                    slopes: found
                        .slopes
                        .iter()
                        .map(|row| row[..last].to_vec())
                        .collect(),
                    direction: solve(&rows, &unit(1.0))?,
                    error: size.max(done) * (at[last] - self.border).abs(),
                    at,
                });
            }
            before = size;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(trace: f64, determinant: f64) -> FixedPoint {
        FixedPoint {
            at: vec![0.0; 3],
            rate: 1.0,
            slopes: vec![vec![trace, -determinant], vec![1.0, 0.0]],
            direction: vec![0.0; 3],
            error: 0.0,
        }
    }

    #[test]
    fn a_complex_pair_never_is_one_or_minus_one() {
        for (m, n) in [(1.2, 0.3), (0.9, -0.2), (-1.1, 0.4), (-0.7, 1e-9)] {
            let point = with(m + n, m * n);
            for target in [1.0, -1.0] {
                let product = (m - target) * (1.0 - target * n);
                assert!((point.excess(target) - product).abs() < 1e-15, "{m} {n}");
            }
        }
        // 0.8 +- 0.7 i and 1.2 +- 0.7 i: the real part passes 1, no multiplier does; nor -1 on the other side.
        for half in [0.8, 1.0, 1.2] {
            let determinant = half * half + 0.49;
            assert!(with(2.0 * half, determinant).excess(1.0) < 0.0);
            assert!(with(-2.0 * half, determinant).excess(-1.0) > 0.0);
        }
    }
}
