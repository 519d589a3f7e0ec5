//! Orbits with a point at a lap's end: windows that begin there, and grazes.

use super::super::argument::Argument;
use super::super::windows::Located;
use super::orbit::{Branch, COMPLETE, Place};
use super::periodic::Atlas;
use super::window::{Edge, EdgeKind, PeriodicWindow, in_order};
use crate::numerics::Real;

/// An orbit with a point at a lap's end.
pub(super) struct AtEnd<R> {
    pub lap: i64,
    located: Located<R>,
    points: Vec<R>,
    /// Branches of the points; of the first, as a point of the lap that ends.
    word: Vec<Branch>,
}

impl<R: Real + Argument<Real = R>> Atlas<'_, R> {
    /// All orbits with a point at the end of this lap, and how many intervals of mu were given up.
    pub(super) fn at_end(&self, lap: i64, period: usize) -> (Vec<AtEnd<R>>, usize) {
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

    /// The window without superstable orbit that begins where a point leaves a lap's end to the right.
    pub(super) fn collided(&self, end: &AtEnd<R>) -> Option<PeriodicWindow<R>> {
        let period = end.word.len();
        let universal = self.family.universal;
        // Just to the right, to second order in what can be told apart.
        let beside = R::splat(libm::cbrt(R::ROUNDOFF * R::ROUNDOFF));
        let x = end.located.x * (R::ONE + beside);
        let (place, _) = self.family.recurrent(x, end.located.mu, period)?;
        let points = self.family.orbit(place, period);
        let stable = self.family.multiplier(&points).abs() < R::ONE;
        if !stable || universal.at(x).lap.to_f64() != (end.lap - 1) as f64 {
            return None;
        }
        let word = self.family.word(&points);
        // With complete chatter on its way an orbit has the multiplier zero wherever it exists: that is no window.
        let completes = |branch: &Branch| branch.lap == COMPLETE;
        if word[1..] != end.word[1..] || word.iter().any(completes) {
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
    pub(super) fn add_graze(&self, window: &mut PeriodicWindow<R>, ends: &[AtEnd<R>]) {
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
