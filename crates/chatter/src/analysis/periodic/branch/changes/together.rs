//! Impacts that lose their rates at once, as those at both walls of an orbit that is its own mirror image do. Where time is no matter a rate is a
//! square root over the parameter, and with two of them equations are singular there: two curves cross, of rates of like signs and of unlike ones.
//! With one of them alone they are not.

use super::graze::moved;
use super::holds::touches_beside;
use super::touch::Touched;
use crate::analysis::continuation::{Curve, Problem, Station};
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::branch::{Point, SpecialKind};
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;

/// Impacts that are about to lose their rates have this part of what accelerations make.
const SLOW: f64 = 1e-2;

impl Shooting<f64> {
    /// The graze of one of the impacts that are about to lose their rates, by equations without the others, which touch there as well, and how many
    /// those are. None where no others do.
    fn graze_together(&self, at: &[f64]) -> Option<(Touched, usize)> {
        // With a clock rates are smooth.
        if self.workshop.closure.time.is_some() || self.counts.iter().any(|&count| count != 0) {
            return None;
        }
        let slow = self.slower_than(SLOW);
        let others = slow.len().checked_sub(1).filter(|&others| others > 0)?;
        // Several at one contact are chatter.
        let mut struck: Vec<_> = slow.iter().map(|&k| self.steps[k].impact()).collect();
        struck.sort_unstable();
        if struck.windows(2).any(|pair| pair[0] == pair[1]) {
            return None;
        }
        let (mut fewer, mut guess) = (self.clone(), at.to_vec());
        let mut contacts = Vec::with_capacity(others);
        for _ in 0..others {
            fewer.evaluate(&guess).ok()?;
            let other = *fewer.slower_than(SLOW).last()?;
            contacts.push(fewer.steps[other].impact()?);
            (fewer, guess, _) = fewer.without_event(&guess, other).ok()?;
        }
        fewer.evaluate(&guess).ok()?;
        let index = *fewer.slower_than(SLOW).first()?;
        let scales = fewer.scales().to_vec();
        let mut touched = Touched::solve((fewer, guess.clone(), index)).ok()?;
        // Those that are left out were there with the rates that they had.
        if moved(&touched.at, &guess, &scales) > SLOW {
            return None;
        }
        touched.shooting.evaluate(&touched.at).ok()?;
        let mut touching = touches_beside(&mut touched.shooting, &touched.at, index).ok()?;
        let all = contacts.iter().all(|&contact| {
            let own = |guard: &GuardKind| *guard == GuardKind::Gap(contact);
            let place = touching.iter().position(own);
            place.map(|place| touching.swap_remove(place)).is_some()
        });
        all.then_some((touched, others))
    }
}

impl Walker {
    /// On without impacts that lose their rates at once. None where there are no such.
    pub(super) fn lose_together(&mut self, station: &Station, there: &Point) -> Option<Station> {
        let (touched, others) = self.shooting.graze_together(&station.at)?;
        let told = self.special.len();
        let (at, index) = (touched.at.clone(), touched.index);
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
            }
            let left = |all: u64| all.saturating_sub(others as u64 + 1);
            last.point.impacts = there.impacts.map(left);
        }
        Some(next)
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
