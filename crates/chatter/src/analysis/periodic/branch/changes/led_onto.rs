//! A crossing at once after an impact or a reset: the jump leads just onto a surface, or the end of a piece, and the field leads across it from there. A bit more of
//! the jump, and it leads across itself, without that crossing; a bit less, and the crossing comes a moment later.

use super::events::unfollowed;
use super::touch::Stay;
use crate::analysis::continuation::{Curve, Station};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, LegKind};
use crate::numerics::Real;

impl<R: Real> Shooting<R> {
    /// The guard that a step, which begins with a jump onto its surface, ends at to go on beyond it: not with one that takes the state off it.
    pub(in crate::analysis::periodic) fn led_onto(&self, index: usize) -> Option<GuardKind> {
        let first = &self.steps[self.before(index)];
        let jumps = match first.passage {
            Passage::Leg(kind) => matches!(kind.jump, Jump::Impact(_) | Jump::Reset(_)),
            _ => false,
        };
        let is_left = |guard: GuardKind| match guard {
            GuardKind::Switch(surface) => self.slides_along(first, surface),
            _ => false,
        };
        let crossed = self
            .crossed(index)
            .filter(|_| jumps && self.steps.len() > 1);
        crossed.filter(|guard| !is_left(*guard))
    }
}

impl Shooting<f64> {
    /// The same orbit without such a step, and the step after it.
    fn without_crossing(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let crossed = steps.remove(index);
        let next = if index == steps.len() { 0 } else { index };
        steps[next].duration += crossed.duration;
        let (shorter, guess) = self.like(steps, at)?;
        Ok((shorter, guess, next))
    }

    /// The same orbit with such a step, of no time yet, before one that begins where this guard of it is zero.
    fn with_crossing(
        &self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        let unknown = || unfollowed("a crossing at once after a jump");
        let mut steps = self.current_steps(at);
        let beyond = (&steps[index], guard, Stay::Beyond);
        let (mode, pieces) = self.other_side(at, beyond, self.node(at, index))?;
        let crossing = Step {
            passage: Passage::Leg(LegKind {
                mode,
                ends_at: guard.opposite(),
                jump: Jump::None,
            }),
            pieces,
            duration: 0.0,
            told: Vec::new(),
            closed: self.closed_before(index),
            ..steps[index].clone()
        };
        steps.insert(index, crossing);
        let (longer, guess) = self.like(steps, at)?;
        match longer.led_onto(index) {
            Some(_) => Ok((longer, guess)),
            None => Err(unknown()),
        }
    }
}

impl Walker {
    /// On from where a crossing after a jump takes no time any more; none where that is an exchange of both.
    pub(super) fn crossing_vanishes(
        &mut self,
        way: (&mut Curve, f64),
        (station, index): (&Station, usize),
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        let guard = self.shooting.led_onto(index)?;
        let inside = guard.opposite()?;
        if !self.shooting.jumps_off(&station.at, (index, guard), true) {
            return None;
        }
        let is_told = !self.shooting.is_smooth(index);
        Some(
            self.moment_vanishes(way, (station, is_told), here, |shooting, at| {
                let (shooting, at, next) = shooting.without_crossing(at, index)?;
                Ok((shooting, at, ((next, true), inside)))
            }),
        )
    }

    /// On from where a jump leads just onto a surface that it led across so far: the crossing comes in. None where the field does not lead across
    /// it.
    pub(super) fn crossing_comes_in(
        &mut self,
        way: (&mut Curve, f64),
        (station, index, guard): (&Station, usize, GuardKind),
        here: &mut Point,
    ) -> Option<Stop> {
        self.settle(station);
        if !self.shooting.jumps_off(&station.at, (index, guard), true)
            || !self.shooting.leads_away(&station.at, (index, guard))
        {
            return None;
        }
        let longer = self.shooting.with_crossing(&station.at, (index, guard));
        let (longer, guess) = longer.ok()?;
        let (longer, next) = longer.beginning_with_no_time(&guess, index)?;
        let onto = guard.opposite()?;
        let is_told = !longer.is_smooth(index);
        let onward = match longer.leads_onto(&next.at, (index, onto)) {
            true => Ok((longer, next)),
            false => {
                let named = self.shooting.workshop.named(guard);
                Err(format!(
                    "a jump leads just onto {named}, and the field leads away from there to both sides"
                ))
            }
        };
        let watched = ((index, true), guard);
        self.moment_comes_in(way, (station, watched, is_told), onward, here)
    }
}
