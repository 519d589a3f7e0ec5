//! What an ordinary step changes of a trajectory, be it alone or in a lane.

use super::{StepResult, Trajectory};
use crate::expressions::Surfaces;
use crate::flow::chatter::REMEMBERED;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::{Guard, Transition};
use crate::flow::modes::program::Program;
use crate::flow::step::flight::{Course, Flight, Outcome, largest, rest_of_sequence};
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

    /// Lets so many pass.
    #[inline(always)]
    fn pass(&mut self, impacts: u64) {
        self.allowed -= impacts;
        self.count += impacts;
    }

    /// The time of one of them.
    #[inline(always)]
    fn keep(&mut self, time: R) {
        self.times = [self.times[1], time];
    }
}

/// Ordinary impacts of one contact that followed each other, and of which nothing is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed<R> {
    /// How many there were.
    pub count: u64,
    /// How many the sequence has with them.
    pub sequence: u64,
    /// The incoming rate of the latest.
    pub rate: R,
}

/// Where ordinary steps have led.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caught<R> {
    /// Time, and its rounding remainder.
    pub time: (R, R),
    pub flight_time: R,
    pub longest_step: R,
    /// Whether one of them ended in an impact.
    pub has_bounced: bool,
    /// The guard that ended the latest, in an impact.
    pub ended_at: Option<usize>,
}

/// An ordinary impact that is to be told: its contact, and the rates before and after. As numbers: what was just put together and is
/// moved as a whole stalls the processor.
pub(super) type Bounce<R> = (usize, (R, R));

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
    ) -> Option<Option<Bounce<R>>> {
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
        if !(is_ordinary && is_finite) {
            return None;
        }
        self.known_gap = result.gap;
        Some(match result.event {
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
        (self.met, self.met_with) = (None, Surfaces::default());
        self.rates_of_instant.clear();
    }

    /// Keeps what an ordinary step without event came to.
    #[inline(always)]
    fn keep_glide(&mut self, course: &Course<R>, step: R) {
        self.keep(course);
        self.may_have_crossed = false;
        self.burst = 0;
        self.note_glide(self.touching, step);
        self.touching = Touching::after(None);
    }

    /// Keeps what an ordinary impact came to, which is the zero of a guard with this number. Says what is to be told.
    #[inline(always)]
    fn keep_bounce(
        &mut self,
        course: &Course<R>,
        (index, program): (usize, &Program),
        &[rate, rate_after, _, _, _, at_rest]: &[R; IMPACT_SCALARS],
    ) -> Option<Bounce<R>> {
        let guard = &program.guards[index];
        let contact = guard.closing()?;
        self.keep(course);
        self.left = Left::NONE;
        self.has_bounced(index);
        let rest = rest_of_sequence(course.flight_time, at_rest);
        let is_told = self.note_bounce(guard, (contact, rate), (course.time, rest));
        is_told.then_some((contact, (rate, rate_after)))
    }

    /// What holds after an ordinary impact.
    #[inline(always)]
    fn has_bounced(&mut self, index: usize) {
        self.may_have_crossed = true;
        self.burst = 1;
        self.touching = Touching::after(Some(index));
        self.tracker.interrupt();
    }

    /// Takes note of an ordinary step without event that began with so many roots of each guard. What else it changes may wait.
    #[inline(always)]
    pub(crate) fn note_glide(&mut self, touching: Touching, step: R) {
        self.left = self.left.after(touching, step);
    }

    /// Takes note of an ordinary impact of a contact at this rate: the time and how long its sequence may still go on. Says whether
    /// it is to be told. What else it changes may wait.
    #[inline(always)]
    pub(crate) fn note_bounce(
        &mut self,
        guard: &Guard,
        (contact, rate): (usize, R),
        (time, rest_of_sequence): (R, R),
    ) -> bool {
        self.touched_at = time;
        self.ended_by = Some(guard.kind);
        self.count_impact(contact, rate);
        self.tracker.keep_pace(contact, time, rest_of_sequence);
        let is_told = self.untold.allowed == 0;
        if !is_told {
            self.untold.pass(1);
            self.untold.keep(time);
        }
        is_told
    }

    /// What [`note_passed`](Self::note_passed) goes on from: how many impacts may pass untold, how many the sequence has, and the rate
    /// that the next one's must exceed for it to go on, if it is one of this contact.
    pub(crate) fn passing(&self, contact: usize) -> (u64, u64, Option<R>) {
        let latest = self.latest_impact.filter(|&(before, _)| before == contact);
        let rate = latest.map(|(_, rate)| rate);
        (self.untold.allowed, self.sequence, rate)
    }

    /// Takes note of impacts that passed; `at` tells of each of the latest, by number, its time and how long the sequence may still go
    /// on. What else they change may wait.
    #[inline(always)]
    pub(crate) fn note_passed(
        &mut self,
        guard: &Guard,
        contact: usize,
        passed: Passed<R>,
        at: impl Fn(u64) -> (R, R),
    ) {
        let Passed {
            count,
            sequence,
            rate,
        } = passed;
        self.ended_by = Some(guard.kind);
        self.sequence = sequence;
        self.latest_impact = Some((contact, rate));
        self.untold.pass(count);
        let forgotten = count.saturating_sub(REMEMBERED as u64);
        self.tracker.pass_over(contact, forgotten as usize);
        for number in forgotten..count {
            let (time, rest_of_sequence) = at(number);
            self.touched_at = time;
            self.tracker.keep_pace(contact, time, rest_of_sequence);
            self.untold.keep(time);
        }
    }

    /// Takes over what has waited: the end of ordinary steps of which note was taken. States, remainders, sides and what orders
    /// reach are in place.
    pub(crate) fn catch_up(&mut self, caught: &Caught<R>) {
        (self.time, self.time_low) = caught.time;
        self.flight_time = caught.flight_time;
        self.longest_step = caught.longest_step;
        (self.met, self.met_with) = (None, Surfaces::default());
        self.rates_of_instant.clear();
        if caught.has_bounced {
            self.left = Left::NONE;
            self.tracker.interrupt();
        }
        if let Some(index) = caught.ended_at {
            self.has_bounced(index);
        } else {
            self.may_have_crossed = false;
            self.burst = 0;
            self.touching = Touching::after(None);
        }
    }
}
