//! Impacts that lose their rates at once, as those at both walls of an orbit that is its own mirror image do. Where time is no matter a rate is a
//! square root over the parameter, and with two of them equations are singular there: two curves cross, of rates of like signs and of unlike ones.
//! With one of them alone they are not. With a clock rates are smooth, and orbits with each of the impacts, with both and with none begin there: the branch goes
//! on as its mirror image does, with those impacts that it had not, and without those that it had.

use super::graze::{THERE, moved, rate_grows};
use super::holds::{sequence_holds, touches_beside};
use super::touch::Touched;
use crate::analysis::continuation::{Curve, Problem, Station};
use crate::analysis::periodic::branch::special::Seed;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::branch::{Point, SpecialKind, Wanted};
use crate::analysis::periodic::orbit::Orbit;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::Least;

/// Impacts that are about to lose their rates have this part of what accelerations make.
const SLOW: f64 = 1e-2;
/// A step of this length from where impacts come in tells whether the motion has them.
const PROBE: f64 = 1e-4;

impl Shooting<f64> {
    /// The slowest impact of each contact, of those that may be about to lose their rates; the slowest of all comes first. Faster ones of the same contact are
    /// impacts before it, as of chatter.
    fn slowest_of_each(&self) -> Vec<usize> {
        let rate = |index: usize| self.latest[index].surface_rate.abs();
        let mut slow = self.slower_than(SLOW);
        slow.sort_by(|&a, &b| rate(a).total_cmp(&rate(b)));
        let mut struck = Vec::with_capacity(slow.len());
        slow.retain(|&index| {
            let contact = self.steps[index].impact();
            let is_first = !struck.contains(&contact);
            struck.push(contact);
            is_first
        });
        slow
    }

    /// The graze of one of the impacts that are about to lose their rates, by equations without the others, which touch there as well, and how many
    /// those are. None where no others do.
    fn graze_together(&self, at: &[f64]) -> Option<(Touched, usize)> {
        let others = self.slowest_of_each().len().checked_sub(1);
        let others = others.filter(|&others| others > 0)?;
        let (mut fewer, mut guess) = (self.clone(), at.to_vec());
        let mut contacts = Vec::with_capacity(others);
        for _ in 0..others {
            fewer.evaluate(&guess).ok()?;
            let is_new = |&k: &usize| {
                fewer.steps[k]
                    .impact()
                    .is_some_and(|of| !contacts.contains(&of))
            };
            let other = { fewer.slowest_of_each().into_iter() }
                .filter(is_new)
                .max()?;
            contacts.push(fewer.steps[other].impact()?);
            (fewer, guess, _) = fewer.without_event(&guess, other).ok()?;
        }
        fewer.evaluate(&guess).ok()?;
        let index = *fewer.slowest_of_each().first()?;
        let scales = fewer.scales().to_vec();
        let mut touched = Touched::solve((fewer, guess.clone(), index)).ok()?;
        // Those that are left out were there with the rates that they had.
        if moved(&touched.at, &guess, &scales) > SLOW {
            return None;
        }
        touched.shooting.evaluate(&touched.at).ok()?;
        let mut touching = touches_beside(&mut touched.shooting, &touched.at, index).ok()?;
        let all = contacts.iter().all(|&contact| {
            let own = |(_, least): &(usize, Least)| least.guard == GuardKind::Gap(contact);
            let place = touching.iter().position(own);
            place.map(|place| touching.swap_remove(place)).is_some()
        });
        all.then_some((touched, others))
    }
}

impl Shooting<f64> {
    /// How many impacts it has that are followed one by one.
    pub(super) fn struck(&self) -> usize {
        let steps = self.steps.iter();
        steps.filter(|step| step.impact().is_some()).count()
    }

    /// Whether a clock says when what happens: rates of impacts are smooth over the parameter.
    fn has_clock(&self) -> bool {
        self.workshop.closure.time.is_some() || self.counts.iter().any(|&count| count != 0)
    }

    /// Whether others may touch where an impact grazes by equations that are regular with them: where there are others, and a clock.
    fn may_touch_together(&self) -> bool {
        self.workshop.model.contacts.len() > 1 && self.has_clock()
    }

