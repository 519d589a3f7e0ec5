//! Release points of models with more than three states: those to which the orbit returns, by iteration and Newton's method.
//!
//! With n states release points fill a surface of n - 3 dimensions. What leads from one to the next is smooth where chatter is
//! complete. Where it ends in flight, contact from its last impact on that presses leads to a point that is as near to
//! the orbit's as nu^3 there, and continues the complete side smoothly to the border.

use super::super::coordinate::sequence::Until;
use super::super::error::{BorderError, Lack};
use super::super::problem::Problem;
use super::equations::{Place, ReleaseEquations, ReleasePoint};
use crate::numerics::{Matrix, moved};

/// A trajectory passes so many chatter sequences before its release points are looked at, and then so many.
const TRANSIENT: usize = 12;
const LOOKED_AT: usize = 3;

/// Loops that close an orbit, at most; the first ones, which are followed as they come; and what one gains that is as good as
/// Newton's step.
const LOOPS: usize = 24;
const PLAIN: usize = 3;
const GAIN: f64 = 0.05;

/// The orbit is closed if its release point returns to itself to this, relative to its size. Sequences that end in flight jump as
/// they lose impacts: there it need not be nearer than this.
const CLOSED: f64 = 1e-10;
const NEARLY: f64 = 1e-2;

/// Orbits are not alone where less than this of a change of their release point does not return: differences show no less.
const ALONE: f64 = 1e-4;

/// Differences are taken over this, relative to the size of a state.
const DIFFERENCE: f64 = 1e-6;

impl Problem {
    /// The release point near one that is known; where it has coordinates, the one that its orbit returns to.
    pub(crate) fn returning(
        &self,
        value: f64,
        near: &Place,
    ) -> Result<ReleasePoint<f64>, BorderError> {
        let point = self.release_point(value, near)?;
        match self.dimensions() {
            0 => Ok(point),
            _ => (self.closed(value, point)).ok_or_else(|| Lack::Release.at(value)),
        }
    }

    /// Release points of the orbits that trajectories settle to: from the initial state, and from the release point near it.
    pub(crate) fn settled(
        &self,
        value: f64,
        release: &ReleaseEquations,
    ) -> Result<Vec<ReleasePoint<f64>>, BorderError> {
        let parameters = self.parameters(value);
        let initial = self.model.initial_state(&parameters);
        let first = self.next(value, (release.contact, &initial));
        let starts = [first, release.solve(&parameters, &initial)];
        let mut found: Vec<ReleasePoint<f64>> = Vec::new();
        for start in starts.into_iter().flatten() {
            let on = |point: &ReleasePoint<f64>| self.next(value, (point.contact, &point.state));
            let orbit = core::iter::successors(Some(start), on);
            for point in orbit.skip(TRANSIENT).take(LOOKED_AT) {
                let Some(point) = self.closed(value, point) else {
                    continue;
                };
                let is_known = |known| release.is_same(known, &point, &parameters);
                if found.iter().any(is_known) {
                    continue;
                }
                if !self.is_alone(value, &point) {
                    return Err(Lack::Alone.at(value));
                }
                found.push(point);
            }
        }
        Ok(found)
    }

    /// The release point after the first chatter sequence from a state.
    fn next(&self, value: f64, (contact, state): (usize, &[f64])) -> Option<ReleasePoint<f64>> {
        let parameters = self.parameters(value);
        let first = Until {
            after: 0,
            ..Until::NEVER
        };
        let sequence = (self.plain.follow(&parameters, (contact, state), first)).ok()?;
        let released = self.released(&sequence, &parameters, contact)?;
        self.releases[contact].solve(&parameters, &released)
    }

    /// How far the coordinates of a release point are from those after a loop.
    fn missed(&self, value: f64, point: &ReleasePoint<f64>) -> Option<(Vec<f64>, f64)> {
        let next = self.next(value, (point.contact, &point.state))?;
        let equations = &self.releases[point.contact];
        let parameters = self.parameters(value);
        let (off, _) = equations.apart(&point.state, &next.state, &parameters);
        let free = || point.free.iter().copied();
        let size = free().map(|i| off[i].abs() / (1.0 + point.state[i].abs()));
        Some((free().map(|i| off[i]).collect(), size.fold(0.0, f64::max)))
    }

    /// The release point, near this one, that its orbit returns to.
    fn closed(&self, value: f64, start: ReleasePoint<f64>) -> Option<ReleasePoint<f64>> {
        let parameters = self.parameters(value);
        let equations = &self.releases[start.contact];
        let beside = |point: &ReleasePoint<f64>, by: &[f64]| {
            equations.solve(&parameters, &moved(&point.state, &point.along(by), 1.0))
        };
        let mut here = start;
        let (mut missed, mut size) = self.missed(value, &here)?;
        let mut best = (size, here.clone());
        let mut before = f64::INFINITY;
        for count in 0..LOOPS {
            if size <= CLOSED {
                return Some(here);
            }
            let step = if count < PLAIN || size <= GAIN * before {
                Some(missed.clone())
            } else {
                let rows = self.not_returned(value, &here);
                (rows.and_then(|rows| rows.factored())).map(|factors| factors.solve(&missed))
            };
            let next = step.and_then(|step| beside(&here, &step));
            before = size;
            here = next?;
            (missed, size) = self.missed(value, &here)?;
            if size < best.0 {
                best = (size, here.clone());
            }
        }
        (best.0 <= NEARLY).then_some(best.1)
    }

    /// Whether no other orbit near this one returns, too.
    fn is_alone(&self, value: f64, point: &ReleasePoint<f64>) -> bool {
        let Some(rows) = self.not_returned(value, point) else {
            return true;
        };
        let small = |column: Vec<f64>| column.iter().all(|x| x.abs() * ALONE <= 1.0);
        (rows.factored()).is_some_and(|factors| factors.inverse().all(small))
    }

    /// Of changes of the coordinates what does not return after a loop, by differences: a row for each coordinate.
    fn not_returned(&self, value: f64, point: &ReleasePoint<f64>) -> Option<Matrix<f64>> {
        let parameters = self.parameters(value);
        let equations = &self.releases[point.contact];
        let size = point.free.len();
        let mut rows = Matrix::zeros(size, size);
        for (column, (&i, direction)) in point.free.iter().zip(&point.directions).enumerate() {
            let step = DIFFERENCE * (1.0 + point.state[i].abs());
            let missed = |by: f64| {
                let there = equations.solve(&parameters, &moved(&point.state, direction, by))?;
                Some(self.missed(value, &there)?.0)
            };
            for (row, (a, b)) in missed(step)?.into_iter().zip(missed(-step)?).enumerate() {
                rows[(row, column)] = (b - a) / (2.0 * step);
            }
        }
        Some(rows)
    }
}
