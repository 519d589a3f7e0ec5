//! Windows of the orbits of period 2 and higher.
//!
//! A family of periodic orbits is stable where its multiplier lies between -1 and 1. The multiplier is zero only where a
//! point of the orbit is critical, Upsilon' = 0, and jumps only where a point comes to a lap's end. So each window
//! either has a superstable orbit, or begins or ends where a point lies on a lap's end, coming from its right. All such
//! orbits are found by [`Recurrence`]; Newton's method follows their families to the multipliers 1 and -1.

use super::super::argument::Argument;
use super::super::error::UniversalError;
use super::super::evaluate::Universal;
use super::super::windows::Located;
use super::enclosure::{Enclosing, Interval};
use super::follow::End;
use super::orbit::{Branch, Family, Place};
use super::recurrence::Recurrence;
use crate::numerics::Real;
use core::ops::RangeInclusive;

/// What ends a window of stable orbits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Multiplier 1: the orbit is born together with an unstable one.
    Fold,
    /// Multiplier -1 of the orbit with half the period, where this one is born.
    DoubledFrom,
    /// Multiplier -1.
    PeriodDoubling,
    /// A point of the orbit comes to a lap's end from its right, where the slope jumps to minus infinity.
    Collision,
}

/// An end of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge<R> {
    /// What happens there.
    pub kind: EdgeKind,
    /// Where; at a collision x is the point at the lap's end, else one of those on the window's [`lap`](PeriodicWindow::lap).
    pub at: Located<R>,
}

/// A window of a periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicWindow<R> {
    /// The lap on which a point of the orbit is critical; without such a point, that at whose end the window begins.
    pub lap: i64,
    /// The laps of its points, in the order in which they are visited.
    pub laps: Vec<i64>,
    /// Multiplier 0, x being the critical point.
    pub superstable: Option<Located<R>>,
    /// Both ends, the one at the smaller mu first.
    pub edges: Vec<Edge<R>>,
    /// A point of the orbit, unstable by then, comes to the end of its lap from the left: u_1 = 3/8, its last impact grazes.
    pub grazing: Option<Located<R>>,
}

/// Windows of periodic orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicAtlas<R> {
    /// By lap, then by period, then by mu.
    pub windows: Vec<PeriodicWindow<R>>,
    /// Intervals of mu that may hold windows and were given up because there were too many.
    pub undecided: usize,
}

/// Laps that an orbit may extend over to either side of the point in question.
const WIDEST: i64 = 24;
/// Iterations in which an interval has grown to what its orbits cover.
const GROWTH: usize = 64;
/// Two points of an orbit nearer than this, relative, are one: the period is a smaller one.
const SAME: f64 = 1e-9;
/// Two windows whose ends agree to this, relative, are one that has two superstable orbits.
const SAME_WINDOW: f64 = 1e-13;

impl<R: Copy> PeriodicWindow<R> {
    /// Points of the orbit.
    pub fn period(&self) -> usize {
        self.laps.len()
    }

    /// Where the first edge of this kind is.
    pub fn edge(&self, kind: EdgeKind) -> Option<Located<R>> {
        let edge = self.edges.iter().find(|edge| edge.kind == kind)?;
        Some(edge.at)
    }

    /// The interval of mu in which the orbit is stable; `None` where an end was not found.
    pub fn stable(&self) -> Option<(R, R)> {
        match *self.edges.as_slice() {
            [low, high] => Some((low.at.mu, high.at.mu)),
            _ => None,
        }
    }
}

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

/// An orbit with a point at a lap's end.
struct AtEnd<R> {
    lap: i64,
    located: Located<R>,
    points: Vec<R>,
    /// Branches of the points; of the first, as a point of the lap that ends.
    word: Vec<Branch>,
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

    /// How many laps to either side the orbits near the end of a lap extend, where its fixed point grazes.
    fn reach(&self, lap: i64) -> i64 {
        let universal = self.enclosing.universal;
        let slope = self.family.slope.to_f64();
        let graze = universal.window_of(slope, lap).grazing;
        let covered = covered(&self.enclosing, slope, graze.mu, graze.x);
        let laps_away = |x: f64| {
            let away = (universal.at(x).lap - lap as f64).abs();
            // Complete chatter is infinitely many laps away; an orbit that escapes has no lap at all.
            away.min(WIDEST as f64) as i64
        };
        laps_away(covered.low)
            .max(laps_away(covered.high))
            .min(WIDEST - 1)
            + 1
    }

    /// Where to look for orbits with a critical point on this lap.
    fn range(&self, lap: i64) -> Interval {
        let universal = self.enclosing.universal;
        let slope = self.family.slope.to_f64();
        let reach = self.reach(lap);
        let mut range = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        for lap in lap - reach..=lap + reach {
            let window = universal.window_of(slope, lap);
            for event in [window.superstable, window.grazing] {
                range = range.hull(Interval::point(event.mu));
            }
        }
        range
    }

