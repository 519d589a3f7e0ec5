//! What a trajectory knows of its contacts where it is: gaps and rates, what impulses do, how they slide.

use crate::flow::error::FlowError;
use crate::flow::system::System;
use crate::flow::touch::{Sliding, Touch, TouchConstants, Touches};
use crate::flow::trajectory::Trajectory;
use crate::numerics::{Real, WithTerms};

impl<R: Real> Trajectory<R> {
    /// All contacts at the present state.
    pub(in crate::flow::trajectory) fn touch_values(
        &self,
        system: &System,
    ) -> Result<Touch<R>, FlowError> {
        let (touches, constants) = self.touches(system)?;
        let touch = touches.at(constants, &self.state, &self.low);
        if touch.is_finite() {
            Ok(touch)
        } else {
            Err(self.undefined_here(system))
        }
    }

    /// How jumps of these contacts change their rates.
    pub(in crate::flow::trajectory) fn coupling(
        &self,
        system: &System,
        contacts: &[usize],
    ) -> Result<Vec<Vec<R>>, FlowError> {
        let (touches, constants) = self.touches(system)?;
        Ok(touches
            .at(constants, &self.state, &self.low)
            .block(contacts))
    }

    /// What says of all contacts at once, on the sides where the state is, with its constants.
    pub(in crate::flow::trajectory) fn touches<'s>(
        &'s self,
        system: &'s System,
    ) -> Result<(&'s Touches, &'s TouchConstants<R>), FlowError> {
        let touches = system.touches(self.flight);
        let constants = self.touch_constants.get(self.flight);
        touches
            .zip(constants.and_then(Option::as_ref))
            .ok_or_else(|| self.left_domain())
    }

    pub(super) fn after_collision(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<(Vec<R>, Vec<R>), FlowError> {
        let (touches, constants) = self.touches(system)?;
        Ok(touches.after_collision(constants, contact, &self.state, &self.low))
    }

    /// Friction of a contact at an impact; none without any.
    pub(super) fn sliding(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<Option<Sliding<R>>, FlowError> {
        let (touches, constants) = self.touches(system)?;
        Ok(touches.sliding(constants, contact, &self.state, &self.low))
    }

    /// The rate of sliding of a contact with friction.
    pub(in crate::flow::trajectory) fn rate_of_sliding(
        &self,
        system: &System,
        contact: usize,
    ) -> Result<Option<WithTerms<R>>, FlowError> {
        let (touches, constants) = self.touches(system)?;
        Ok(touches.rate_of_sliding(constants, contact, (&self.state, &self.low)))
    }
}
