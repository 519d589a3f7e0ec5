//! Whether what multipliers do along a way is more than rounding.

use super::Point;
use super::walker::Walker;
use crate::analysis::continuation::Station;
use crate::analysis::periodic::multipliers::farthest;

/// Right beside a station is this part of the way to the next, or what rounding leaves of a way; so many stations there are asked, and where multipliers
/// change to one of them by this part of what they do on all of the way rounding does it.
const RIGHT_BESIDE: f64 = 1e-4;
const ROUNDED_STEP: f64 = 1e-12;
const SAMPLES: u32 = 3;
const CHANGES: f64 = 0.1;

impl Walker {
    /// Whether multipliers change on the way from one station to another, with an orbit in between, by no more than rounding makes of them, as where flights
    /// are hardly higher than rounding of the gap: then they change as much from either end to stations right beside it, and parts of the way show ever more
    /// of that.
    pub(super) fn is_rounding(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        [here, halfway, there]: [&Point; 3],
    ) -> bool {
        let halves = [here, there].map(|end| farthest(&end.multipliers, &halfway.multipliers));
        let change = halves[0].max(halves[1]);
        let beside = (RIGHT_BESIDE * step).max(ROUNDED_STEP);
        let changes = |walker: &mut Self, station: &Station, point: &Point, ahead: f64| {
            let Ok((next, _)) = station.ahead(&mut walker.shooting, ahead) else {
                return false;
            };
            walker.settle(&next);
            let multipliers = walker.shooting.multipliers();
            farthest(&point.multipliers, &multipliers) > CHANGES * change
        };
        let mut ends = [(from, here, beside), (to, there, -beside)].into_iter();
        change > 0.0
            && ends.all(|(station, point, beside)| {
                (1..=SAMPLES).any(|k| changes(self, station, point, f64::from(k) * beside))
            })
    }
}
