//! The gap of a flight between impacts that is cut where the gap is open, as at its top by a section or by a corner.
//!
//! A flight that begins at an impact begins with its gap closed, and that zero is divided out. One that begins in the air begins with
//! whatever the gap is, which may be the small difference of large terms: rounding would change it by more than impacts near the end
//! of a sequence are told from each other by. So the series of the flight that led there says what it is.

use crate::flow::error::FlowError;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::program::Program;
use crate::flow::system::System;
use crate::flow::touching::Touching;
use crate::flow::trajectory::{StepResult, Trajectory};
use crate::numerics::Real;

/// What is a smaller part of its terms loses digits in the time of the next impact.
const SMALL: f64 = 1.0 / 64.0;

impl<R: Real> Trajectory<R> {
    /// The gap of the contact that the sequence belongs to at the end of a step, if that ended elsewhere than at an impact, and was cut
    /// or began with a gap that was known; if it is the small difference of others. `at_end` gives the value there of a series, so many
    /// of whose roots lie at the start, and the size of its terms.
    #[inline(always)]
    pub(crate) fn gap_at_end(
        &self,
        (program, touching): (&Program, Touching),
        result: &StepResult<R>,
        at_end: impl FnOnce(usize, u8) -> (R, R),
    ) -> Option<(usize, R)> {
        let was_cut = match result.event {
            Some(event) => program.guards[event].closing().is_none(),
            None => result.at_horizon || self.known_gap.is_some(),
        };
        let (contact, _) = self
            .latest_impact
            .filter(|_| was_cut && self.sequence > 0)?;
        let (guard, slot) = program.gap_series(contact)?;
        // A state is no difference, and rounded by a part of itself.
        if slot < self.state.len() {
            return None;
        }
        let (gap, terms) = at_end(slot, touching.get(guard));
        (gap.abs() < terms * R::splat(SMALL)).then_some((contact, gap))
    }

    /// The gap that a step came to, as it is computed from the state, if that is open there.
    pub(in crate::flow::trajectory) fn doubtful_gap(
        &self,
        system: &System,
        result: &StepResult<R>,
    ) -> Result<Option<R>, FlowError> {
        let Some((contact, _)) = result.gap else {
            return Ok(None);
        };
        let is_open = self.guard(system, GuardKind::Gap(contact)).is_some();
        let [gap] = self.local_up_to(system, contact)?;
        Ok(Some(gap.value).filter(|_| is_open))
    }
}
