//! Windows of the orbits of period 2 and higher.
//!
//! A family of periodic orbits is stable where its multiplier lies between -1 and 1. The multiplier is zero only where a
//! point of the orbit is critical, Upsilon' = 0, and jumps only where a point comes to a lap's end. So each window
//! either has a superstable orbit, or begins or ends where a point lies on a lap's end, coming from its right. All such
//! orbits are found by [`Recurrence`](super::recurrence::Recurrence); Newton's method follows their families to the
//! multipliers 1 and -1.

use super::super::argument::Argument;
use super::super::error::UniversalError;
use super::super::evaluate::Universal;
use super::super::windows::Located;
use super::enclosure::Enclosing;
use super::orbit::Family;
use super::window::{Edge, EdgeKind, PeriodicAtlas, PeriodicWindow, in_order};
use crate::numerics::Real;
use core::ops::RangeInclusive;

/// Two windows whose ends agree to this, relative, are one that has two superstable orbits.
const SAME_WINDOW: f64 = 1e-13;

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// The windows of periodic orbits whose critical points lie on these laps, with these periods, over all mu.
    ///
    /// Prepare Upsilon in double-double for an atlas of full precision, as for [`windows`](Self::windows).
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn periodic_windows(
        &self,
        slope: R,
        laps: RangeInclusive<i64>,
        periods: RangeInclusive<usize>,
    ) -> Result<PeriodicAtlas<R>, UniversalError> {
        UniversalError::check_slope(slope)?;
        let double = self.double()?;
        let atlas = Atlas::new(self, slope, &double);
        Ok(atlas.all(laps, periods))
    }
}

pub(super) struct Atlas<'a, R> {
    pub family: Family<'a, R>,
    pub enclosing: Enclosing<'a>,
}

impl<'a, R: Real + Argument<Real = R>> Atlas<'a, R> {
    pub(super) fn new(universal: &'a Universal<R>, slope: R, double: &'a Universal<f64>) -> Self {
        Self {
            family: Family { universal, slope },
            enclosing: Enclosing::new(double),
        }
    }

    fn all(&self, laps: RangeInclusive<i64>, periods: RangeInclusive<usize>) -> PeriodicAtlas<R> {
        let mut atlas = PeriodicAtlas {
            windows: Vec::new(),
            undecided: 0,
        };
        let (first, last) = (*laps.start(), *laps.end());
        for period in periods {
            if period == 1 {
                let windows = laps.clone().map(|lap| self.fixed(lap));
                atlas.windows.extend(windows);
                continue;
            }
            if period == 0 {
                continue;
            }
            let reach = [first, last].map(|lap| self.reach(lap));
            let around = first - reach[0]..=last + reach[1];
            let mut ends = Vec::new();
            for lap in around {
                let (found, undecided) = self.at_end(lap, period);
                ends.extend(found);
                atlas.undecided += undecided;
            }
            for lap in laps.clone() {
                let (windows, undecided) = self.superstable(lap, period);
                atlas.windows.extend(windows);
                atlas.undecided += undecided;
            }
            let collided = ends.iter().filter(|end| laps.contains(&end.lap));
            let collided: Vec<_> = collided.filter_map(|end| self.collided(end)).collect();
            atlas.windows.extend(collided);
            for window in &mut atlas.windows {
                if window.period() == period {
                    self.add_graze(window, &ends);
                }
            }
        }
        drop_twins(&mut atlas.windows);
        let mu = |w: &PeriodicWindow<R>| {
            let event = w.superstable.or(w.edges.first().map(|edge| edge.at));
            event.map_or(0.0, |event| event.mu.to_f64())
        };
        atlas.windows.sort_by(|a, b| {
            let by_lap = (a.lap, a.period()).cmp(&(b.lap, b.period()));
            by_lap.then(mu(a).total_cmp(&mu(b)))
        });
        atlas
    }

    /// The window of the fixed point on a lap.
    pub(super) fn fixed(&self, lap: i64) -> PeriodicWindow<R> {
        let Family { universal, slope } = self.family;
        let window = universal.window_of(slope, lap);
        let kink = universal.window_of(slope, lap + 1).grazing;
        let edge = |event: Option<Located<R>>, kind: EdgeKind| match event {
            Some(at) => Edge { kind, at },
            None => Edge {
                kind: EdgeKind::Collision,
                at: kink,
            },
        };
        PeriodicWindow {
            lap,
            laps: vec![lap],
            superstable: Some(window.superstable),
            edges: in_order(vec![
                edge(window.fold, EdgeKind::Fold),
                edge(window.period_doubling, EdgeKind::PeriodDoubling),
            ]),
            grazing: Some(window.grazing),
        }
    }
}

/// Of windows with the same ends, found from each of their superstable orbits, or from each end, keeps the first.
fn drop_twins<R: Real>(windows: &mut Vec<PeriodicWindow<R>>) {
    let mut kept: Vec<PeriodicWindow<R>> = Vec::with_capacity(windows.len());
    let same = |a: R, b: R| (a - b).abs() <= R::splat(SAME_WINDOW) * a.abs();
    for window in windows.drain(..) {
        let twin = kept.iter().any(|other| {
            let ends = window.edges.iter().zip(&other.edges);
            window.period() == other.period()
                && window.edges.len() == other.edges.len()
                && !window.edges.is_empty()
                && ends
                    .clone()
                    .all(|(a, b)| a.kind == b.kind && same(a.at.mu, b.at.mu))
        });
        if !twin {
            kept.push(window);
        }
    }
    *windows = kept;
}
