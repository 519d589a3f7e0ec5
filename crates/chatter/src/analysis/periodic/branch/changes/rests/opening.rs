//! Where a contact at rest begins to open for a while, or no longer does.

use crate::analysis::continuation::{Curve, Problem, Station};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::changes::touch::Touched;
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::onward::{CAREFUL, Wanted, touch_between};
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::orbit::Orbit;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::Solved;
use crate::flow::GuardKind;
use crate::flow::leg::Least;

/// A branch whose steps have come to nothing is this near to what it has come to, in parts of the longest one, or where nothing but rounding is left
/// of its chatter, in parts of the range.
const THERE: f64 = 1e-6;

impl Walker {
    /// The force of a closed contact touches zero: beyond, the contact opens for a while, and closes again by chatter that begins
    /// with nothing. The equations there, at a station a little farther on.
    pub(in crate::analysis::periodic::branch) fn opens(
        &mut self,
        station: &Station,
        touch: (usize, &Least),
        there: &Point,
    ) -> Result<Station, String> {
        let touched = self.shooting.touched(&station.at, touch)?;
        self.opens_beyond(station, touched, there)
    }

    fn opens_beyond(
        &mut self,
        station: &Station,
        touched: Touched,
        there: &Point,
    ) -> Result<Station, String> {
        self.note_touch(there, touched);
        self.goes_on_open(station, there)
    }

    /// The same where that force vanishes just where a step begins or ends, as where friction turns.
    pub(in crate::analysis::periodic::branch) fn opens_at_event(
        &mut self,
        station: &Station,
        (index, contact): (usize, usize),
        there: &Point,
    ) -> Result<Station, String> {
        self.settle(station);
        let met = force_at_event(&mut self.shooting.clone(), &station.at, (index, contact))?;
        self.note_met(there, &met);
        self.goes_on_open(station, there)
    }

    /// The orbit beyond, which opens for a while.
    fn goes_on_open(&mut self, station: &Station, there: &Point) -> Result<Station, String> {
        let accumulations = self.shooting.accumulations();
        let opens = |orbit: &Orbit| {
            orbit.impacts != there.impacts || orbit.shooting.accumulations() > accumulations
        };
        let wanted = Wanted {
            infinite: None,
            is_it: opens,
        };
        let resting = self.shooting.clone();
        let later = self.told_away_from(station);
        let next = self.beyond(
            later.as_ref().unwrap_or(station),
            &self.distances(),
            &wanted,
        );
        next.ok_or_else(|| {
            self.shooting = resting;
            "a contact opens there, and no orbit is found beyond".to_owned()
        })
    }

    /// The same station of an orbit on which nothing happens, told half a period later where it is told from about the instant at which a contact begins
    /// to open: beyond, it is not at rest there.
    fn told_away_from(&mut self, station: &Station) -> Option<Station> {
        let [only] = &self.shooting.steps[..] else {
            return None;
        };
        if !matches!(only.passage, Passage::Timed(_)) {
            return None;
        }
        let period = self.shooting.period();
        let least = self.shooting.least(&station.at).ok()?;
        let forces = least.iter().flatten();
        let forces = forces.filter(|least| matches!(least.guard, GuardKind::Reaction(_)));
        let opens = forces.min_by(|a, b| a.value.total_cmp(&b.value))?;
        if (opens.time - 0.5 * period).abs() < 0.25 * period {
            return None;
        }
        let (mut shooting, at) = self.shooting.told_later(&station.at, 0.5 * period)?;
        let later = Station::near(&mut shooting, &at, at.len() - 1).ok()?;
        self.shooting = shooting;
        let forward = station.parameter_slope() >= 0.0;
        Some(if forward { later } else { later.reversed() })
    }

    /// The same where that force is one on the way of what is followed as a whole: beyond, that would end too soon, so steps towards the touch come to
    /// nothing. None where it is something else that they have come to.
    pub(in crate::analysis::periodic::branch) fn begins_to_open(
        &mut self,
        curve: &mut Curve,
        here: &mut Point,
    ) -> Option<Stop> {
        let station = curve.station.clone();
        let forces = self.shooting.least_forces(&station.at).ok()?;
        let (index, least) = (forces.iter())
            .min_by(|a, b| (a.1.value / a.1.size).total_cmp(&(b.1.value / b.1.size)))?;
        let touched = self.shooting.touched(&station.at, (*index, least)).ok()?;
        let scale = self.shooting.scales().last().copied()?;
        let off = (touched.at.last()? - station.parameter()).abs();
        if off > THERE * self.limits.longest_step * scale + touched.error {
            return None;
        }
        self.settle(&station);
        let forward = self.heading_known(&station);
        let outcome = self.opens_beyond(&station, touched, &here.clone());
        Some(match self.goes_on(outcome, (curve, forward), here) {
            Stop::End(end @ End::Lost(_)) => Stop::Over(end),
            other => other,
        })
    }