    /// The other contacts that touch where an impact of an orbit grazes. None where the same contact touches once more: that is the same orbit a turn later, or
    /// backwards in time.
    fn that_touch(&mut self, at: &[f64], own: usize) -> Option<Vec<GuardKind>> {
        self.evaluate(at).ok()?;
        let all = touches_beside(self, at, own).ok()?.into_iter();
        let gaps = |guard: &GuardKind| matches!(guard, GuardKind::Gap(_));
        let others: Vec<GuardKind> = all.map(|(_, least)| least.guard).filter(gaps).collect();
        let contact = self.steps[own].impact().map(GuardKind::Gap);
        (others.iter().all(|other| Some(*other) != contact)).then_some(others)
    }

    /// A graze with an impact wherever other contacts touch as well, and without its own if that goes out. None where no others touch.
    fn with_others_that_touch(&self, touched: &Touched, goes_out: bool) -> Option<Touched> {
        // As well as it is known: what touches as well does so to rounding.
        let (mut longer, mut at, mut own) = (
            touched.shooting.clone(),
            touched.told.clone(),
            touched.index,
        );
        let others = longer.that_touch(&at, own)?;
        if others.is_empty() {
            return None;
        }
        for other in others {
            longer.evaluate(&at).ok()?;
            let all = touches_beside(&mut longer, &at, own).ok()?;
            let (k, least) = { all.into_iter() }.find(|(_, least)| least.guard == other)?;
            let count = longer.steps.len();
            let (with, guess, _) = match least.guard {
                GuardKind::Gap(contact) if least.at_end => {
                    longer.with_impact_at_turn(&at, (k, contact))
                }
                _ => longer.with_event(&at, k, &least),
            }
            .ok()?;
            if k <= own {
                own += with.steps.len() - count;
            }
            (longer, at) = (with, guess);
        }
        if goes_out {
            longer.evaluate(&at).ok()?;
            (longer, at, _) = longer.without_event(&at, own).ok()?;
        }
        longer.evaluate(&at).ok()?;
        let first = longer.without_rate()?;
        let scales = longer.scales().to_vec();
        let found = Touched::solve((longer, at.clone(), first)).ok()?;
        (moved(&found.at, &at, &scales) <= THERE).then_some(found)
    }
}

impl Walker {
    /// On without impacts that lose their rates at once. None where there are no such.
    pub(super) fn lose_together(&mut self, station: &Station, there: &Point) -> Option<Station> {
        let (touched, others) = self.shooting.graze_together(&station.at)?;
        let told = self.special.len();
        let (at, index, alone) = (touched.at.clone(), touched.index, touched.clone());
        let before = core::mem::replace(&mut self.shooting, touched.shooting);
        // Each is told, with as many impacts as are left.
        for left in 1..=others as u64 {
            let (error, residual) = (touched.error, touched.residual);
            self.note(
                SpecialKind::ImpactGraze,
                there,
                &touched.told,
                error,
                residual,
            );
            self.tell_no_multipliers();
            if let Some(special) = self.special.last_mut() {
                special.point.impacts = there.impacts.map(|all| all.saturating_sub(left));
            }
        }
        let Ok(next) = self.without(&at, (index, None), there) else {
            self.special.truncate(told);
            self.shooting = before;
            self.settle(station);
            return None;
        };
        if let Some((last, all)) = self.special[told..].split_last_mut() {
            for special in all {
                special.kind = last.kind;
                special
                    .point
                    .multipliers
                    .clone_from(&last.point.multipliers);
                special.point.modulus_error = last.point.modulus_error;
            }
            let left = |all: u64| all.saturating_sub(others as u64 + 1);
            last.point.impacts = there.impacts.map(left);
        }
        if self.shooting.has_clock() {
            self.leaves_by(told, &alone);
        }
        Some(next)
    }

    /// On from a graze with impacts at all contacts that touch at once, where a clock says when. None where no others do.
    pub(super) fn gain_together(
        &mut self,
        station: &Station,
        touched: &Touched,
        there: &Point,
    ) -> Option<Station> {
        if !self.shooting.may_touch_together() {
            return None;
        }
        let all = self.shooting.with_others_that_touch(touched, false)?;
        let count = all.shooting.struck() - self.shooting.struck();
        let told = self.special.len();
        let next = self.comes_in_together(station, all, there)?;
        self.leaves_by(told, touched);
        // Each is told, with as many impacts as have come in before it.
        let known = self.special.get(told).cloned()?;
        for more in 1..count as u64 {
            let mut special = known.clone();
            special.point.impacts = special.point.impacts.map(|impacts| impacts + more);
            self.special.push(special);
        }
        Some(next)
    }

