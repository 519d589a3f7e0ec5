//! What breaks where a rate turns on a surface on which the force changes: a graze after which the state is held there, and an impact that loses its
//! rate.

use super::follower::{Follower, NOT_QUITE};
use super::past_touch::touched;
use crate::analysis::continuation::{Problem, Station, locate};
use crate::analysis::periodic::branch::Broken;
use crate::analysis::periodic::condition::Bordered;
use crate::flow::GuardKind;

impl Follower {
    /// Where the flow after a graze turns back to the surface that its rate turns on, if that is what breaks: beyond, the state stays on it.
    pub(super) fn turns_back(
        &mut self,
        broken: &Broken,
        (from, ahead): (&Station, f64),
        bordered: &Bordered,
    ) -> Option<(Station, f64)> {
        let (index, guard) = touched(broken)?;
        let is_next = self.grazing == Some(self.shooting.before(index));
        if !(is_next && self.shooting.begins_on_turn(index, guard)) {
            return None;
        }
        let reader = self.shooting.clone();
        let rate = |station: &Station| reader.rate_at_start(&station.at, (index, guard));
        let within = 2.0 * ahead;
        let mut held = bordered.of(&mut self.shooting);
        let (far, _) = from.ahead(&mut held, within).ok()?;
        let ends = (rate(from)?, rate(&far)?);
        locate(&mut held, from, within, ends, &mut |_, station| {
            rate(station)
        })
    }

    /// The impact that loses its rate where this breaks: the rate may turn on a surface on which the force changes, too, which then comes first.
    pub(super) fn loses_rate(&mut self, broken: &Broken, station: &Station) -> Option<Broken> {
        let index = match *broken {
            Broken::Early(index, GuardKind::Switch(_)) => index,
            Broken::Beyond(index, GuardKind::Switch(_)) => self.shooting.before(index),
            _ => return None,
        };
        self.shooting.steps[index].impact()?;
        self.shooting.evaluate(&station.at).ok()?;
        let rates = self.shooting.latest.iter().zip(&self.shooting.steps);
        let rates = rates.filter(|(_, step)| step.impact().is_some());
        let most = rates.fold(0.0_f64, |most, (landing, _)| {
            most.max(landing.surface_rate.abs())
        });
        let own = self.shooting.latest[index].surface_rate.abs();
        (self.grazing != Some(index) && own <= NOT_QUITE * most).then_some(Broken::Event(index))
    }
}
