//! Where a flight beside a rest comes to nothing: before it, or after it.
//!
//! What a plastic impact leaves flies on for a while and lands again, or stays where it is. From no rate, with the acceleration a and the jerk j < 0, it
//! lands after the time -3a/j with a rate in proportion to a^2. As a vanishes so does the
//! flight, and beyond the contact holds from the first impact on. With the flight the equations are solved by one of no time as well, whatever a is;
//! without it nothing is singular. So the touch is where the contact force vanishes as the rest begins, an equation of the orbit without that flight;
//! and on the other side the curve begins with a flight of a given short time.
//!
//! What a corner of the field throws off, as friction that turns at the top of a cam does, may be released a little before, and meets the corner in
//! flight. As the force vanishes just where the corner comes so does that flight, and beyond the contact holds up to there. The time of the flight is
//! a square root where the force is least there, and so it is the other way round: the touch is where the contact force vanishes as the rest ends, an
//! equation of the orbit without that flight.

use super::flights::{Beside, Rests};
use crate::analysis::continuation::{Condition, Curve, Problem, Station, newton, tangent};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::changes::graze::{LEAST_HEIGHT, is_told, moved};
use crate::analysis::periodic::branch::changes::holds::{Broken, sequence_holds};
use crate::analysis::periodic::branch::changes::touch::{STAYS, Touched, VANISHED};
use crate::analysis::periodic::branch::onward::side_that_holds;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::Solved;
use crate::flow::GuardKind;
use crate::flow::leg::Jump;

/// A flight from an impact to rest that takes less than this part of the period is about to come to nothing.
const SHORT: f64 = 1e-2;
/// The force of a contact vanishes first where a step ends if it does no farther away than this part of the longest step.
const AT_ITS_END: f64 = 1e-6;
/// Special points are looked for up to the first of these parts of the way to there.
const NEARLY: [f64; 3] = [0.9, 0.5, 0.1];

impl Shooting<f64> {
    /// The flight that is about to come to nothing, if there is one, the contact that it is off, and where the rest is that it is beside.
    fn flight_that_vanishes(&self, at: &[f64]) -> Option<(usize, usize, Beside)> {
        let before =
            (self.flight_to_rest()).map(|(index, contact)| (index, contact, Beside::Start));
        let after = || {
            let (index, contact) = self.flight_to_corner(at)?;
            Some((index, contact, Beside::End))
        };
        before.or_else(after)
    }

    /// The flight from a release to a corner that would throw the contact off by itself, if it takes no time any more or is no higher than rounding,
    /// and that contact.
    fn flight_to_corner(&self, at: &[f64]) -> Option<(usize, usize)> {
        (0..self.steps.len()).find_map(|index| {
            let before = self.before(index);
            let Some(GuardKind::Reaction(contact)) = self.steps[before].ends_at() else {
                return None;
            };
            let lasts = self.latest.get(index)?.duration;
            let opens = !self.holds(index, contact) && !self.holds(self.after(index), contact);
            let is_one = opens
                && before != index
                && matches!(self.steps[before].passage, Passage::Leg(_))
                && self.ends_at_corner(index, contact)
                && (lasts < VANISHED * self.period() || !self.is_high(at, (index, contact)));
            is_one.then_some((index, contact))
        })
    }

    /// Whether a flight ends farther from the contact than rounding tells.
    fn is_high(&self, at: &[f64], (index, contact): (usize, usize)) -> bool {
        let model = &self.workshop.model;
        let parameters = self.workshop.parameters(self.free(at));
        let end = self.after(index);
        let gap = model.contacts[contact].gap;
        let height: f64 = (model.graph).evaluate(gap, self.node(at, end), &parameters);
        let (_, terms) = self.gap_rate(at, (end, contact));
        is_told(height.abs(), terms, LEAST_HEIGHT)
    }

    /// Whether a step ends at a corner of the field that may throw a contact off, and with nothing else: not where the sliding of that contact turns,
    /// which has no friction once it is released.
    fn ends_at_corner(&self, index: usize, contact: usize) -> bool {
        let Passage::Leg(kind) = self.steps[index].passage else {
            return false;
        };
        let corner = matches!(
            kind.ends_at,
            Some(GuardKind::Switch(_) | GuardKind::Piece(..))
        );
        let turns = || { kind.ends_at }.is_some_and(|guard| self.is_turn(contact, guard));
        corner && kind.jump == Jump::None && !turns()
    }

