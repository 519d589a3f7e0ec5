//! Multipliers next to rounding: where longer numbers tell them, and whether what they do along a way is more than that.

use super::Point;
use super::changes::graze::{SMALL_HEIGHT, is_told};
use super::changes::touch::VANISHED;
use super::walker::Walker;
use crate::analysis::continuation::Station;
use crate::analysis::periodic::multipliers::farthest;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::numerics::Complex;

/// Where the square of a modulus may be off by this part multipliers are asked in longer numbers.
const COARSE: f64 = 1e-6;
/// Flights that are hardly higher than rounding of the gap are shorter than this part of the period.
const SHORT: f64 = 1e-2;

/// Right beside a station is this part of the way to the next, or what rounding leaves of a way; so many stations there are asked, and where multipliers
/// change to one of them by this part of what they do on all of the way rounding does it.
const RIGHT_BESIDE: f64 = 1e-4;
const ROUNDED_STEP: f64 = 1e-12;
const SAMPLES: u32 = 3;
const CHANGES: f64 = 0.1;

impl Shooting<f64> {
    /// Multipliers at a station that was evaluated, and what their moduli may be off by. Impacts are told from each other by what gaps are between
    /// them: where that is hardly more than rounding of the nodes, or where entries of the matrix are so large that rounding of these shows, multipliers are
    /// those of the solution in longer numbers.
    pub(in crate::analysis::periodic) fn multipliers_at(
        &self,
        station: &Station,
    ) -> (Vec<Complex>, f64) {
        let known = self.multipliers_known();
        let largest = known.0.first().map_or(0.0_f64, |m| m.modulus());
        let is_coarse = known.1.is_finite() && known.1 > COARSE * largest.max(1.0).powi(2);
        let longer = (is_coarse || self.has_low_flight(&station.at))
            .then(|| self.multipliers_beside(station));
        longer.flatten().unwrap_or(known)
    }

    /// Whether a flight from one impact of a contact to the next is hardly higher than rounding of the gap.
    pub(super) fn has_low_flight(&self, at: &[f64]) -> bool {
        let short = SHORT * self.period();
        (self.steps.iter().zip(&self.latest).enumerate()).any(|(index, (step, landing))| {
            let before = self.steps[self.before(index)].impact();
            let Some(contact) = step.impact().filter(|_| landing.duration < short) else {
                return false;
            };
            let height = landing.surface_acceleration.abs() * landing.duration.powi(2) / 8.0;
            before == Some(contact)
                && step.has_own_time()
                && !is_told(height, self.gap_rate(at, (index, contact)).1, SMALL_HEIGHT)
        })
    }

    /// The step that a flight begins with which comes to its end with another one: that before, if it is across the surface that its rate turns with, as
    /// that of friction.
    pub(super) fn flight_begins(&self, end: usize) -> usize {
        let before = self.before(end);
        if self.turns(before) { before } else { end }
    }

    /// Whether the way between the last impact and a touch of the same contact is higher than so many roundoffs of the gap.
    pub(super) fn is_resolved(
        &mut self,
        at: &[f64],
        (index, contact): (usize, usize),
        roundoffs: f64,
    ) -> bool {
        let begin = self.flight_begins(index);
        let before = self.before(begin);
        let follows = self.steps[before].impact() == Some(contact);
        let Ok(least) = self.least(at) else {
            return true;
        };
        let touch = least[index]
            .iter()
            .find(|l| l.guard == GuardKind::Gap(contact) && !l.at_end);
        let (Some(touch), true) = (touch, follows) else {
            return true;
        };
        let place = (begin, contact);
        let (rate, terms) = self.gap_rate(at, place);
        // From zero with this rate, and back to where both vanish: a cubic; a quartic from where a plastic impact leaves no rate; up to where it turns.
        let height = match self.is_plastic((before, contact)) {
            true => self.gap_acceleration(at, place) * touch.time.powi(2) / 32.0,
            false if begin != index => 0.5 * (rate * self.latest[begin].duration).abs(),
            false => 4.0 / 27.0 * (rate * touch.time).abs(),
        };
        is_told(height, terms, roundoffs)
    }

    /// Whether a flight from one impact of a contact to the next takes no time: what comes in after it as a stay would be over as it begins.
    pub(super) fn has_brief_flight(&self) -> bool {
        (0..self.steps.len()).any(|end| {
            let begin = self.flight_begins(end);
            let contact = self.steps[end].impact();
            let follows = contact.is_some() && self.steps[self.before(begin)].impact() == contact;
            let of = |index: usize| self.latest.get(index).map_or(0.0, |l| l.duration);
            let whole = of(end) + if begin == end { 0.0 } else { of(begin) };
            follows && self.steps[end].has_own_time() && whole < VANISHED * self.period()
        })
    }
}

impl Walker {
    /// Whether multipliers change on the way from one station to another, with an orbit in between, by no more than rounding makes of them, as where flights
    /// are hardly higher than rounding of the gap: then they change as much from either end to stations right beside it, and parts of the way show ever more
    /// of that.
    pub(super) fn is_rounding(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        [here, halfway, there]: [&Point; 3],
    ) -> bool {
        if self.shooting.has_low_flight(&from.at) {
            return false;
        }
        let halves = [here, there].map(|end| farthest(&end.multipliers, &halfway.multipliers));
        let change = halves[0].max(halves[1]);
        let beside = (RIGHT_BESIDE * step).max(ROUNDED_STEP);
        let changes = |walker: &mut Self, station: &Station, point: &Point, ahead: f64| {
            let Ok((next, _)) = station.ahead(&mut walker.shooting, ahead) else {
                return false;
            };
            walker.settle(&next);
            let (multipliers, _) = walker.shooting.multipliers_at(&next);
            farthest(&point.multipliers, &multipliers) > CHANGES * change
        };
        let mut ends = [(from, here, beside), (to, there, -beside)].into_iter();
        change > 0.0
            && ends.all(|(station, point, beside)| {
                (1..=SAMPLES).any(|k| changes(self, station, point, f64::from(k) * beside))
            })
    }
}
