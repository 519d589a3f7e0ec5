//! What a corner changes that the motion has met: sides, columns of derivatives, contacts that are closed.

use super::Standing;
use crate::expressions::Surfaces;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::{FOREVER, Workspace};
use crate::flow::system::System;
use crate::flow::touch::{Touch, with_terms};
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::start::{is_inside, slack};
use crate::numerics::{Real, WithTerms};

/// Switches without a flight longer than rounding between them: more than so many do not come to an end.
const MOST_SWITCHES: usize = 256;

impl<R: Real> Trajectory<R> {
    /// A corner was met by the motion itself; `jumps` where the field does there, which it does not where sliding ends.
    pub(in crate::flow::trajectory) fn meet_corner(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (corner, jumps): (Corner, bool),
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let is_top = jumps && self.is_top(system, corner)?;
        self.flight_time = R::splat(FOREVER);
        self.count_switch()?;
        self.note_kink(system, corner)?;
        // Sliding ends where its field is that of the side it ends to: columns go on as they are.
        let shifts = if jumps {
            self.corner_shifts(system, corner)?
        } else {
            Vec::new()
        };
        self.shift_columns(system, work, &shifts, R::ONE)?;
        self.met = Some(corner);
        self.met_with = self.vanishes_with(system, corner)?;
        let before = match system.gaps_have_corners() {
            true => Some(self.touch_values(system)?),
            false => None,
        };
        self.settle_corners(system, Some(corner))?;
        let goes_on = is_top || jumps && self.is_held_in_flight(system, corner);
        if !goes_on {
            self.tracker.interrupt();
            self.tops.interrupt();
        }
        if let Some(before) = before {
            self.follow_gaps(system, &before)?;
        }
        self.keep_contacts(system, work, &shifts)?;
        Ok(self.pending.pop_front())
    }

    /// What changes the mode without time passing comes to an end.
    pub(in crate::flow::trajectory) fn count_switch(&mut self) -> Result<(), FlowError> {
        self.burst += 1;
        match self.burst > MOST_SWITCHES {
            true => Err(FlowError::SwitchesWithoutEnd {
                time: self.time.to_f64(),
                count: self.burst,
            }),
            false => Ok(()),
        }
    }

    /// The surfaces that vanish with the one that is met, as closed contacts keep their rates the same: what rounding has left of each
    /// is the same part of how fast it moves.
    fn vanishes_with(&self, system: &System, corner: Corner) -> Result<Surfaces, FlowError> {
        let mut found = Surfaces::default();
        if self.closed == Closed::NONE {
            return Ok(found);
        }
        let standings = self.standings(system)?;
        let motion = |standing: &Standing<R>| match (standing.corner, &standing.guards[..]) {
            (Corner::Surface(index), [(_, [value, rate, ..])]) => {
                Some((index, value.value, rate.value))
            }
            _ => None,
        };
        let met = standings.iter().find(|standing| standing.corner == corner);
        let Some((own, value, rate)) = met.and_then(motion) else {
            return Ok(found);
        };
        for (index, other, its_rate) in standings.iter().filter_map(motion) {
            let (here, there) = (other * rate, value * its_rate);
            let least = R::splat(f64::MIN_POSITIVE) * (rate.abs() + its_rate.abs());
            let level = WithTerms::exact(here.abs() + there.abs()).level();
            if index != own && its_rate != R::ZERO && (here - there).abs() <= level.max(least) {
                found = found.with(index);
            }
        }
        Ok(found)
    }

    /// The shifts of the time of a crossing, one a column of derivatives.
    fn corner_shifts(&self, system: &System, corner: Corner) -> Result<Vec<R>, FlowError> {
        if self.state.len() == self.coordinates {
            return Ok(Vec::new());
        }
        let program = self.program(system)?;
        let found = (program.standings.iter()).position(|tapes| tapes.corner == corner);
        let (Some(place), Some(constants)) = (found, &self.constants[self.mode]) else {
            return Ok(Vec::new());
        };
        let start = (&self.state[..], &self.low[..]);
        let tapes = &program.standings[place];
        let slopes = with_terms(&tapes.slopes, &constants.standings[place][1], start);
        let values = with_terms(&tapes.values, &constants.standings[place][0], start);
        // The surface's own rate, whatever the sign of the guard.
        let sign = match (corner, tapes.guards.first()) {
            (Corner::Surface(index), _) => R::splat(self.regime.get(index).sign()),
            (Corner::Lookup(_), _) => R::ONE,
        };
        // No motion has led across a surface whose rate is none, but rounding of what an impact has made zero.
        if values[2].value.abs() <= values[2].level() {
            return Ok(Vec::new());
        }
        let rate = values[2].value * sign;
        Ok(slopes.iter().map(|slope| -(slope.value / rate)).collect())
    }

