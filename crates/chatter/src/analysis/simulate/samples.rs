//! States along a trajectory.

use super::sink::Sink;
use super::spec::Sampling;
use crate::flow::{Closed, Dense, Occurrence, System, Trajectory, Workspace};
use crate::numerics::{DoubleDouble, Real};
use core::ops::ControlFlow;

/// States at a sequence of times that never falls.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples<R> {
    /// The times.
    pub times: Vec<R>,
    /// For each state of the model its values at these times.
    pub states: Vec<Vec<R>>,
    /// The contacts that were closed.
    pub closed: Vec<Closed>,
}

impl<R: Real> Samples<R> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    pub(super) fn new(dimension: usize) -> Self {
        Self {
            times: Vec::new(),
            states: vec![Vec::new(); dimension],
            closed: Vec::new(),
        }
    }

    /// Takes over what follows.
    pub(super) fn append(&mut self, next: &Self) {
        self.times.extend_from_slice(&next.times);
        self.closed.extend_from_slice(&next.closed);
        for (values, next) in self.states.iter_mut().zip(&next.states) {
            values.extend_from_slice(next);
        }
    }

    fn clear(&mut self) {
        self.times.clear();
        self.closed.clear();
        self.states.iter_mut().for_each(Vec::clear);
    }

    /// Drops the first `count` samples.
    fn forget(&mut self, count: usize) {
        self.times.drain(..count);
        self.closed.drain(..count);
        for values in &mut self.states {
            values.drain(..count);
        }
    }

    fn push(&mut self, time: R, closed: Closed, state: impl Fn(usize) -> R) {
        self.times.push(time);
        self.closed.push(closed);
        for (index, values) in self.states.iter_mut().enumerate() {
            values.push(state(index));
        }
    }
}

/// A step of high order may hold a whole turn of a spiral; a short one is little more than a parabola.
const MOST_IN_STEP: f64 = 64.0;
const FEWEST_IN_STEP: f64 = 4.0;

/// A picture needs no more samples than this.
const MOST_IN_PICTURE: usize = 500_000;

/// So many steps at most lead from a sample within a sequence to the next: more than its impacts that are longer than rounding.
const MOST_WITHIN: usize = 1 << 20;

/// Samples that are handed over at once.
const BLOCK: usize = 1024;

/// Takes samples while a trajectory moves.
pub(super) struct Sampler<R> {
    sampling: Sampling,
    samples: Samples<R>,
    start: R,
    /// How many samples at equal intervals have been taken, and where the step began that comes next.
    taken: u64,
    reached: (R, R),
    /// Whether the latest step was not within the window of interest.
    outside: bool,
}

impl<R: Real> Sampler<R> {
    pub(super) fn new(sampling: Sampling, trajectory: &Trajectory<R>) -> Self {
        let state = trajectory.state();
        let start = trajectory.time();
        let outside = match &sampling {
            Sampling::Smooth { window, .. } => {
                window.is_some_and(|(from, _)| from > start.to_double_double())
            }
            Sampling::Dense { .. } | Sampling::Every(_) | Sampling::At(_) => false,
        };
        let mut samples = Samples::new(state.len());
        let at_start = match &sampling {
            Sampling::At(times) => (times.iter())
                .take_while(|time| R::from_double_double(**time) <= start)
                .count(),
            _ => usize::from(!outside),
        };
        for _ in 0..at_start {
            samples.push(start, trajectory.closed(), |index| state[index]);
        }
        Self {
            sampling,
            samples,
            start,
            taken: at_start as u64,
            reached: trajectory.time_parts(),
            outside,
        }
    }

    /// Hands over what there is, if that is enough or is all that will come. What a picture shows is kept, since it
    /// shows the end of a long run.
    pub(super) fn hand_over(
        &mut self,
        list: usize,
        least: usize,
        sink: &mut dyn Sink<R>,
    ) -> ControlFlow<()> {
        let kept = matches!(self.sampling, Sampling::Smooth { .. });
        if kept || self.samples.len() < least {
            return ControlFlow::Continue(());
        }
        let goes_on = sink.samples(list, &self.samples);
        self.samples.clear();
        goes_on
    }

