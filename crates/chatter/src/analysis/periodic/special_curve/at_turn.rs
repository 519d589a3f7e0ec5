//! What breaks where a rate turns on a surface on which the force changes: a graze after which the state is held there, and an impact that loses its
//! rate.

use super::follower::{Follower, VANISHES};
use super::past_touch::touched;
use crate::analysis::continuation::{Problem, Station, locate};
use crate::analysis::periodic::branch::Broken;
use crate::analysis::periodic::condition::Bordered;
use crate::flow::GuardKind;

impl Follower {
    /// Where the flow after a graze turns back to the surface that its rate turns on, or to one that was crossed, if that is what breaks: beyond, the
    /// state stays on it.
    pub(super) fn turns_back(
        &mut self,
        broken: &Broken,
        (from, ahead): (&Station, f64),
        bordered: &Bordered,
    ) -> Option<(Station, f64)> {
        let (index, guard) = touched(broken)?;
        let is_next = self.grazing == Some(self.shooting.before(index));
        let after_graze = is_next && self.shooting.begins_on_turn(index, guard);
        // The least value on the way is next to nothing all along where that begins on the surface.
        if !(after_graze || self.shooting.begins_at(index, guard)) {
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
    pub(super) fn loses_rate(
        &mut self,
        broken: &Broken,
        (from, station): (&Station, &Station),
    ) -> Option<Broken> {
        let index = match *broken {
            Broken::Early(index, GuardKind::Switch(_)) => index,
            Broken::Beyond(index, GuardKind::Switch(_)) => self.shooting.before(index),
            _ => return None,
        };
        self.shooting.steps[index].impact()?;
        let mut rate = |station: &Station| -> Option<f64> {
            self.shooting.evaluate(&station.at).ok()?;
            Some(self.shooting.latest.get(index)?.surface_rate.abs())
        };
        let (before, here) = (rate(from)?, rate(station)?);
        let vanishes = self.shooting.has_lost_rate(index) || here <= VANISHES * before;
        (self.grazing != Some(index) && vanishes).then_some(Broken::Event(index))
    }
}
