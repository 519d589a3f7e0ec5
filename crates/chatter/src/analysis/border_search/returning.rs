//! Release points of models with more than three states: those to which the orbit returns, by iteration and Newton's method.
//!
//! With n states release points fill a surface of n - 3 dimensions. What leads from one to the next is smooth where chatter is
//! complete. Where it ends in flight, contact from its last impact on that presses leads to a point that is as near to
//! the orbit's as nu^3 there, and continues the complete side smoothly to the border.

use super::unfollowed::end_of_motion;
use crate::analysis::border::{
    BorderError, Here, Lack, Place, ReleasePoint, Sequence, Until, Verdict, regular,
};
use crate::flow::FlowError;
use crate::numerics::{Equations, Linearised, Matrix, Newton, NewtonError, moved};

/// A trajectory passes so many release points at most; the orbits near so many of them are looked for: near those that it comes back to
/// best. Where it settles these are the last ones, where it is chaotic those beside orbits that are not stable.
const PASSED: usize = 24;
const LOOKED_AT: usize = 3;

/// Loops that close an orbit, at most; the first ones, which are followed as they come; and what one gains that is as good as
/// Newton's step.
const LOOPS: usize = 24;
const PLAIN: usize = 3;
const GAIN: f64 = 0.05;

/// Where sequences jump, what is missed jumps, too: so often it may not be the least so far where that is little, and after so many loops
/// it must shrink.
const STALLS: usize = 3;
const PATIENCE: usize = 6;

