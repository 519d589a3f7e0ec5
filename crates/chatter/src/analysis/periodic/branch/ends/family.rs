//! Where nothing is left of what a forcing brings about in a period, as of the slips of a joint that sticks beyond: without it orbits lie beside each
//! other, in whichever place the joint sticks, and none of them goes on with the branch.

use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::branch::End;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::cycle::itinerary::Step;

/// An orbit that closes but for this part of its size without its events goes on without them.
const CLOSES: f64 = 1e-6;
/// A multiplier is one to rounding.
const ONE: f64 = 1e-9;

impl Walker {
    /// How the branch ends where its orbit has come to one of those.
    pub(in crate::analysis::periodic::branch) fn ends_in_family(
        &mut self,
        station: &Station,
    ) -> Option<End> {
        let strikes = |step: &Step| step.impact().is_some() || step.is_stretch();
        let is_free = self.shooting.counts.iter().all(|&count| count == 0);
        if is_free || self.shooting.steps.iter().any(strikes) {
            return None;
        }
        self.settle(station);
        let lasts = |index: &usize| self.shooting.latest.get(*index).map_or(0.0, |l| l.duration);
        let steps = 0..self.shooting.steps.len();
        let longest = steps.max_by(|a, b| lasts(a).total_cmp(&lasts(b)))?;
        let (mut without, at) = self.shooting.at_rest(&station.at, longest)?;
        let linearised = without.evaluate(&at).ok()?;
        let off = linearised.residual.iter().zip(without.scales());
        let closes = off.map(|(x, scale)| (x / scale).abs()).fold(0.0, f64::max) <= CLOSES;
        let is_one = without
            .multipliers_known()
            .0
            .iter()
            .any(|m| (m.re - 1.0).hypot(m.im) <= ONE);
        (closes && is_one).then(|| {
            End::Lost(
                "its events come to nothing, and without them all motion beside it is periodic, too: nothing tells one orbit from the others"
                    .to_owned(),
            )
        })
    }
}
