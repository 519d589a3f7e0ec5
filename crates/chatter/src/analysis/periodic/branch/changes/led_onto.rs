//! A crossing at once after an impact or a reset: the jump leads just onto a surface, or the end of a piece, and the field leads across it from there. A bit more of
//! the jump, and it leads across itself, without that crossing; a bit less, and the crossing comes a moment later.

use super::events::unfollowed;
use super::graze::{CAREFUL, THERE, moved};
use super::touch::{NO_TIME, Stay};
use crate::analysis::continuation::{Curve, Problem, Station};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least, LegKind};
use crate::numerics::Real;

impl<R: Real> Shooting<R> {
    /// The guard that a step, which begins with a jump onto its surface, ends at to go on beyond it: not with one that takes the state off it, nor with one
    /// whose friction stops what slides there.
    pub(in crate::analysis::periodic) fn led_onto(&self, index: usize) -> Option<GuardKind> {
        let first = &self.steps[self.before(index)];
        let jumps = match first.passage {
            Passage::Leg(kind) => matches!(kind.jump, Jump::Impact(_) | Jump::Reset(_)),
            _ => false,
        };
        let is_left = |guard: GuardKind| match guard {
            GuardKind::Switch(surface) => {
                self.slides_along(first, surface) || self.slips_about(index)
            }
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

    /// Whether friction at the impact before a step has brought the state to the surface of a guard.
    fn begins_stopped(&self, index: usize, guard: GuardKind) -> bool {
        match self.steps[self.before(index)].passage {
            Passage::Leg(LegKind {
                jump: Jump::Stop(contact),
                ..
            }) => self.is_turn(contact, guard),
            _ => false,
        }
    }

    /// Whether a step leads off the surface that friction at the impact before it has brought the state to, and back to cross it.
    fn comes_back_after_stop(&self, index: usize) -> bool {
        let crossed = self.crossed(index).filter(|_| self.steps.len() > 1);
        crossed.is_some_and(|guard| self.begins_stopped(index, guard))
    }

    /// Whether such a step takes next to no time, and the field goes on as it is.
    fn dips(&self, at: &[f64], index: usize) -> bool {
        let lasts = self.duration_place(index).map(|place| at[place]);
        self.is_smooth(index) && lasts.is_some_and(|lasts| lasts < NO_TIME * self.period())
    }

    /// Whether what a guard has for a least value on a step is such a way, to the other side and back: nothing happens there.
    pub(super) fn is_dip(&self, index: usize, least: &Least) -> bool {
        let GuardKind::Switch(surface) = least.guard else {
            return false;
        };
        if least.at_end || !self.begins_stopped(index, least.guard) {
            return false;
        }
        let (Some(at), mode) = (self.watching(), self.steps[index].mode()) else {
            return false;
        };
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, &self.steps[index]);
        let own = self.workshop.system.field_of(mode, &all, &least.state);
        let beyond = self.mode_beyond(mode, surface);
        let beyond =
            beyond.and_then(|mode| self.workshop.system.field_of(mode, &all, &least.state));
        own.is_some() && own == beyond
    }
}

impl Walker {
    /// On from where such a step takes no time any more, without it: nothing happens to the orbit. With it the equations have a second solution there, in which it
    /// never takes any.
    pub(super) fn dip_ends(
        &mut self,
        (curve, reached): (&mut Curve, f64),
        (station, index): (&Station, usize),
        here: &mut Point,
    ) -> Option<Stop> {
        if !self.shooting.comes_back_after_stop(index) {
            return None;
        }
        // There the curve turns into the time that vanishes, and the parameter says nothing.
        self.settle(&curve.station);
        let forward = self.heading_known(&curve.station)?;
        self.settle(station);
        if !self.shooting.dips(&station.at, index) {
            return None;
        }
        let (mut shorter, guess, _) = self.shooting.without_crossing(&station.at, index).ok()?;
        let next = Station::beside(&mut shorter, &guess).ok()?;
        if moved(&next.at, &guess, shorter.scales()) > THERE {
            return None;
        }
        let there = Point::new(&mut self.shooting, station);
        if let Some(end) = self.between(&curve.station, station, reached, (here, &there)) {
            return Some(Stop::End(end));
        }
        let next = match next.parameter_slope() * forward < 0.0 {
            true => next.reversed(),
            false => next,
        };
        self.shooting = shorter;
        self.settle(&next);
        self.begins_anew((next, CAREFUL * curve.step), curve, here);
        Some(Stop::On)
    }

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
