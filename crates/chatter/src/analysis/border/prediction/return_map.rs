//! The system's own return map from first impact to first impact, and its fixed points by Newton's method.

use super::super::coordinate::sequence::Until;
use super::super::release::Turn;
use super::simulated::Simulator;
use crate::flow::with_identity;
use crate::numerics::{Equations, Linearised, Matrix, Newton, dot, unit};

/// One loop.
struct Loop {
    /// What a point is moved by, with derivatives by the coordinates and the parameter.
    moved: Linearised<f64>,
    /// After the last impact, with the same derivatives.
    rate: f64,
    rate_slopes: Vec<f64>,
}

/// A fixed point of the return map.
#[derive(Clone)]
pub(in crate::analysis::border) struct FixedPoint {
    /// The coordinates and the parameter.
    pub at: Vec<f64>,
    /// After the last impact.
    pub rate: f64,
    /// Derivative of the map, by the coordinates.
    pub slopes: Matrix<f64>,
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
        let mut rows = self.slopes.clone();
        for i in 0..rows.rows() {
            let row = rows.row_mut(i);
            row.iter_mut().for_each(|entry| *entry *= -target);
            row[i] += 1.0;
        }
        -target * rows.factored().map_or(0.0, |factors| factors.determinant())
    }

    /// On which side of 0 multipliers lie.
    pub fn trace(&self) -> f64 {
        (0..self.slopes.rows()).map(|i| self.slopes[(i, i)]).sum()
    }
}

/// A correction is none below this, relative to the distance from the border orbit, or below so many roundoffs of the
/// coordinates; where it no longer shrinks it may be this much larger.
const NEWTON_DONE: f64 = 1e-11;
const ROUNDOFFS: f64 = 16.0;
const STALLED: f64 = 1e3;
/// What hardly leaves the border orbit is measured by this part of what does.
const LEAST_OFF: f64 = 1e-6;
/// However near to the border orbit, no more of a correction is let pass.
const VAGUE: f64 = 1e-6;

/// Corrections are measured by what is none of one. A step is shortened while it leaves the orbits with this number of impacts.
const NEWTON: Newton = Newton {
    steps: 40,
    leap: f64::INFINITY,
    longest: f64::INFINITY,
    halvings: 11,
    done: 1.0,
    settled: STALLED,
    shrinks: 1.0,
    patience: usize::MAX,
};

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
        let weights = equations.on_surface(&state, &parameters, self.bound);
        let start = with_identity(&state, state.len() + 1);
        let count = self.impacts;
        let until = Until {
            impacts: count,
            ..Until::NEVER
        };
        let sequence = problem
            .variational
            .follow(&parameters, (contact, &start), until)
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
        let turns = self.simulator.turns(&parameters);
        let (mut off, mut slopes) = (Vec::new(), Matrix::zeros(0, coordinates + 1));
        for (k, &i) in self.free.iter().enumerate() {
            let [turned, turned_slope] = Turn::of(&turns, i);
            off.push(impacts[count - 1].state[i] - turned - at[k]);
            let by = next.state_slopes(i);
            let mut row: Vec<f64> = weights.iter().map(|along| dot(&by, along)).collect();
            row[coordinates] -= turned_slope;
            row[k] -= 1.0;
            slopes.push(&row);
        }
        Some(Loop {
            moved: Linearised {
                residual: off,
                jacobian: slopes,
            },
            rate: last.rate,
            rate_slopes: (weights.iter().map(|along| last.rates_along(along)[0])).collect(),
        })
    }

    /// A change of coordinates and parameter against the distance from the border orbit.
    fn against_distance(&self, at: &[f64], change: &[f64]) -> f64 {
        let origin = self.free.iter().map(|&i| self.origin[i]);
        let distance = |(x, o): (&f64, f64)| ((x - o).abs(), 1.0 + o.abs());
        let off: Vec<(f64, f64)> = (at.iter().zip(origin.chain([self.border])))
            .map(distance)
            .collect();
        let largest = (off.iter()).fold(0.0_f64, |most, (off, size)| most.max(off / size));
        let parts = change.iter().zip(off);
        let part =
            |(x, (off, size)): (&f64, (f64, f64))| x.abs() / off.max(LEAST_OFF * largest * size);
        parts.map(part).fold(0.0, f64::max)
    }

    /// A correction that is none.
    fn done(&self, at: &[f64]) -> f64 {
        let rounding = ROUNDOFFS * f64::EPSILON * self.against_distance(at, at);
        NEWTON_DONE.max(rounding).min(VAGUE)
    }

    /// The fixed point at this rate after the last impact, or at the guess's own parameter if none is given.
    pub fn solve(&self, guess: &[f64], rate: Option<f64>) -> Option<FixedPoint> {
        let last = self.free.len();
        let mut sought = Sought {
            map: self,
            rate,
            latest: None,
        };
        let found = NEWTON.solve(&mut sought, guess).ok()?;
        // The last correction is next to none: where it leaves the orbits, it is left out.
        let there = self.follow(&found.at).map(|here| (found.at.clone(), here));
        let (at, here) = there.or(sought.latest)?;
        let rows = here.moved.bordered([&*here.rate_slopes]).factored()?;
        let mut slopes = Matrix::identity(last);
        for i in 0..last {
            let row = slopes.row_mut(i).iter_mut();
            row.zip(here.moved.jacobian.row(i))
                .for_each(|(x, by)| *x += by);
        }
        let direction = rows.solve(&unit(last + 1, last));
        let error = found.correction.max(1.0) * self.done(&at) * (at[last] - self.border).abs();
        direction
            .iter()
            .all(|x| x.is_finite())
            .then_some(FixedPoint {
                rate: here.rate,
                slopes,
                direction,
                error,
                at,
            })
    }
}

/// The equations of a fixed point at a rate after the last impact, or at the parameter where it is.
struct Sought<'a> {
    map: &'a ReturnMap<'a>,
    rate: Option<f64>,
    latest: Option<(Vec<f64>, Loop)>,
}

impl Equations<f64> for Sought<'_> {
    type Left = ();

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, ()> {
        let here = self.map.follow(at).ok_or(())?;
        let (row, off) = match self.rate {
            Some(rate) => (here.rate_slopes.clone(), here.rate - rate),
            None => (unit(at.len(), at.len() - 1), 0.0),
        };
        let jacobian = here.moved.bordered([&*row]);
        let residual = [&*here.moved.residual, &[off]].concat();
        self.latest = Some((at.to_vec(), here));
        Ok(Linearised { residual, jacobian })
    }

    fn size(&self, at: &[f64], correction: &[f64]) -> f64 {
        self.map.against_distance(at, correction) / self.map.done(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(trace: f64, determinant: f64) -> FixedPoint {
        FixedPoint {
            at: vec![0.0; 3],
            rate: 1.0,
            slopes: Matrix::from_rows(&[vec![trace, -determinant], vec![1.0, 0.0]]),
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
