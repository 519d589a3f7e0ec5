//! Windows of periodic orbits, as values.

use super::super::windows::Located;
use crate::numerics::Real;

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

/// Edges with the one at the smaller mu first.
pub(super) fn in_order<R: Real>(mut edges: Vec<Edge<R>>) -> Vec<Edge<R>> {
    // Doubles may not tell them apart.
    edges.sort_by(|a, b| (a.at.mu - b.at.mu).to_f64().total_cmp(&0.0));
    edges
}