    /// Samples the step from `before` that the trajectory has just made, in the phase `closed`.
    pub(super) fn motion(
        &mut self,
        dense: &Dense<'_, R>,
        before: R,
        closed: Closed,
        trajectory: &Trajectory<R>,
        (list, sink): (usize, &mut dyn Sink<R>),
    ) -> ControlFlow<()> {
        match self.sampling {
            Sampling::Dense { per_step } => {
                self.fractions(dense, before, closed, trajectory, per_step);
            }
            Sampling::Smooth { resolution, window } => {
                let outside = window.is_some_and(|(from, to)| {
                    trajectory.time().to_double_double() < from || before.to_double_double() > to
                });
                if outside {
                    self.outside = true;
                    return ControlFlow::Continue(());
                }
                if core::mem::take(&mut self.outside) {
                    let start = |index| dense.state(index, R::ZERO);
                    self.samples.push(before, closed, start);
                }
                let intervals = (dense.step().to_f64() / resolution.high()).ceil();
                let per_step = intervals.clamp(FEWEST_IN_STEP, MOST_IN_STEP) as u32;
                self.fractions(dense, before, closed, trajectory, per_step);
                if self.samples.len() > 2 * MOST_IN_PICTURE {
                    self.samples.forget(self.samples.len() - MOST_IN_PICTURE);
                }
            }
            Sampling::Every(_) | Sampling::At(_) => {
                let (reached, low) = trajectory.time_parts();
                let before = core::mem::replace(&mut self.reached, (reached, low));
                while let Some(due) = self.due() {
                    let time = R::from_double_double(due);
                    if time > reached {
                        break;
                    }
                    self.taken += 1;
                    if dense.step() > R::ZERO {
                        // What rounding the time has taken away is part of a step all the same.
                        let rest = due - time.to_double_double();
                        let late = (time - before.0) + (R::from_double_double(rest) - before.1);
                        let fraction = (late / dense.step()).max(R::ZERO).min(R::ONE);
                        self.samples
                            .push(time, closed, |index| dense.state(index, fraction));
                    } else {
                        let state = trajectory.state();
                        self.samples.push(time, closed, |index| state[index]);
                    }
                    // One step may have more samples than memory holds.
                    self.hand_over(list, BLOCK, sink)?;
                }
            }
        }
        self.hand_over(list, BLOCK, sink)
    }

    /// Samples a trajectory that follows the impacts of a sequence on, as far as they are due before its end.
    pub(super) fn within_sequence(
        &mut self,
        (system, work): (&System, &mut Workspace<R>),
        mut on: Trajectory<R>,
        end: R,
        (list, sink): (usize, &mut dyn Sink<R>),
    ) -> ControlFlow<()> {
        while let Some(due) = self.due() {
            let time = R::from_double_double(due);
            if time >= end {
                break;
            }
            let rest = due - time.to_double_double();
            // From the latest impact to each, as if the run ended there.
            let mut from = on.clone();
            from.set_horizon_parts((time, R::from_double_double(rest)));
            let comes_there =
                (0..MOST_WITHIN).find_map(|_| match from.advance_to_horizon(system, work) {
                    Ok(Some(Occurrence::Horizon)) => Some(true),
                    Ok(Some(_)) => {
                        on = from.clone();
                        None
                    }
                    Ok(None) => None,
                    Err(_) => Some(false),
                });
            // What goes wrong on the way is the run's to say, if it comes there.
            if comes_there != Some(true) {
                break;
            }
            self.taken += 1;
            let state = from.state();
            (self.samples).push(time, from.closed(), |index| state[index]);
            self.hand_over(list, BLOCK, sink)?;
        }
        ControlFlow::Continue(())
    }

    /// When the next sample is due, where that is known beforehand.
    fn due(&self) -> Option<DoubleDouble> {
        match &self.sampling {
            Sampling::Every(interval) => {
                let start = self.start.to_double_double();
                Some(start + *interval * DoubleDouble::from(self.taken as f64))
            }
            Sampling::At(times) => times.get(self.taken as usize).copied(),
            Sampling::Dense { .. } | Sampling::Smooth { .. } => None,
        }
    }

    /// Samples the end of each of so many equal parts of the step.
    fn fractions(
        &mut self,
        dense: &Dense<'_, R>,
        before: R,
        closed: Closed,
        trajectory: &Trajectory<R>,
        parts: u32,
    ) {
        if dense.step() > R::ZERO {
            for k in 1..=parts {
                let fraction = R::splat(f64::from(k)) / R::splat(f64::from(parts));
                let time = if k == parts {
                    trajectory.time()
                } else {
                    // Where steps are below the rounding of time, that could lie beyond their end.
                    (dense.step().mul_add(fraction, before)).min(trajectory.time())
                };
                self.samples
                    .push(time, closed, |index| dense.state(index, fraction));
            }
        }
    }

    /// Samples the state after an event.
    pub(super) fn event(&mut self, trajectory: &Trajectory<R>) {
        let at_events = match self.sampling {
            Sampling::Dense { .. } | Sampling::Smooth { .. } => true,
            Sampling::Every(_) | Sampling::At(_) => false,
        };
        if at_events && !self.outside {
            let state = trajectory.state();
            let (time, closed) = (trajectory.time(), trajectory.closed());
            self.samples.push(time, closed, |index| state[index]);
        }
    }

    /// The samples that have not been handed over.
    pub(super) fn finish(self) -> Samples<R> {
        self.samples
    }
}
