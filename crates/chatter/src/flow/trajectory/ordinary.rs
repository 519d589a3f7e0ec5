//! What an ordinary step changes of a trajectory, be it alone or in a lane.

use super::{StepResult, Trajectory};
use crate::flow::flight::{Course, Flight, Outcome, largest};
use crate::flow::guard::Transition;
use crate::flow::occurrence::Occurrence;
use crate::flow::program::{Closed, IMPACT_SCALARS, Program};
use crate::flow::system::System;
use crate::flow::touching::{Left, Touching};
use crate::numerics::Real;

/// Impacts of which nothing is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Untold<R> {
    /// How many more may pass.
    allowed: u64,
    /// How many did since something was last told.
    count: u64,
    /// The times of the latest two of them.
    times: [R; 2],
}

impl<R: Real> Untold<R> {
    /// Every impact is told.
    pub const NONE: Self = Self {
        allowed: 0,
        count: 0,
        times: [R::ZERO; 2],
    };
}

impl<R: Real> Trajectory<R> {
    /// Lets so many ordinary impacts pass without telling of them. What happened is told by [`untold`](Self::untold).
    pub fn let_pass(&mut self, most: u64) {
        self.untold = Untold {
            allowed: most,
            ..Untold::NONE
        };
    }

    /// How many impacts have passed since [`let_pass`](Self::let_pass), with the time of the latest, and of the one before it where
    /// there are two.
    pub fn untold(&self) -> Option<(u64, R, Option<R>)> {
        let Untold { count, times, .. } = self.untold;
        let [before, latest] = times;
        (count > 0).then(|| (count, latest, (count > 1).then_some(before)))
    }

    /// Says what a step means if it is an ordinary one, whose state is in place; else nothing, and nothing is changed.
    #[inline(always)]
    pub(super) fn digest_ordinary(
        &mut self,
        system: &System,
        program: &Program,
        result: &StepResult<R>,
    ) -> Option<Option<Occurrence<R>>> {
        let is_simple = result.touched.is_none() && result.crowd == Closed::NONE;
        if !(is_simple && program.is_free) {
            return None;
        }
        let at_impact = match result.event {
            None => false,
            Some(index) => match program.guards[index].transition {
                Transition::Impact { .. } if system.corners().is_empty() => true,
                _ => return None,
            },
        };
        let (largest, is_finite) = largest(&self.state, self.coordinates);
        let Outcome { step, impact, .. } = &result.outcome;
        let (course, is_ordinary) =
            (self.flight()).follow(&result.outcome, (!at_impact, at_impact), largest);
        (is_ordinary && is_finite).then(|| match result.event {
            None => {
                self.keep_glide(&course, *step);
                None
            }
            Some(index) => self.keep_bounce(&course, (index, program), impact),
        })
    }

    /// What an ordinary step asks for.
    #[inline(always)]
    pub(crate) fn flight(&self) -> Flight<R> {
        let (restitution, border) = self.tracker.border();
        Flight {
            time: self.time,
            time_low: self.time_low,
            horizon: self.horizon,
            horizon_low: self.horizon_low,
            flight_time: self.flight_time,
            longest_step: self.longest_step,
            restitution: R::splat(restitution),
            border: R::splat(border),
        }
    }

    #[inline(always)]
    fn keep(&mut self, course: &Course<R>) {
        self.time = course.time;
        self.time_low = course.time_low;
        self.flight_time = course.flight_time;
        self.longest_step = course.longest_step;
        self.met = None;
        self.rates_of_instant.clear();
    }

    /// Keeps what an ordinary step without event came to.
    #[inline(always)]
    pub(crate) fn keep_glide(&mut self, course: &Course<R>, step: R) {
        self.keep(course);
        self.may_have_crossed = false;
        self.burst = 0;
        self.left = self.left.after(self.touching, step);
        self.touching = Touching::after(None);
    }

    /// Keeps what an ordinary impact came to, which is the zero of a guard with this number. Says what is to be told.
    #[inline(always)]
    pub(crate) fn keep_bounce(
        &mut self,
        course: &Course<R>,
        (index, program): (usize, &Program),
        &[rate, rate_after, ..]: &[R; IMPACT_SCALARS],
    ) -> Option<Occurrence<R>> {
        let guard = &program.guards[index];
        let contact = guard.closing()?;
        self.keep(course);
        self.may_have_crossed = true;
        self.burst = 1;
        self.left = Left::NONE;
        self.touching = Touching::after(Some(index));
        self.touched_at = course.time;
        self.ended_by = Some(guard.kind);
        self.count_impact(contact, rate);
        self.tracker
            .keep_pace(contact, course.time, course.rest_of_sequence);
        self.tracker.interrupt();
        let untold = &mut self.untold;
        if untold.allowed > 0 {
            untold.allowed -= 1;
            untold.count += 1;
            untold.times = [untold.times[1], course.time];
            return None;
        }
        Some(Occurrence::Impact {
            contact,
            rate_before: rate,
            rate_after,
            closes: false,
        })
    }
}
