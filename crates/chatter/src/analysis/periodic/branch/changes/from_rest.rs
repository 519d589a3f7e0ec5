//! Where a flight from rest comes to nothing: what a plastic impact leaves flies on for a while and lands again, or stays where it is.
//!
//! From no rate, with the acceleration a and the jerk j < 0, it lands after the time -3a/j with a rate in proportion to a^2. As a vanishes so does the
//! flight, and beyond the contact holds from the first impact on. With the flight the equations are solved by one of no time as well, whatever a is;
//! without it nothing is singular. So the touch is where the contact force vanishes as the rest begins, an equation of the orbit without that flight;
//! and on the other side the curve begins with a flight of a given short time.

use super::events::unfollowed;
use super::graze::moved;
use super::holds::is_broken;
use super::touch::{STAYS, Touched, VANISHED};
use crate::analysis::continuation::{Condition, Curve, Problem, Station, newton, tangent};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::Solved;
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Grip, GuardKind};

/// A flight from rest that takes less than this part of the period is about to come to nothing.
const SHORT: f64 = 1e-2;
/// Special points are looked for up to the first of these parts of the way to there.
const NEARLY: [f64; 3] = [0.9, 0.5, 0.1];

impl Shooting<f64> {
    /// The flight from a plastic impact to rest on the same contact that takes next to no time, or less than none, and that contact.
    fn flight_that_vanishes(&self) -> Option<(usize, usize)> {
        let flights = (0..self.steps.len()).filter_map(|index| {
            let contact = self.steps[index].impact()?;
            let lasts = self.latest.get(index)?.duration;
            let rests = self.holds(self.after(index), contact);
            let is_leg = matches!(self.steps[index].passage, Passage::Leg(_));
            let is_one = is_leg
                && rests
                && !self.holds(index, contact)
                && lasts < SHORT * self.period()
                && self.is_plastic((self.before(index), contact));
            is_one.then_some((index, contact, lasts))
        });
        let shortest = flights.min_by(|a, b| a.2.total_cmp(&b.2));
        shortest.map(|(index, contact, _)| (index, contact))
    }

    /// Whether such a flight takes no time any more, but for rounding: the equations are solved by it wherever the curve goes on.
    pub(in crate::analysis::periodic::branch) fn flight_has_vanished(&self) -> bool {
        self.flight_that_vanishes()
            .is_some_and(|(index, _)| self.latest[index].duration < VANISHED * self.period())
    }

    /// Whether a contact is closed all along a step.
    pub(super) fn holds(&self, index: usize, contact: usize) -> bool {
        let origin = self.workshop.system.origin_of(self.steps[index].mode());
        origin.is_some_and(|(grip, ..)| grip.closed.contains(contact))
    }

    /// The same orbit without such a flight, and the step that rests from where it began.
    fn without_flight(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let mut index = index;
        if index + 1 == steps.len() {
            // What rests is to be of the same turn.
            let parameters = self.workshop.parameters(self.free(at));
            rotate(
                &self.workshop,
                &parameters,
                (&mut steps, &self.counts),
                index,
            )?;
            index = 0;
        }
        let flight = steps.remove(index);
        let before = index.checked_sub(1).unwrap_or(steps.len() - 1);
        steps[before].closed = flight.closed;
        let rest = &mut steps[index];
        rest.start = flight.start;
        rest.duration += flight.duration;
        let (shorter, at) = self.like(steps, at)?;
        Ok((shorter, at, index))
    }

    /// The same orbit with a flight of this duration where a step begins to rest, and where its duration stands among the unknowns.
    fn with_flight(
        &self,
        at: &[f64],
        (index, contact, duration): (usize, usize, f64),
    ) -> Result<(Self, Vec<f64>, usize), PeriodicError> {
        let mut steps = self.current_steps(at);
        let Some(LegKind { mode, .. }) = steps[index].flight() else {
            return Err(unfollowed("a rest that is no leg"));
        };
        let system = &self.workshop.system;
        let (grip, sides, _) =
            (system.origin_of(mode)).ok_or_else(|| unfollowed("a mode that holds no motion"))?;
        let open = Grip {
            closed: grip.closed.without(contact),
            idle: grip.idle.without(contact),
        };
        let mode = system.meet(open, sides);
        if system.program(mode).is_none() {
            return Err(unfollowed("a flight in a mode that holds no motion"));
        }
        let kind = LegKind {
            mode,
            ends_at: Some(GuardKind::Gap(contact)),
            jump: Jump::Impact(contact),
        };
        let rest = steps[index].clone();
        let (kind, pieces) = self.to_impact(at, kind, (&rest.start, &rest));
        let parameters = self.workshop.parameters(self.free(at));
        let model = &self.workshop.model;
        let later = (rest.start.iter().zip(&model.states)).map(|(x, state)| {
            let rate: f64 = model
                .graph
                .evaluate(state.derivative, &rest.start, &parameters);
            x + duration * rate
        });
        let later = later.collect();
        let flight = Step {
            passage: Passage::Leg(kind),
            pieces,
            duration,
            told: Vec::new(),
            closed: self.closed_before(index),
            ..rest
        };
        let before = self.before(index);
        steps[before].closed = steps[before].closed.without(contact);
        steps[index].start = later;
        steps[index].duration -= duration;
        steps.insert(index, flight);
        let (longer, at) = self.like(steps, at)?;
        let place = longer.duration_place(index);
        let place = place.ok_or_else(|| unfollowed("a flight without duration"))?;
        Ok((longer, at, place))
    }