/// The orbit is closed if its release point returns to itself to this, relative to its size. Sequences that end in flight jump as
/// they lose impacts: there it need not be nearer than this.
const CLOSED: f64 = 1e-10;
const NEARLY: f64 = 1e-4;
/// Complete chatter jumps nowhere: what is left is rounding of a long way.
const COMPLETE: f64 = 1e-8;

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

    /// Release points of the orbits that trajectories settle to: from the initial state, and from the release point near it;
    /// and why the motion from the initial state ends, if it does.
    pub(crate) fn settled(
        &self,
        contact: usize,
    ) -> Result<(Vec<ReleasePoint<f64>>, Option<FlowError>), BorderError> {
        let initial = self.problem.model.initial_state(&self.parameters);
        let sequence = self.first_sequence(contact, &initial);
        let failure = sequence.as_ref().err().and_then(end_of_motion).cloned();
        let next = (sequence.ok()).and_then(|sequence| self.after(contact, &sequence));
        let starts = [next, self.solve(contact, &initial)];
        let mut found: Vec<ReleasePoint<f64>> = Vec::new();
        for start in starts.into_iter().flatten() {
            for point in self.recurring(contact, start) {
                let is_new = |point: &ReleasePoint<f64>| self.is_new(point, &found);
                let closed = Some(point).filter(is_new).and_then(|at| self.closed(at));
                let Some(point) = closed.filter(is_new) else {
                    continue;
                };
                if !self.is_alone(&point) {
                    return Err(self.lacks(Lack::Alone));
                }
                found.push(point);
            }
        }
        Ok((found, failure))
    }

    /// Of the release points that a trajectory passes those that it comes back to best.
    fn recurring(&self, contact: usize, start: ReleasePoint<f64>) -> Vec<ReleasePoint<f64>> {
        let mut passed: Vec<(f64, ReleasePoint<f64>)> = Vec::new();
        let mut point = start;
        while passed.len() < PASSED {
            let Some(next) = self.next(contact, &point.state) else {
                break;
            };
            let (_, off) = self.apart(&point.state, &next.state);
            passed.push((off, core::mem::replace(&mut point, next)));
            if off <= CLOSED {
                break;
            }
        }
        // Of equals the later ones.
        passed.reverse();
        passed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let best = passed.into_iter().take(LOOKED_AT);
        best.map(|(_, point)| point).collect()
    }

    /// The impacts from a state to the end of the first chatter sequence.
    fn first_sequence(&self, contact: usize, state: &[f64]) -> Result<Sequence<f64>, BorderError> {
        let first = Until {
            after: 0,
            ..Until::NEVER
        };
        self.follow((contact, state), first)
    }

    /// The release point after a chatter sequence.
    fn after(&self, contact: usize, sequence: &Sequence<f64>) -> Option<ReleasePoint<f64>> {
        self.solve(contact, &self.released(sequence, contact)?)
    }

    /// The release point after the first chatter sequence from a state.
    fn next(&self, contact: usize, state: &[f64]) -> Option<ReleasePoint<f64>> {
        self.after(contact, &self.first_sequence(contact, state).ok()?)
    }

    /// A release point beside one: its coordinates changed by so much.
    fn beside(&self, point: &ReleasePoint<f64>, by: &[f64]) -> Option<ReleasePoint<f64>> {
        self.solve(point.contact, &moved(&point.state, &point.along(by), 1.0))
    }

    /// How far the coordinates of a release point are from those after a loop.
    fn missed(&self, point: &ReleasePoint<f64>) -> Option<(Vec<f64>, f64)> {
        let sequence = self.sequence(point, usize::MAX).ok()?;
        if sequence.verdict == Verdict::Elsewhere {
            return None;
        }
        let next = self.after(point.contact, &sequence)?;
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
        let newton = Newton {
            steps: LOOPS + 1,
            done: CLOSED,
            settled: NEARLY,
            stalls: STALLS,
            patience: PATIENCE,
            ..Newton::to_rounding::<f64>(0.0)
        };
        let coordinates: Vec<f64> = start.free.iter().map(|&i| start.state[i]).collect();
        let mut loops = Loops {
            here: self,
            point: start,
            at: coordinates.clone(),
            size: f64::INFINITY,
            count: 0,
            best: None,
        };
        let found = newton.solve(&mut loops, &coordinates);
        let (size, best) = loops.best?;
        if !matches!(found, Ok(_) | Err(NewtonError::Stalled { .. })) || size > NEARLY {
            return None;
        }
        let is_complete = || {
            let sequence = self.sequence(&best, usize::MAX);
            sequence.is_ok_and(|sequence| sequence.verdict == Verdict::Complete)
        };
        (size <= COMPLETE || !is_complete()).then_some(best)
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

/// What coordinates of a release point miss after a loop: followed as it comes at first and while that gains as much as Newton's step, by its
/// derivative else.
struct Loops<'h, 'p> {
    here: &'h Here<'p, f64>,
    point: ReleasePoint<f64>,
    /// Its coordinates as they were asked for.
    at: Vec<f64>,
    /// How much is missed there.
    size: f64,
    count: usize,
    best: Option<(f64, ReleasePoint<f64>)>,
}

impl Equations<f64> for Loops<'_, '_> {
    type Left = ();

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, ()> {
        if self.count > 0 {
            let by: Vec<f64> = at
                .iter()
                .zip(&self.at)
                .map(|(to, from)| to - from)
                .collect();
            self.point = self.here.beside(&self.point, &by).ok_or(())?;
        }
        self.at.copy_from_slice(at);
        let (missed, size) = self.here.missed(&self.point).ok_or(())?;
        let is_plain = self.count < PLAIN || size <= GAIN * self.size;
        let jacobian = match is_plain || size <= CLOSED {
            true => Matrix::identity(at.len()),
            false => self.here.not_returned(&self.point).ok_or(())?,
        };
        (self.count, self.size) = (self.count + 1, size);
        if self.best.as_ref().is_none_or(|(least, _)| size < *least) {
            self.best = Some((size, self.point.clone()));
        }
        Ok(Linearised {
            residual: missed.iter().map(|x| -x).collect(),
            jacobian,
        })
    }

    fn size(&self, _: &[f64], _: &[f64]) -> f64 {
        self.size
    }
}
