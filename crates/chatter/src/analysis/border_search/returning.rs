//! Release points of models with more than three states: those to which the orbit returns, by iteration and Newton's method.
//!
//! With n states release points fill a surface of n - 3 dimensions. What leads from one to the next is smooth where chatter is
//! complete. Where it ends in flight, contact from its last impact on that presses leads to a point that is as near to
//! the orbit's as nu^3 there, and continues the complete side smoothly to the border.

use crate::analysis::border::{BorderError, Here, Lack, Place, ReleasePoint, Until, regular};
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

impl Here<'_, f64> {
    /// The release point near one that is known; where it has coordinates, the one that its orbit returns to.
    pub(crate) fn returning(&self, near: &Place) -> Result<ReleasePoint<f64>, BorderError> {
        let closed = self.closed(self.release(near)?);
        closed.ok_or_else(|| self.lacks(Lack::Release))
    }

    /// Release points of the orbits that trajectories settle to: from the initial state, and from the release point near it.
    pub(crate) fn settled(&self, contact: usize) -> Result<Vec<ReleasePoint<f64>>, BorderError> {
        let initial = self.problem.model.initial_state(&self.parameters);
        let starts = [self.next(contact, &initial), self.solve(contact, &initial)];
        let mut found: Vec<ReleasePoint<f64>> = Vec::new();
        for start in starts.into_iter().flatten() {
            let on = |point: &ReleasePoint<f64>| self.next(contact, &point.state);
            let orbit = core::iter::successors(Some(start), on);
            for point in orbit.skip(TRANSIENT).take(LOOKED_AT) {
                let Some(point) = self
                    .closed(point)
                    .filter(|point| self.is_new(point, &found))
                else {
                    continue;
                };
                if !self.is_alone(&point) {
                    return Err(self.lacks(Lack::Alone));
                }
                found.push(point);
            }
        }
        Ok(found)
    }

    /// The release point after the first chatter sequence from a state.
    fn next(&self, contact: usize, state: &[f64]) -> Option<ReleasePoint<f64>> {
        let first = Until {
            after: 0,
            ..Until::NEVER
        };
        let sequence = self.follow((contact, state), first).ok()?;
        self.solve(contact, &self.released(&sequence, contact)?)
    }

    /// A release point beside one: its coordinates changed by so much.
    fn beside(&self, point: &ReleasePoint<f64>, by: &[f64]) -> Option<ReleasePoint<f64>> {
        self.solve(point.contact, &moved(&point.state, &point.along(by), 1.0))
    }

    /// How far the coordinates of a release point are from those after a loop.
    fn missed(&self, point: &ReleasePoint<f64>) -> Option<(Vec<f64>, f64)> {
        let next = self.next(point.contact, &point.state)?;
        let (off, _) = self.apart(&point.state, &next.state);
        let free = || point.free.iter().copied();
        let size = free().map(|i| off[i].abs() / (1.0 + point.state[i].abs()));
        Some((free().map(|i| off[i]).collect(), size.fold(0.0, f64::max)))
    }

    /// The release point, near this one, that its orbit returns to: without coordinates this one.
    fn closed(&self, start: ReleasePoint<f64>) -> Option<ReleasePoint<f64>> {
        if start.free.is_empty() {
            return Some(start);
        }
        let mut here = start;
        let (mut missed, mut size) = self.missed(&here)?;
        let mut best = (size, here.clone());
        let mut before = f64::INFINITY;
        for count in 0..LOOPS {
            if size <= CLOSED {
                return Some(here);
            }
            let step = if count < PLAIN || size <= GAIN * before {
                missed
            } else {
                self.not_returned(&here)?.factored()?.solve(&missed)
            };
            before = size;
            here = self.beside(&here, &step)?;
            (missed, size) = self.missed(&here)?;
            if size < best.0 {
                best = (size, here.clone());
            }
        }
        (best.0 <= NEARLY).then_some(best.1)
    }

    /// Whether no other orbit near this one returns, too.
    fn is_alone(&self, point: &ReleasePoint<f64>) -> bool {
        (self.not_returned(point)).is_none_or(|rows| regular(&rows, ALONE).is_some())
    }

    /// Of changes of the coordinates what does not return after a loop, by differences: a row for each coordinate.
    fn not_returned(&self, point: &ReleasePoint<f64>) -> Option<Matrix<f64>> {
        let size = point.free.len();
        let mut rows = Matrix::zeros(size, size);
        for (column, &i) in point.free.iter().enumerate() {
            let step = DIFFERENCE * (1.0 + point.state[i].abs());
            let missed = |by: f64| {
                let mut changes = vec![0.0; size];
                changes[column] = by;
                Some(self.missed(&self.beside(point, &changes)?)?.0)
            };
            for (row, (a, b)) in missed(step)?.into_iter().zip(missed(-step)?).enumerate() {
                rows[(row, column)] = (b - a) / (2.0 * step);
            }
        }
        Some(rows)
    }
}
