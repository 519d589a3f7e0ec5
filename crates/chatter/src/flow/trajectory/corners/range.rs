//! Where tables end: no corner, since nothing follows there. The piece next to an end holds as far beyond it as the argument cannot be told
//! from it, so that a wall may stand there.

use super::Standing;
use crate::expressions::LookedUpIn;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::Workspace;
use crate::flow::system::System;
use crate::flow::trajectory::Trajectory;
use crate::numerics::Real;

impl<R: Real> Trajectory<R> {
    /// The argument of a lookup has left its table. Where the gap of a contact that closes cannot be told from zero there, its impact
    /// comes first; and where the argument itself may as well be within, as one of `mod` is until its turn ends, motion goes on.
    pub(in crate::flow::trajectory) fn leave_table(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        lookup: usize,
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let touch = self.touch_values(system)?;
        let closing = (0..system.contacts()).filter(|&contact| {
            let (gap, rate) = (&touch.gap[contact], &touch.rate[contact]);
            !self.closed.contains(contact) && gap.value <= gap.level() && rate.value < -rate.level()
        });
        let closing = closing.fold(Closed::NONE, Closed::with);
        if let Some(contact) = closing.contacts().next() {
            return self.collide(system, work, contact, Closed(self.closed.0 | closing.0));
        }
        let standings = self.standings(system)?;
        let Some(standing) = (standings.iter()).find(|at| at.corner == Corner::Lookup(lookup))
        else {
            return Err(self.left_domain());
        };
        let argument = (standing.surface.value, standing.surface_level());
        match self.refuse_outside(system, lookup, argument) {
            Ok(()) => Ok(None),
            Err(left) => Err(self.outside(system, standing).unwrap_or(left)),
        }
    }

    /// Refuses arguments that a jump has taken out of their tables.
    pub(super) fn check_ranges(
        &self,
        system: &System,
        standings: &[Standing<R>],
    ) -> Result<(), FlowError> {
        for standing in standings {
            if let Corner::Lookup(lookup) = standing.corner {
                let argument = (standing.surface.value, standing.surface_level());
                self.refuse_outside(system, lookup, argument)?;
            }
        }
        Ok(())
    }

    /// Refuses an argument that is clearly, by more than `level`, out of the table that it is looked up in.
    pub(in crate::flow::trajectory) fn refuse_outside(
        &self,
        system: &System,
        lookup: usize,
        (argument, level): (R, R),
    ) -> Result<(), FlowError> {
        let Some((bounds, beside)) = system.corners().bounds(&system.model().graph, lookup) else {
            return Ok(());
        };
        let [first, last] = bounds.map(R::from_double_double);
        let beside = R::splat(beside).max(level);
        if argument < first - beside || last + beside < argument {
            return Err(self.outside_table(system, lookup, argument));
        }
        Ok(())
    }

    /// That an argument has left its table: where it did so, a moment ago.
    fn outside(&self, system: &System, standing: &Standing<R>) -> Option<FlowError> {
        let Corner::Lookup(lookup) = standing.corner else {
            return None;
        };
        let (bounds, _) = system.corners().bounds(&system.model().graph, lookup)?;
        let [first, last] = bounds.map(R::from_double_double);
        let argument = standing.surface.value;
        let end = if argument <= first { first } else { last };
        let rate = (standing.guards.first()).map_or(R::ZERO, |(_, orders)| orders[1].value);
        let since = (argument - end) / rate;
        let mut left = self.outside_table(system, lookup, end);
        if let FlowError::OutsideTable { time, .. } = &mut left
            && since.is_finite()
        {
            *time = ((self.time - since) + self.time_low).to_f64();
        }
        Some(left)
    }

    /// That a lookup has no value at an argument.
    pub(super) fn outside_table(&self, system: &System, lookup: usize, argument: R) -> FlowError {
        let LookedUpIn::Curve(id) = system.corners().lookups[lookup].within else {
            return self.left_domain();
        };
        FlowError::OutsideTable {
            time: self.time.to_f64(),
            table: system.model().graph.curve(id).name().to_owned(),
            argument: argument.to_f64(),
        }
    }
}