    /// The flight from a plastic impact to rest on the same contact that takes next to no time, or less than none, and that contact.
    fn flight_to_rest(&self) -> Option<(usize, usize)> {
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

    /// Whether such a flight takes no time any more, but for rounding: the equations may be solved by it wherever the curve goes on.
    pub(in crate::analysis::periodic::branch) fn flight_has_vanished(&self, at: &[f64]) -> bool {
        self.flight_that_vanishes(at)
            .is_some_and(|(index, ..)| self.latest[index].duration < VANISHED * self.period())
    }

    /// Whether what no longer holds is such a flight, or a step beside it.
    pub(in crate::analysis::periodic::branch) fn flight_breaks(
        &self,
        at: &[f64],
        broken: &Broken,
    ) -> bool {
        self.flight_that_vanishes(at).is_some_and(|(index, ..)| {
            [self.before(index), index, self.after(index)].contains(&broken.step())
        })
    }

    /// Whether a contact is closed all along a step.
    pub(in crate::analysis::periodic::branch) fn holds(
        &self,
        index: usize,
        contact: usize,
    ) -> bool {
        let origin = self.workshop.system.origin_of(self.steps[index].mode());
        origin.is_some_and(|(grip, ..)| grip.closed.contains(contact))
    }

    /// Where the force of a contact vanishes as a step begins to rest on it, or as that ends.
    fn rests_without_force(mut self, start: &[f64], rests: Rests) -> Result<Touched, String> {
        let Rests { index, contact, .. } = rests;
        let guard = GuardKind::Reaction(contact);
        let known = match rests.beside {
            Beside::Start => self.watch_start(index, guard),
            Beside::End => self.watch_corner(index, guard),
        };
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
            return Err("where a rest is without a force only another place is found".to_owned());
        }
        let index = match rests.beside {
            Beside::Start => self.before(index),
            Beside::End => index,
        };
        Ok(Touched {
            index,
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
    /// On past where a flight beside a rest comes to nothing, with the rest alone: on the way to a station, so far ahead, or on from the latest one. None
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
        let (index, contact, beside) = self.shooting.flight_that_vanishes(&there.at)?;
        let place = self.shooting.duration_place(index)?;
        let shrinks = match ahead {
            Some(_) => there.at[place] < station.at[place],
            None => station.tangent[place] < 0.0,
        };
        if !shrinks {
            return None;
        }
        let without = self.shooting.without_flight(&there.at, (index, beside));
        let (shorter, guess, index) = without.ok()?;
        let rests = Rests {
            index,
            contact,
            beside,
        };
        let touched = shorter.rests_without_force(&guess, rests).ok()?;
        self.settle(station);
        let forward = self.heading_known(station);
        let (mut resting, at) = (touched.shooting.clone(), touched.at.clone());
        let there = Station::near(&mut resting, &at, at.len() - 1).ok()?;
        let next = side_that_holds(&mut resting, &there, &self.distances())?;
        let nearly = ahead.and_then(|(_, ahead)| {
            NEARLY.into_iter().find_map(|part| {
                let (nearly, _) = station.ahead(&mut self.shooting, part * ahead).ok()?;
                self.settle(&nearly);
                (!self.shooting.flight_has_vanished(&nearly.at)).then_some((nearly, part * ahead))
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
    pub(in crate::analysis::periodic::branch) fn flies_from_rest(
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
        let rests = Rests {
            index,
            contact,
            beside: Beside::Start,
        };
        let resting = self.shooting.clone();
        let touched = resting.rests_without_force(&station.at, rests)?;
        self.flies_beside(touched, rests, there)
    }

    /// The force of a contact vanishes just where a corner throws it off: from there on it is released before. The same.
    pub(in crate::analysis::periodic::branch) fn released_before_corner(
        &mut self,
        station: &Station,
        (index, contact): (usize, usize),
        there: &Point,
    ) -> Result<Station, String> {
        self.settle(station);
        let holds_on = self.shooting.holds(self.shooting.after(index), contact);
        if holds_on || !self.shooting.ends_at_corner(index, contact) {
            return Err("no corner throws off what rests there".to_owned());
        }
        let rests = Rests {
            index,
            contact,
            beside: Beside::End,
        };
        let touched = (self.shooting.clone()).rests_without_force(&station.at, rests)?;
        // On the way it may vanish before.
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        let off = touched
            .at
            .last()
            .map(|value| (value - station.parameter()).abs());
        let near = AT_ITS_END * self.limits.longest_step * scale + touched.error;
        if off.is_none_or(|off| off > near) {
            return Err("the contact is released before that corner".to_owned());
        }
        self.flies_beside(touched, rests, there)
    }

    /// The equations with a flight beside a rest from where that is without a force, at their first station.
    fn flies_beside(
        &mut self,
        touched: Touched,
        rests: Rests,
        there: &Point,
    ) -> Result<Station, String> {
        let (touch, at) = (touched.shooting.clone(), touched.at.clone());
        let period = touch.period();
        let next = STAYS.into_iter().find_map(|part| {
            let with = (rests, part * period);
            let (mut longer, guess, place) = touch.with_flight(&at, with).ok()?;
            let fixed = Condition::fixed(guess.len(), place, guess[place]);
            let found = newton(&mut longer, &guess, core::slice::from_ref(&fixed)).ok()?;
            let is_there = moved(&found.at, &guess, longer.scales()) <= SHORT
                && sequence_holds(&mut longer, &found.at);
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