    /// How many others touch at a graze, where a clock says when.
    pub(super) fn others_that_touch(&self, touched: &Touched) -> usize {
        let mut shooting = touched.shooting.clone();
        let others = self.shooting.may_touch_together();
        let others = others.then(|| shooting.that_touch(&touched.told, touched.index));
        others.flatten().map_or(0, |others| others.len())
    }

    /// On from a graze of several contacts at once, the first of which is told at this place, where equations with all of their impacts are singular: what
    /// each leaves of itself is the square of its rate, as where friction holds the rest. With an orbit that the motion has beyond.
    pub(super) fn gain_beyond(
        &mut self,
        station: &Station,
        (told, others): (usize, usize),
        there: &Point,
    ) -> Option<Station> {
        let impacts = there.impacts?.checked_add(1 + others as u64)?;
        let wanted = Wanted {
            infinite: Some(false),
            is_it: |orbit: &Orbit| orbit.impacts == Some(impacts),
        };
        let distances = self.distances();
        let next = self.beyond(station, &distances, &wanted)?;
        let known = self.special.get(told).cloned()?;
        for more in 1..=others as u64 {
            let mut special = known.clone();
            special.point.impacts = special.point.impacts.map(|impacts| impacts + more);
            self.special.push(special);
        }
        Some(next)
    }

    /// On from where an impact loses its rate with impacts at all others that touch there, where a clock says when: those of the mirror image. None where no
    /// others do.
    pub(super) fn give_way(
        &mut self,
        station: &Station,
        index: usize,
        there: &Point,
    ) -> Option<Station> {
        if !self.shooting.may_touch_together() {
            return None;
        }
        let scales = self.shooting.scales().to_vec();
        let own = Touched::solve((self.shooting.clone(), station.at.clone(), index)).ok()?;
        if moved(&own.at, &station.at, &scales) > THERE {
            return None;
        }
        let others = self.shooting.with_others_that_touch(&own, true)?;
        let all = self.shooting.with_others_that_touch(&own, false)?;
        let told = self.special.len();
        let next = self.comes_in_together(station, others, there)?;
        self.leaves_by(told, &all);
        if let Some(special) = self.special.get_mut(told) {
            special.point.impacts = there.impacts.map(|impacts| impacts.saturating_sub(1));
        }
        Some(next)
    }

    /// Tells of a special point which equations those orbits have that leave the branch there, and in which direction: with other ones of the impacts. Of none if
    /// the motion has no such.
    fn leaves_by(&mut self, place: usize, with: &Touched) {
        let mut shooting = with.shooting.clone();
        let Ok(along) = rate_grows(&mut shooting, &with.at, with.index) else {
            return;
        };
        let next = Station {
            at: with.at.clone(),
            tangent: along,
            residual: with.residual,
            correction: with.correction,
            orientation: 0.0,
        };
        if let Some(special) = self
            .special
            .get_mut(place)
            .filter(|_| begins(&shooting, &next))
        {
            special.leaves = next.tangent;
            special.seed = Some(Seed {
                shooting,
                at: next.at,
            });
        }
    }

    /// On with impacts that come in with no rate yet, as far as the motion has them.
    fn comes_in_together(
        &mut self,
        station: &Station,
        touched: Touched,
        there: &Point,
    ) -> Option<Station> {
        let (told, before) = (self.special.len(), self.shooting.clone());
        let next = self.impact_comes_in(station, touched, there).ok();
        let holds = next.filter(|next| begins(&self.shooting, next));
        if holds.is_none() {
            self.special.truncate(told);
            self.shooting = before;
            self.settle(station);
        }
        holds
    }

    /// The same where steps towards that place come to nothing. Whether that is so.
    pub(in crate::analysis::periodic::branch) fn grazes_end(
        &mut self,
        curve: &mut Curve,
        here: &mut Point,
    ) -> bool {
        let (station, told) = (curve.station.clone(), self.special.len());
        self.settle(&station);
        let forward = self.heading_known(&station);
        let next = self.lose_together(&station, &here.clone());
        let ends = next
            .is_some_and(|next| matches!(self.goes_on(Ok(next), (curve, forward), here), Stop::On));
        if !ends {
            self.special.truncate(told);
            self.settle(&station);
        }
        ends
    }
}

/// Whether a curve leads from a station to orbits that the motion has.
pub(super) fn begins(shooting: &Shooting<f64>, station: &Station) -> bool {
    let mut reader = shooting.clone();
    let ahead = station.ahead(&mut reader, PROBE);
    ahead.is_ok_and(|(ahead, _)| sequence_holds(&mut reader, &ahead.at))
}
