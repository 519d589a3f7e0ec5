//! Impacts that follow each other within a roundoff of the time: which contacts have come to rest together by then, and which bodies
//! are squeezed between others.

use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::flow::touch::Touch;
use crate::flow::trajectory::Trajectory;
use crate::numerics::{Real, WithTerms};

/// After so many impacts in a time that is below rounding it is asked which contacts have come to rest together; …
pub(super) const BURST: usize = 64;

/// … and more than these do not happen at one instant.
pub(super) const LONGEST_BURST: usize = 100_000;

/// So often collisions of squeezed bodies may end in those of others that they squeeze, at one instant.
const MOST_SQUEEZES: usize = 24;

impl<R: Real> Trajectory<R> {
    /// Brings all contacts to rest whose remaining motion, which may take this long, is below rounding: chatter of several at once, of so
    /// many impacts. Returns whether there were any.
    ///
    /// The impulse that does so may take others along that touch as well, and still move: those come to rest with them, or
    /// collide now.
    pub(super) fn end_burst(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (span, impacts): (R, u64),
    ) -> Result<bool, FlowError> {
        let mut decided = self.closed;
        let mut ended = false;
        loop {
            let touch = self.touch_values(system)?;
            let near = self.near_contacts(&touch, span, |rate, slow| rate <= slow);
            let Some(contact) = Closed(near.0 & !decided.0).contacts().next() else {
                break;
            };
            if !ended {
                self.pending.push_back(Occurrence::Accumulation {
                    contact,
                    impacts,
                    error: (span * flights_of_sequence(&touch, near)).to_f64(),
                });
            }
            ended = true;
            decided = Closed(decided.0 | near.0);
            self.bring_to_rest(system, work, Closed(near.0 & !self.closed.0))?;
        }
        if ended {
            self.burst = 0;
            self.end_squeeze(system, work)?;
        }
        Ok(ended)
    }

    /// A body that is squeezed hits both its neighbours ever faster, and meets them at one instant with a rate that is
    /// none: from where gaps are below rounding these are collisions of that instant. Returns whether there are any.
    pub(super) fn end_squeeze(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
    ) -> Result<bool, FlowError> {
        let touch = self.touch_values(system)?;
        let near = self.near_contacts(&touch, self.rest_of_burst(), |_, _| true);
        let touching = Closed(self.closed.0 | near.0);
        let rate = |contact: usize| touch.rate[contact].value;
        let slower = |a: &usize, b: &usize| {
            let order = rate(*a).partial_cmp(&rate(*b));
            order.unwrap_or(core::cmp::Ordering::Equal)
        };
        let Some(fastest) = touching.contacts().min_by(slower) else {
            return Ok(false);
        };
        let before = (self.rates_of_instant.get(fastest)).map_or(R::ZERO, |&rate| rate);
        let level = touch.rate[fastest]
            .level()
            .max(WithTerms::exact(before).level());
        let closes = rate(fastest) < -level;
        if !closes || touching.contacts().count() < 2 {
            return Ok(false);
        }
        if self.squeezes >= MOST_SQUEEZES {
            return Err(FlowError::ImpactsWithoutEnd {
                time: self.time.to_f64(),
                count: self.squeezes,
            });
        }
        self.squeezes += 1;
        let told = self.collide(system, work, fastest, touching);
        self.squeezes -= 1;
        self.pending.extend(told?);
        Ok(true)
    }

    /// How long what is left of impacts that follow each other within a roundoff of the time may take, and how many there were.
    pub(super) fn burst_within_rounding(&self) -> (R, u64) {
        (self.rest_of_burst(), self.burst as u64)
    }

    /// What is left of a sequence whose flights are below rounding may take this long.
    pub(in crate::flow::trajectory) fn rest_of_burst(&self) -> R {
        const FLIGHTS_LEFT: f64 = 64.0;
        self.negligible() * R::splat(FLIGHTS_LEFT)
    }

    /// Contacts that could be met within this time, with a rate and what changes it in that time as asked.
    fn near_contacts(&self, touch: &Touch<R>, span: R, asked: impl Fn(R, R) -> bool) -> Closed {
        let accelerations = touch.greatest_accelerations();
        let mut near = Closed::NONE;
        for (contact, (gap, rate)) in touch.gap.iter().zip(&touch.rate).enumerate() {
            let slow = rate.level().max(accelerations[contact] * span);
            let reached = gap.level().max((rate.value.abs() + slow) * span);
            if gap.value.abs() <= reached && asked(rate.value.abs(), slow) {
                near = near.with(contact);
            }
        }
        near
    }
}

/// How many flights as long as its first a sequence of the contact that loses least lasts, 1 / (1 - r): a rounding error of a
/// rate changes the lengths of all that follow.
fn flights_of_sequence<R: Real>(touch: &Touch<R>, contacts: Closed) -> R {
    let restitutions = contacts.contacts().map(|i| touch.restitution[i].value);
    let loss = restitutions.fold(R::ONE, |least, r| least.min(R::ONE - r));
    R::ONE / loss.max(R::splat(R::ROUNDOFF))
}
