//! Kinks of gaps, as the bottom of a valley `y - abs(x)`: where a contact would come to rest on one it is held from both sides, and that is
//! two contacts.

use super::{Candidate, Corner};
use crate::flow::error::FlowError;
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::start::slack;
use crate::numerics::{Real, WithTerms};

/// More crossings than so many with no more than so many instants between them do not come to an end: what bounces in a valley comes to
/// its bottom by infinitely many, ever sooner, and rounding goes on with them there.
const MOST_CROSSINGS: u32 = 256;
const INSTANTS: f64 = 32.0;

/// Crossings of kinks since flights between them could be told from none.
#[derive(Clone, Copy, Debug)]
pub(in crate::flow::trajectory) struct Crossings<R> {
    count: u32,
    since: R,
}

impl<R: Real> Crossings<R> {
    pub(in crate::flow::trajectory) fn none(time: R) -> Self {
        Self {
            count: 0,
            since: time,
        }
    }
}

impl<R: Real> Trajectory<R> {
    /// Takes note of a corner that was met.
    pub(super) fn note_kink(&mut self, system: &System, corner: Corner) -> Result<(), FlowError> {
        let Corner::Surface(surface) = corner else {
            return Ok(());
        };
        let Some(contact) = system.kinks_of(surface).contacts().next() else {
            return Ok(());
        };
        let within = self.instant() * R::splat(INSTANTS * f64::from(MOST_CROSSINGS));
        if (self.time - self.crossings.since).abs() > within {
            self.crossings = Crossings::none(self.time);
        }
        self.crossings.count += 1;
        match self.crossings.count > MOST_CROSSINGS {
            true => Err(self.held_from_both_sides(system, (contact, surface))),
            false => Ok(()),
        }
    }

    /// That no motion goes on from these corners, as a contact is touched on a kink of its gap, if one is.
    pub(super) fn rest_on_kink(&self, system: &System, touched: &[Corner]) -> Option<FlowError> {
        let touch = self.touch_values(system).ok()?;
        let instant = self.instant();
        let is_touched = |&contact: &usize| {
            let moved = R::splat(touch.rate[contact].terms) * instant;
            touch.gap[contact].value <= slack(&touch.gap[contact]).max(moved)
        };
        touched.iter().find_map(|&corner| {
            let Corner::Surface(surface) = corner else {
                return None;
            };
            let contact = system.kinks_of(surface).contacts().find(is_touched)?;
            Some(self.held_from_both_sides(system, (contact, surface)))
        })
    }

    /// That what has come to rest on a kink of its gap would go on beyond it, as if nothing had held it: which of its sides holds it there is
    /// for two contacts to say. Asked in the mode that it has come in.
    pub(super) fn leaves_kink(
        &self,
        system: &System,
        (before, after): (&Candidate, &Candidate),
    ) -> Result<Option<FlowError>, FlowError> {
        let rests = |[value, rate]: [&WithTerms<R>; 2]| {
            value.value.abs() <= value.level() && rate.value.abs() <= rate.level()
        };
        for standing in self.standings(system)? {
            let (Corner::Surface(surface), [(_, [value, rate, ..])]) =
                (standing.corner, &standing.guards[..])
            else {
                continue;
            };
            if before.side(surface) == after.side(surface) || !rests([value, rate]) {
                continue;
            }
            for contact in system.kinks_of(surface).contacts() {
                let [gap, rate, acceleration] = self.local_up_to(system, contact)?;
                let presses = acceleration.value < -acceleration.level();
                if !self.closed.contains(contact) && rests([&gap, &rate]) && presses {
                    return Ok(Some(self.held_from_both_sides(system, (contact, surface))));
                }
            }
        }
        Ok(None)
    }

    fn held_from_both_sides(
        &self,
        system: &System,
        (contact, surface): (usize, usize),
    ) -> FlowError {
        FlowError::RestsOnKink {
            time: self.time.to_f64(),
            contact,
            surface: system.corner_name(Corner::Surface(surface)),
        }
    }
}
