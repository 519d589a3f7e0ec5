//! Impacts that are none: a contact that is met no deeper than the motion is known to is touched.
//!
//! Where the gap has the rate v and the acceleration a > 0, without the obstacle it would fall to -v^2 / (2 a) and rise again. A
//! motion with this acceleration has moved the gap by some a T^2 / 2 in a time T of its own, and is known to some
//! roundoffs of that, which add up from one such time to the next like the steps of a random walk.

use crate::flow::error::FlowError;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::FOREVER;
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::numerics::Real;

/// A gap is known to so many roundoffs of what a step moves it by: in doubles no more than a part of 1e-13 is.
const ERROR_ROUNDOFFS: f64 = 1024.0;

/// Motions that are followed for longer than so many such times either forget their errors, or have no touch to tell.
const MOST_STEPS: f64 = 256.0;

impl<R: Real> Trajectory<R> {
    /// Whether an impact with a positive acceleration is no deeper than the error of the gap. Columns of derivatives have no value
    /// at a graze: with them it is an impact.
    pub(in crate::flow::trajectory) fn only_touches(&self, impact: &[R; IMPACT_SCALARS]) -> bool {
        let [rate, _, acceleration, ..] = *impact;
        let elapsed = self.time - self.touched_at;
        let longest = (self.reach.iter()).fold(self.longest_step, |most, &reach| most.max(reach));
        let unit = longest.min(elapsed);
        let steps = ((self.time - self.started_at) / unit).min(R::splat(MOST_STEPS));
        let speed = acceleration * unit;
        let known = (R::ONE + steps.sqrt()) * R::splat(ERROR_ROUNDOFFS * R::ROUNDOFF);
        self.state.len() == self.coordinates
            && unit > R::ZERO
            && rate * rate <= known * speed * speed
    }

    /// Takes back an impact that was none.
    pub(in crate::flow::trajectory) fn pass_by(
        &mut self,
        system: &System,
        (index, contact): (usize, usize),
        impact: &[R; IMPACT_SCALARS],
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let [rate, after, ..] = *impact;
        let touch = self.touch_values(system)?;
        self.push(&touch.jump[contact], rate - after);
        self.touching.set(index, 2);
        self.flight_time = R::splat(FOREVER);
        self.touched_at = self.time;
        self.sequence = 0;
        self.latest_impact = None;
        self.tracker.interrupt();
        Ok(Some(Occurrence::Graze { contact, rate }))
    }
}
