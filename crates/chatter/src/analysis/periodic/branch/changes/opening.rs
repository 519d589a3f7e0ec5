//! Where a contact at rest begins to open for a while, or no longer does.

use super::touch::Touched;
use crate::analysis::continuation::{Curve, Problem, Station};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::onward::{CAREFUL, Wanted, touch_between};
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::orbit::Orbit;
use crate::flow::GuardKind;
use crate::flow::leg::Least;

/// A branch whose steps have come to nothing is this near to what it has come to, in parts of the longest one.
const THERE: f64 = 1e-6;

impl Walker {
    /// The force of a closed contact touches zero: beyond, the contact opens for a while, and closes again by chatter that begins
    /// with nothing. The equations there, at a station a little farther on.
    pub(super) fn opens(
        &mut self,
        station: &Station,
        touch: (usize, &Least),
        there: &Point,
    ) -> Result<Station, String> {
        let touched = self.touched(&station.at, touch)?;
        self.opens_beyond(station, touched, there)
    }

    fn opens_beyond(
        &mut self,
        station: &Station,
        touched: Touched,
        there: &Point,
    ) -> Result<Station, String> {
        self.note_touch(there, touched);
        let accumulations = self.shooting.accumulations();
        let opens = |orbit: &Orbit| {
            orbit.impacts != there.impacts || orbit.shooting.accumulations() > accumulations
        };
        let wanted = Wanted {
            infinite: None,
            is_it: opens,
        };
        let next = self.beyond(station, &self.distances(), &wanted);
        next.ok_or_else(|| "a contact opens there, and no orbit is found beyond".to_owned())
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
        let touched = self.touched(&station.at, (*index, least)).ok()?;
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
        // From where the contact is released, and beyond is not.
        let releases = self.shooting.steps.iter().enumerate();
        let released = releases.filter_map(|(index, step)| match step.ends_at() {
            Some(GuardKind::Reaction(contact)) => Some((index, contact)),
            _ => None,
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
        let Some(touched) = touch_between(&mut self.shooting, &next.at, between, is_force) else {
            self.shooting = before;
            return false;
        };
        // Told of the orbit that stays.
        let resting = Point::new(&mut self.shooting, &next);
        self.note_passed_touch(&resting, touched);
        self.begins_anew((next, CAREFUL * self.limits.longest_step), curve, here);
        true
    }
}