    /// A gap may have jumped: the contact is open then, or the state inside an obstacle.
    fn follow_gaps(&mut self, system: &System, before: &Touch<R>) -> Result<(), FlowError> {
        let touch = self.touch_values(system)?;
        // The corner is met an instant too early or too late, where each side's gap has gone on at its rate.
        let instant = self.instant();
        for (contact, (gap, gap_before)) in touch.gap.iter().zip(&before.gap).enumerate() {
            let rates = touch.rate[contact].terms.max(before.rate[contact].terms);
            // What a gap has left of terms that are gone is no jump.
            let jump = (gap.value - gap_before.value).abs();
            if jump
                <= slack(gap)
                    .max(slack(gap_before))
                    .max(R::splat(rates) * instant)
            {
                continue;
            }
            if is_inside(gap) {
                return Err(FlowError::JumpsInside {
                    time: self.time.to_f64(),
                    contact,
                    gap: gap.value.to_f64(),
                });
            }
            if self.closed.contains(contact) && gap.value > slack(gap) {
                self.open(system, contact, 0)?;
                self.pending.push_back(Occurrence::Release { contact });
            }
        }
        Ok(())
    }

    /// Contacts that are closed after a corner of their gap, or of the field, has been passed: a rate that has jumped away
    /// from zero opens them or is an impact. Columns, which are shifted by so much, are at fixed time again in the motion that follows,
    /// which is not known before.
    pub(in crate::flow::trajectory) fn keep_contacts(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        shifts: &[R],
    ) -> Result<(), FlowError> {
        if self.closed == Closed::NONE {
            return self.shift_columns(system, work, shifts, -R::ONE);
        }
        let touch = self.touch_values(system)?;
        // The corner is met an instant too early or too late: what changes by that is no jump.
        let instant = self.instant();
        let level = |contact: usize| {
            (touch.rate[contact].level()).max(R::splat(touch.acceleration[contact].terms) * instant)
        };
        let moves = |contact: usize| touch.rate[contact].value.abs() > level(contact);
        let leaving: Vec<usize> = self.closed.contacts().filter(|&c| moves(c)).collect();
        let fastest = (leaving.iter().copied()).min_by(|&a, &b| {
            let (a, b) = (touch.rate[a].value, touch.rate[b].value);
            a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
        });
        if let Some(fastest) = fastest.filter(|&contact| touch.rate[contact].value < R::ZERO) {
            self.shift_columns(system, work, shifts, -R::ONE)?;
            let told = self.collide(system, work, fastest, self.closed)?;
            self.pending.extend(told);
            return Ok(());
        }
        for contact in leaving {
            self.open(system, contact, 1)?;
            self.pending.push_back(Occurrence::Release { contact });
        }
        self.press_again(system, work, &touch)?;
        self.shift_columns(system, work, shifts, -R::ONE)
    }

    /// Lets go what closed contacts do not hold any more: their forces may have jumped.
    fn press_again(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        touch: &Touch<R>,
    ) -> Result<(), FlowError> {
        let pressed = |contact: usize| {
            let free = &touch.acceleration[contact];
            free.value < -free.level()
        };
        // What surfaces hold on both sides of it no contact does, whatever has jumped, unless they move apart.
        let parts = |contact: usize| {
            let free = &touch.acceleration[contact];
            free.value > free.level()
        };
        if self.grip().carrying() == Closed::NONE && !self.closed.contacts().any(parts) {
            return Ok(());
        }
        // Sides were asked for with all of them: where they push it is decided.
        if self.grip().carrying() == self.closed && self.contacts_stay(system)[1] {
            return Ok(());
        }
        let mut members = self.closed.contacts();
        match (members.next(), members.next()) {
            (None, _) => Ok(()),
            (Some(contact), None) if pressed(contact) => Ok(()),
            _ => self.rest_again(system, work),
        }
    }

    /// Decides anew which of the closed contacts stay closed; tells of those that open.
    pub(in crate::flow::trajectory) fn rest_again(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<(), FlowError> {
        let before = self.closed;
        self.bring_to_rest(system, work, Closed::NONE)?;
        for contact in before.contacts().filter(|&c| !self.closed.contains(c)) {
            self.pending.push_back(Occurrence::Release { contact });
        }
        Ok(())
    }
}