    /// All mu at which a point is periodic with this period and no smaller one.
    fn recurrences(&self, point: R, lap: i64, period: usize) -> (Vec<(Place<R>, R)>, usize) {
        let search = Recurrence {
            enclosing: &self.enclosing,
            slope: self.family.slope.to_f64(),
            point: point.to_f64(),
            period,
            beyond: self
                .enclosing
                .universal
                .window_of(1.0, lap - WIDEST)
                .grazing
                .x,
        };
        let found = search.all(self.range(lap));
        let places = found.brackets.iter().filter_map(|bracket| {
            let residual = |mu: f64| search.residual(mu);
            let mu = super::super::root::between(residual, bracket.low, bracket.high)?;
            let (place, left) = self.family.recurrent(point, R::splat(mu), period)?;
            let points = self.family.orbit(place, period);
            let again = points[1..].iter().any(|&x| {
                let apart = (x - place.x).abs();
                apart <= R::splat(SAME) * place.x.abs()
            });
            (!again).then_some((place, left))
        });
        (places.collect(), found.undecided)
    }

    fn located(&self, place: Place<R>, residual: R) -> Located<R> {
        Located {
            mu: place.mu,
            x: place.x,
            z: self.family.universal.value(place.x),
            residual,
        }
    }

    fn at_end(&self, lap: i64, period: usize) -> (Vec<AtEnd<R>>, usize) {
        let end = self.family.universal.window_of(R::ONE, lap).grazing.x;
        let (places, undecided) = self.recurrences(end, lap, period);
        let ends = places.into_iter().map(|(place, left)| {
            let points = self.family.orbit(place, period);
            let mut word = self.family.word(&points);
            word[0] = Branch { lap, rising: false };
            AtEnd {
                lap,
                located: self.located(place, left),
                points,
                word,
            }
        });
        (ends.collect(), undecided)
    }

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

    fn edge(&self, end: End<R>, period: usize) -> Option<Edge<R>> {
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

    /// The window without superstable orbit that begins where a point leaves a lap's end to the right.
    fn collided(&self, end: &AtEnd<R>) -> Option<PeriodicWindow<R>> {
        let period = end.word.len();
        let universal = self.family.universal;
        // Just to the right, to second order in what can be told apart.
        let beside = R::splat(libm::cbrt(R::ROUNDOFF * R::ROUNDOFF));
        let x = end.located.x * (R::ONE + beside);
        let (place, _) = self.family.recurrent(x, end.located.mu, period)?;
        let multiplier = self.family.jet(place, period).by_start;
        let stable = multiplier.abs() < R::ONE;
        if !stable || universal.at(x).lap.to_f64() != (end.lap - 1) as f64 {
            return None;
        }
        let word = self.family.word(&self.family.orbit(place, period));
        if word[1..] != end.word[1..] {
            return None;
        }
        let followed = self.family.follow(place, 1.0, period)?;
        if followed.passed_zero {
            // Found from there.
            return None;
        }
        let mut laps: Vec<i64> = word.iter().map(|branch| branch.lap).collect();
        // It begins with the point on the lap itself, if there is one.
        if let Some(first) = laps.iter().position(|&lap| lap == end.lap) {
            laps.rotate_left(first);
        }
        let collision = Edge {
            kind: EdgeKind::Collision,
            at: end.located,
        };
        let other = self.edge(followed.end, period)?;
        Some(PeriodicWindow {
            lap: end.lap,
            laps,
            superstable: None,
            edges: in_order(vec![collision, other]),
            grazing: None,
        })
    }

    /// The graze of the family of a window: an orbit on the same branches with a point at its lap's end.
    fn add_graze(&self, window: &mut PeriodicWindow<R>, ends: &[AtEnd<R>]) {
        let Some(superstable) = window.superstable else {
            return;
        };
        let place = Place {
            x: superstable.x,
            mu: superstable.mu,
        };
        let mut word = self.family.word(&self.family.orbit(place, window.period()));
        word[0] = Branch {
            lap: window.lap,
            rising: false,
        };
        let rotations = |end: &&AtEnd<R>| {
            let twice: Vec<Branch> = end.word.iter().chain(&end.word).copied().collect();
            end.word.len() == word.len() && twice.windows(word.len()).any(|part| part == word)
        };
        let away = |end: &&AtEnd<R>| (end.located.mu - place.mu).abs().to_f64();
        let graze = ends
            .iter()
            .filter(rotations)
            .min_by(|a, b| away(a).total_cmp(&away(b)));
        debug_assert!(graze.is_none_or(|end| end.points.len() == window.period()));
        window.grazing = graze.map(|end| end.located);
    }
}

fn in_order<R: Real>(mut edges: Vec<Edge<R>>) -> Vec<Edge<R>> {
    // Doubles may not tell them apart.
    edges.sort_by(|a, b| (a.at.mu - b.at.mu).to_f64().total_cmp(&0.0));
    edges
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

/// What the orbits cover that start at a point or between points so covered.
pub(super) fn covered(enclosing: &Enclosing<'_>, slope: f64, mu: f64, x: f64) -> Interval {
    let mut covered = Interval::point(x);
    for _ in 0..GROWTH {
        let (values, _) = enclosing.image(covered);
        let ends = [slope * values.low, slope * values.high].map(|value| value + mu);
        let image = Interval::new(ends[0].min(ends[1]), ends[0].max(ends[1]));
        covered = covered.hull(image);
    }
    covered
}
