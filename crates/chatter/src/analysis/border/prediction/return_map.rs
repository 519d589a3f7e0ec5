//! The system's own return map from first impact to first impact, and its fixed points by Newton's method.

use super::super::coordinate::sequence::Until;
use super::super::normal_form::exact::SectionChart;
use super::simulated::Simulator;
use crate::flow::with_identity;
use crate::numerics::linear::solve;

/// What the map found for one loop.
struct Loop {
    image: [f64; 2],
    /// Derivatives by the two coordinates and the parameter.
    slopes: [[f64; 3]; 2],
    rate: f64,
    rate_slopes: [f64; 3],
}

impl Loop {
    /// Derivatives of image - point, and one more row.
    fn fixed_point_rows(&self, last: Vec<f64>) -> Vec<Vec<f64>> {
        let mut rows: Vec<Vec<f64>> = self.slopes.iter().map(|s| s.to_vec()).collect();
        rows[0][0] -= 1.0;
        rows[1][1] -= 1.0;
        rows.push(last);
        rows
    }
}

/// A fixed point of the return map.
#[derive(Clone, Copy)]
pub(in crate::analysis::border) struct FixedPoint {
    /// Two coordinates and the parameter.
    pub at: [f64; 3],
    /// After the last impact.
    pub rate: f64,
    /// Of the derivative of the map: sum and product of its two multipliers, be they real or a complex pair.
    pub trace: f64,
    pub determinant: f64,
    /// d at / d rate.
    pub direction: [f64; 3],
    /// Of the parameter.
    pub error: f64,
}

impl FixedPoint {
    /// By how much a multiplier m exceeds a `target` of 1 or -1: (m - target) (1 - target n) with the other one, n, which is
    /// next to nothing near a border orbit. Zero just where a multiplier is that; a complex pair has none, though its real
    /// part may pass the target.
    pub fn excess(&self, target: f64) -> f64 {
        self.trace - target * (1.0 + self.determinant)
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
/// However near to the border orbit, no more of a correction is let pass.
const VAGUE: f64 = 1e-6;

/// The return map of the system near its border orbit.
#[derive(Clone, Copy)]
pub(in crate::analysis::border) struct ReturnMap<'a> {
    pub simulator: &'a Simulator,
    pub border: f64,
    /// The state after the first impact of the border orbit.
    pub origin: &'a [f64],
    /// The two coordinates, and the state that follows from them.
    pub free: [usize; 2],
    pub bound: usize,
    /// In a loop.
    pub impacts: usize,
}

impl ReturnMap<'_> {
    /// By how much a component of the state grows in a loop beyond what it was, and the derivative of that by the
    /// parameter: zero but for phases.
    fn turn(&self, parameters: &[f64], component: usize) -> (f64, f64) {
        let turns = self.simulator.problem.release.turns(parameters);
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
    fn follow(&self, at: [f64; 3]) -> Option<Loop> {
        let problem = &self.simulator.problem;
        let parameters = problem.parameters(at[2]);
        let mut state = self.origin.to_vec();
        state[self.free[0]] = at[0];
        state[self.free[1]] = at[1];
        let state = (problem.release).onto_surface(&parameters, &state, self.bound)?;
        let chart = SectionChart::with_bound(problem, &parameters, &state, self.bound);
        let start = with_identity(&state, state.len() + 1);
        let count = self.impacts;
        let sequence = problem
            .variational
            .follow(&parameters, &start, Until::Count(count))
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
        let turns = self.free.map(|i| self.turn(&parameters, i));
        let weights: Vec<Vec<f64>> = (0..3).map(|along| chart.weights(along)).collect();
        let image = |k: usize| impacts[count - 1].state[self.free[k]] - turns[k].0;
        let slope = |k: usize, along: usize| {
            let sum: f64 = (next.slopes.iter().zip(&weights[along]))
                .map(|(slope, weight)| slope.state[self.free[k]] * weight)
                .sum();
            if along == 2 { sum - turns[k].1 } else { sum }
        };
        let row = |k: usize| [slope(k, 0), slope(k, 1), slope(k, 2)];
        let rate_slope = |along: usize| {
            (last.slopes.iter().zip(&weights[along]))
                .map(|(slope, weight)| slope.rate * weight)
                .sum()
        };
        Some(Loop {
            image: [image(0), image(1)],
            slopes: [row(0), row(1)],
            rate: last.rate,
            rate_slopes: [rate_slope(0), rate_slope(1), rate_slope(2)],
        })
    }

    /// The fixed point at this rate after the last impact, or at the guess's own parameter if none is given.
    pub fn solve(&self, guess: [f64; 3], rate: Option<f64>) -> Option<FixedPoint> {
        let mut at = guess;
        let mut found = self.follow(at)?;
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let (last, off) = match rate {
                Some(rate) => (found.rate_slopes.to_vec(), rate - found.rate),
                None => (vec![0.0, 0.0, 1.0], guess[2] - at[2]),
            };
            let right = [at[0] - found.image[0], at[1] - found.image[1], off];
            let step = solve(&found.fixed_point_rows(last), &right)?;
            let origin = [
                self.origin[self.free[0]],
                self.origin[self.free[1]],
                self.border,
            ];
            let largest = |values: [f64; 3]| {
                let parts = [0, 1, 2].map(|i| (values[i] / (at[i] - origin[i])).abs());
                parts[0].max(parts[1]).max(parts[2])
            };
            let size = largest([step[0], step[1], step[2]]);
            let done = NEWTON_DONE
                .max(ROUNDOFFS * f64::EPSILON * largest(at))
                .min(VAGUE);
            let mut part = 1.0;
            let mut moved = None;
            for _ in 0..STEP_HALVINGS {
                let trial = [0, 1, 2].map(|i| at[i] + part * step[i]);
                if let Some(good) = self.follow(trial) {
                    moved = Some((trial, good));
                    break;
                }
                part *= 0.5;
            }
            (at, found) = moved?;
            if size <= done || (size <= STALLED * done && size >= before) {
                let [[a, b, _], [c, d, _]] = found.slopes;
                let direction = solve(
                    &found.fixed_point_rows(found.rate_slopes.to_vec()),
                    &[0.0, 0.0, 1.0],
                )?;
                return Some(FixedPoint {
                    at,
                    rate: found.rate,
                    trace: a + d,
                    determinant: a * d - b * c,
                    direction: [direction[0], direction[1], direction[2]],
                    error: size.max(done) * (at[2] - self.border).abs(),
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
            at: [0.0; 3],
            rate: 1.0,
            trace,
            determinant,
            direction: [0.0; 3],
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
