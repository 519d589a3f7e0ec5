//! Windows that have a superstable orbit: followed from it to both ends.

use super::super::argument::Argument;
use super::super::windows::Located;
use super::follow::End;
use super::orbit::Place;
use super::periodic::Atlas;
use super::window::{Edge, EdgeKind, PeriodicWindow, in_order};
use crate::numerics::Real;

impl<R: Real + Argument<Real = R>> Atlas<'_, R> {
    /// The windows with a superstable orbit.
    pub(super) fn superstable(&self, lap: i64, period: usize) -> (Vec<PeriodicWindow<R>>, usize) {
        let critical = self.family.universal.critical_point(lap);
        let (places, undecided) = self.recurrences(critical, lap, period);
        let windows = places.into_iter().map(|(place, left)| {
            let points = self.family.orbit(place, period);
            let word = self.family.word(&points);
            let laps = word.iter().map(|branch| branch.lap).collect();
            let ends = [1.0, -1.0].map(|towards| self.family.follow(place, towards, period));
            let ends = ends.into_iter().flatten();
            PeriodicWindow {
                lap,
                laps,
                superstable: Some(self.located(place, left)),
                edges: in_order(
                    ends.filter_map(|followed| self.edge(followed.end, period))
                        .collect(),
                ),
                grazing: None,
            }
        });
        (windows.collect(), undecided)
    }

    /// What ends a window, where a family was followed to.
    pub(super) fn edge(&self, end: End<R>, period: usize) -> Option<Edge<R>> {
        let (kind, at) = match end {
            End::Fold(at, left) => (EdgeKind::Fold, self.located(at, left)),
            End::PeriodDoubling(at, left) => (EdgeKind::PeriodDoubling, self.located(at, left)),
            End::Doubled(at, left) => (EdgeKind::DoubledFrom, self.located(at, left)),
            End::Border(near) => (EdgeKind::Collision, self.nearest_end(near, period)?),
        };
        Some(Edge { kind, at })
    }

    /// Where the family near this place has a point at a lap's end.
    fn nearest_end(&self, near: Place<R>, period: usize) -> Option<Located<R>> {
        let universal = self.family.universal;
        let points = self.family.orbit(near, period);
        let mut nearest = None::<(f64, R)>;
        for &x in &points {
            let lap = universal.at(x).lap.to_f64();
            if !lap.is_finite() {
                continue;
            }
            for lap in [lap as i64, lap as i64 + 1] {
                let end = universal.window_of(R::ONE, lap).grazing.x;
                let away = ((x - end) / end).abs().to_f64();
                if nearest.is_none_or(|(least, _)| away < least) {
                    nearest = Some((away, end));
                }
            }
        }
        let (_, end) = nearest?;
        let (place, left) = self.family.recurrent(end, near.mu, period)?;
        Some(self.located(place, left))
    }
}
