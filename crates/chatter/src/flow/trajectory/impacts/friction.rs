//! Friction in contacts: what impacts do along it, and where it jams (MATH.md 9).
//!
//! The force of a contact that slides, and its impulse at an impact, is along W - s mu W_t, s being the sign of the sliding. Where
//! that does not raise the gap rate (Painlevé), a contact cannot be held while it slides, and an impact stops the sliding.

use crate::expressions::Side;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::system::System;
use crate::flow::touch::{Sliding, Touch};
use crate::flow::trajectory::Trajectory;
use crate::numerics::Real;

/// A state and its rounding remainders.
pub(super) type Place<R> = (Vec<R>, Vec<R>);

/// Normal and tangential impulse of an impact, with the sign of the first such that a contact pushes.
struct Impulses<R> {
    normal: R,
    tangential: R,
}

impl<R: Real> Sliding<R> {
    /// The impulses of an impact that raises the gap rate by `rise`: with the friction of this side, and a tangential one that changes
    /// the rate of sliding by `stop`.
    fn impulses(&self, side: R, rise: R, stop: R) -> Impulses<R> {
        // What the normal impulse alone does to the gap rate.
        let bare = (self.coefficient * side).mul_add(self.lift, self.rise);
        let sign = if bare < R::ZERO { -R::ONE } else { R::ONE };
        let tangential = stop / self.change;
        let normal = (rise - tangential * self.lift) / self.rise;
        Impulses {
            normal: normal * sign,
            tangential: tangential - self.coefficient * side * normal,
        }
    }

    /// Whether stopping lies within the cone of friction.
    fn can_stop(&self, side: R, rise: R) -> bool {
        let Impulses { normal, tangential } = self.impulses(side, rise, -self.rate);
        tangential.abs() <= self.coefficient * normal
    }

    /// Whether sliding on takes an impulse that pushes.
    fn can_slide(&self, side: R, rise: R) -> bool {
        self.impulses(side, rise, R::ZERO).normal >= R::ZERO
    }
}

impl<R: Real> Trajectory<R> {
    /// Puts an impact right that has raised the gap rate by so much with full friction, from the state `before`, where it is known: if
    /// that would have turned the sliding round, or been no impulse that pushes, the contact sticks during the impact, and slides no
    /// more after it; if friction is too weak for that, it slides the other way. With columns such an impact is one of several collisions,
    /// and they are those of the event's point. Returns whether the contact slides on.
    pub(in crate::flow::trajectory) fn rub_at_impact(
        &mut self,
        system: &System,
        contact: usize,
        (rise, before): (R, Option<Place<R>>),
    ) -> Result<bool, FlowError> {
        let Some(rubbing) = system.rubbing_at(contact) else {
            return Ok(true);
        };
        let side = R::splat(self.regime.get(rubbing.surface).sign());
        let Some(sliding) = self.sliding(system, contact)? else {
            return Ok(true);
        };
        let turns = side == R::ZERO || sliding.rate * side < R::ZERO;
        let slides = sliding.can_slide(side, rise);
        let is_rough = sliding.coefficient > R::ZERO;
        if !is_rough || (slides && !turns) {
            return Ok(true);
        }
        if slides && (sliding.can_stop(side, rise) || !self.slides_clearly(system, contact)?) {
            self.push(&sliding.stop, R::ONE);
            return Ok(false);
        }
        let before = match before {
            Some(before) => before,
            None => {
                let touch = self.touch_values(system)?;
                self.push(&touch.jump[contact], -rise);
                (self.state.clone(), self.low.clone())
            }
        };
        self.stick_at_impact(system, (contact, rubbing.surface), (rise, &before))?;
        Ok(false)
    }

    /// An impact, from the state before it, that does not slide on as it came.
    fn stick_at_impact(
        &mut self,
        system: &System,
        (contact, surface): (usize, usize),
        (rise, before): (R, &Place<R>),
    ) -> Result<(), FlowError> {
        let came = self.standing_sides();
        let others = match came.side(surface) {
            Side::Above => [Side::Sliding, Side::Below],
            Side::Below => [Side::Sliding, Side::Above],
            Side::Sliding => [Side::Above, Side::Below],
        };
        for side in others {
            if !self.try_sides(system, &came.with_side(surface, side))? {
                continue;
            }
            (self.state, self.low) = before.clone();
            (self.state, self.low) = self.after_collision(system, contact)?;
            let Some(sliding) = self.sliding(system, contact)? else {
                continue;
            };
            let sign = R::splat(side.sign());
            if side == Side::Sliding {
                if sliding.can_stop(sign, rise) {
                    self.push(&sliding.stop, R::ONE);
                    self.try_sides(system, &came)?;
                    return Ok(());
                }
                continue;
            }
            let goes_on =
                sliding.rate * sign >= R::ZERO || !self.slides_clearly(system, contact)?;
            if sliding.can_slide(sign, rise) && goes_on {
                return Ok(());
            }
        }
        Err(self.jammed(contact))
    }

    /// Whether a contact with friction slides at a rate that can be told from zero.
    fn slides_clearly(&self, system: &System, contact: usize) -> Result<bool, FlowError> {
        let rate = self.rate_of_sliding(system, contact)?;
        Ok(rate.is_some_and(|rate| rate.value.abs() > rate.level()))
    }

    /// The surface on which the latest impact of a contact has stopped its sliding, so that it comes to rest on that, too.
    pub(super) fn has_stopped(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<Option<Corner>, FlowError> {
        let Some(rubbing) = system.rubbing_at(contact) else {
            return Ok(None);
        };
        let slides = self.slides_clearly(system, contact)?;
        Ok((!slides).then_some(Corner::Surface(rubbing.surface)))
    }

    /// The contact among these that slides, and whose force with the friction of that would not hold it.
    pub(in crate::flow::trajectory) fn jamming(
        &self,
        system: &System,
        (touch, contacts): (&Touch<R>, Closed),
    ) -> Result<Option<usize>, FlowError> {
        for rubbing in system.rubbing() {
            let contact = rubbing.contact;
            if contacts.contains(contact)
                && is_jammed(touch, contact)
                && self.slides_clearly(system, contact)?
            {
                return Ok(Some(contact));
            }
        }
        Ok(None)
    }

    /// The contact that is closed and jams in the present mode.
    pub(in crate::flow::trajectory) fn jam(&self, system: &System) -> Option<usize> {
        let carrying = self.grip().carrying();
        let mut rubbing = (system.rubbing().iter()).filter(|r| carrying.contains(r.contact));
        rubbing.clone().next()?;
        // Where contacts have no values nothing holds them, and who asks for these says so.
        let touch = self.touch_values(system).ok()?;
        let jams = rubbing.find(|rubbing| is_jammed(&touch, rubbing.contact))?;
        Some(jams.contact)
    }

    pub(in crate::flow::trajectory) fn jammed(&self, contact: usize) -> FlowError {
        FlowError::Jammed {
            time: self.time.to_f64(),
            contact,
        }
    }
}

fn is_jammed<R: Real>(touch: &Touch<R>, contact: usize) -> bool {
    let room = &touch.room[contact];
    room.value <= room.level()
}