    /// The same from the other side: chatter has shrunk to nothing, and beyond the contact stays closed. Whether that is so.
    pub(in crate::analysis::periodic::branch) fn stays_closed(
        &mut self,
        curve: &mut Curve,
        here: &mut Point,
    ) -> bool {
        let before = self.shooting.clone();
        let distances = self.distances();
        let accumulations = self.shooting.accumulations();
        let another = |orbit: &Orbit| {
            orbit.impacts != here.impacts || orbit.shooting.accumulations() < accumulations
        };
        let wanted = Wanted {
            infinite: None,
            is_it: another,
        };
        // From where the contact is released, if only by the corner at the end of a step, and beyond is not.
        let contacts = self.shooting.workshop.model.contacts.len();
        let released = (0..self.shooting.steps.len()).filter_map(|index| {
            let next = self.shooting.after(index);
            let opens = |&contact: &usize| {
                self.shooting.holds(index, contact) && !self.shooting.holds(next, contact)
            };
            Some((index, (0..contacts).find(opens)?))
        });
        let released: Vec<(usize, usize)> = released.collect();
        let resting = released.iter().find_map(|&(index, contact)| {
            let closed = self.shooting.steps[index].closed.with(contact);
            let begin = (self.shooting.after(index), closed);
            let over = self.over_the_parameter(&curve.station);
            self.beyond_from(&over, &distances, begin, &wanted)
        });
        let Some(next) = resting.or_else(|| self.beyond(&curve.station, &distances, &wanted))
        else {
            return false;
        };
        let between = [curve.station.parameter(), next.parameter()];
        let is_force = |guard| matches!(guard, GuardKind::Reaction(_));
        let touched = touch_between(&mut self.shooting, &next.at, between, is_force);
        // Told of the orbit that stays.
        let resting = Point::new(&mut self.shooting, &next);
        match touched {
            Some(touched) => self.note_passed_touch(&resting, touched),
            None => {
                let met = least_force_at_events(&mut self.shooting, &next.at, between);
                let Some(met) = met else {
                    self.shooting = before;
                    return false;
                };
                self.settle(&next);
                self.note_met(&resting, &met);
                if let Some(special) = self.special.last_mut() {
                    special.persists = Some(true);
                }
            }
        }
        self.begins_anew((next, CAREFUL * self.limits.longest_step), curve, here);
        true
    }
}

/// Where the force of a contact at rest vanishes at one of the ends of a step: at the one where it is less.
fn force_at_event(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    place: (usize, usize),
) -> Result<Solved, String> {
    least_force_vanishes(shooting, at, [(place, false), (place, true)])
}

/// Where the force vanishes that is least among those at such ends of steps.
fn least_force_vanishes(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    ends: impl IntoIterator<Item = ((usize, usize), bool)>,
) -> Result<Solved, String> {
    let known =
        (ends.into_iter()).filter_map(|end| Some((end, force_at_end(shooting, at, end)?.abs())));
    let least = known.min_by(|a, b| a.1.total_cmp(&b.1));
    let (least, _) = least.ok_or("a contact without a force")?;
    force_at_end(shooting, at, least).ok_or("a contact without a force")?;
    shooting.at_watched(at)
}

/// The force of a contact where a step starts, or ends, which is watched from there on.
fn force_at_end(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    ((index, contact), starts): ((usize, usize), bool),
) -> Option<f64> {
    if !shooting.holds(index, contact) {
        return None;
    }
    let guard = GuardKind::Reaction(contact);
    let known = match starts {
        true => shooting.watch_start(index, guard),
        false => shooting.watch_corner(index, guard),
    };
    known.ok()?;
    let (force, _) = shooting.monitor(shooting.corner_function(), at).ok()?;
    Some(force)
}

/// The same of the contact and the step where that is least, if it vanishes between two values of the parameter.
fn least_force_at_events(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    between: [f64; 2],
) -> Option<Solved> {
    let contacts = shooting.workshop.model.contacts.len();
    let places = (0..shooting.steps.len())
        .flat_map(|index| (0..contacts).map(move |contact| (index, contact)));
    let ends = places.flat_map(|place| [(place, true), (place, false)]);
    let met = least_force_vanishes(shooting, at, ends).ok()?;
    let (low, high) = (between[0].min(between[1]), between[0].max(between[1]));
    // The chatter of the orbits before has come to nothing in rounding, which their parameter is known to.
    let scale = shooting.scales().last().copied()?;
    let off = (high - low).max(met.error).max(THERE * scale);
    let value = met.told.last().copied()?;
    (low - off..=high + off).contains(&value).then_some(met)
}