    /// Where the force of a contact vanishes as a step begins to rest on it.
    fn rests_without_force(
        mut self,
        start: &[f64],
        (index, contact): (usize, usize),
    ) -> Result<Touched, String> {
        let known = self.watch_start(index, GuardKind::Reaction(contact));
        known.map_err(|error| error.to_string())?;
        let force = Bordered::Monitor(self.corner_function());
        let found = self.solved(&force, start);
        let Solved {
            at,
            told,
            residual,
            correction,
            error,
        } = found.map_err(|error| error.to_string())?;
        if moved(&at, start, self.scales()) > SHORT {
            return Err(
                "where a rest begins without a force only another place is found".to_owned(),
            );
        }
        Ok(Touched {
            index: self.before(index),
            shooting: self,
            at,
            told,
            residual,
            correction,
            error,
            together: None,
        })
    }
}

impl Walker {
    /// On past where a flight from rest comes to nothing, with the rest alone: on the way to a station, so far ahead, or on from the latest one. None
    /// where there is no such flight.
    pub(in crate::analysis::periodic::branch) fn flight_ends(
        &mut self,
        ahead: Option<(&Station, f64)>,
        curve: &mut Curve,
        here: &mut Point,
    ) -> Option<Stop> {
        let station = &curve.station.clone();
        let there = ahead.map_or(station, |(there, _)| there);
        self.settle(there);
        let (index, contact) = self.shooting.flight_that_vanishes()?;
        let place = self.shooting.duration_place(index)?;
        let shrinks = match ahead {
            Some(_) => there.at[place] < station.at[place],
            None => station.tangent[place] < 0.0,
        };
        if !shrinks {
            return None;
        }
        let without = self.shooting.without_flight(&there.at, index);
        let (shorter, guess, index) = without.ok()?;
        let touched = shorter.rests_without_force(&guess, (index, contact));
        let touched = touched.ok()?;
        self.settle(station);
        let forward = self.heading_known(station);
        let (mut resting, at) = (touched.shooting.clone(), touched.at.clone());
        let there = Station::near(&mut resting, &at, at.len() - 1).ok()?;
        let next = self.distances().into_iter().find_map(|ahead| {
            let both = [there.clone(), there.clone().reversed()].map(|there| {
                let (next, _) = there.ahead(&mut resting, ahead).ok()?;
                let holds = is_broken(&mut resting, &next.at).is_ok_and(|broken| !broken);
                holds.then_some(next)
            });
            match both {
                [Some(next), None] | [None, Some(next)] => Some(next),
                _ => None,
            }
        })?;
        let nearly = ahead.and_then(|(_, ahead)| {
            NEARLY.into_iter().find_map(|part| {
                let (nearly, _) = station.ahead(&mut self.shooting, part * ahead).ok()?;
                self.settle(&nearly);
                (!self.shooting.flight_has_vanished()).then_some((nearly, part * ahead))
            })
        });
        if let Some((nearly, ahead)) = nearly {
            let near = Point::new(&mut self.shooting, &nearly);
            if let Some(end) = self.between(station, &nearly, ahead, (here, &near)) {
                return Some(Stop::End(end));
            }
        }
        let there = Point::new(&mut resting, &there);
        self.shooting = resting;
        self.note_touch(&there, touched);
        Some(self.goes_on(Ok(next), (curve, forward), here))
    }

    /// A rest that begins with a plastic impact loses its force there: a flight comes in. The new equations, at their first station.
    pub(super) fn flies_from_rest(
        &mut self,
        station: &Station,
        (index, contact): (usize, usize),
        there: &Point,
    ) -> Result<Station, String> {
        self.settle(station);
        if !self
            .shooting
            .is_plastic((self.shooting.before(index), contact))
        {
            return Err("what rests there has not begun with a plastic impact".to_owned());
        }
        let resting = self.shooting.clone();
        let touched = resting.rests_without_force(&station.at, (index, contact))?;
        let (touch, at) = (touched.shooting.clone(), touched.at.clone());
        let period = touch.period();
        let next = STAYS.into_iter().find_map(|part| {
            let place = (index, contact, part * period);
            let (mut longer, guess, place) = touch.with_flight(&at, place).ok()?;
            let fixed = Condition::fixed(guess.len(), place, guess[place]);
            let found = newton(&mut longer, &guess, core::slice::from_ref(&fixed)).ok()?;
            let is_there = moved(&found.at, &guess, longer.scales()) <= SHORT
                && is_broken(&mut longer, &found.at).is_ok_and(|broken| !broken);
            let tangent = tangent(&mut longer, &found.at, &fixed.row).ok()?;
            is_there.then_some((longer, Station::beginning(found, tangent)))
        });
        let (longer, next) =
            next.ok_or("what rests there loses its force, and no flight from it is found")?;
        self.note_touch(there, touched);
        self.shooting = longer;
        Ok(next)
    }
}
