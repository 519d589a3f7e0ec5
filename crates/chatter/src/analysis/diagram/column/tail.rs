//! The latest whole points of an orbit.

use crate::analysis::map::CoordinateKind;

/// Whole points at samples, as many of the latest as are wanted or more.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Tail {
    points: Vec<f64>,
    dimension: usize,
    wanted: usize,
}

impl Tail {
    /// Of points of this dimension.
    pub fn new(dimension: usize, wanted: usize) -> Self {
        Self {
            points: Vec::new(),
            dimension,
            wanted,
        }
    }

    /// Makes room for so many points at once.
    pub fn reserve(&mut self, points: usize) {
        let points = points.min(self.wanted.saturating_mul(2));
        self.points.reserve(points * self.dimension);
    }

    /// The orbit has come to another point.
    pub fn push(&mut self, point: &[f64]) {
        // Half of the room is emptied at once, so that each point is moved at most once.
        let room = self.wanted.saturating_mul(2 * self.dimension);
        if self.points.len() >= room {
            self.points.drain(..self.wanted * self.dimension);
        }
        self.points.extend_from_slice(point);
    }

    /// Takes coordinates relative to those that they matter only relative to.
    pub fn relate(&mut self, kinds: &[CoordinateKind]) {
        for (index, kind) in kinds.iter().enumerate() {
            let CoordinateKind::Idle { others } = kind else {
                continue;
            };
            if others.is_empty() {
                continue;
            }
            for point in self.points.chunks_exact_mut(self.dimension) {
                let own = point[index];
                for &(other, times) in others {
                    point[other] -= times * own;
                }
            }
        }
    }

    /// The largest size of each coordinate.
    pub fn sizes(&self) -> Vec<f64> {
        let largest = |index| {
            self.coordinate(index)
                .fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        (0..self.dimension).map(largest).collect()
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.points.len() / self.dimension.max(1)
    }

    /// One of them, from the earliest.
    pub fn point(&self, index: usize) -> &[f64] {
        &self.points[index * self.dimension..(index + 1) * self.dimension]
    }

    /// One coordinate of all of them.
    pub fn coordinate(&self, index: usize) -> impl Iterator<Item = f64> + Clone {
        let points = self.points.iter().skip(index);
        points.step_by(self.dimension.max(1)).copied()
    }

    /// The latest points one after the other, phases in their first period: what is compared with other orbits.
    pub fn latest(&self, count: usize, kinds: &[CoordinateKind]) -> Vec<f64> {
        let first = self.len().saturating_sub(count);
        (first..self.len())
            .flat_map(|index| self.point(index).iter().zip(kinds))
            .map(|(&x, kind)| match *kind {
                CoordinateKind::Phase { period } => x - (x / period).floor() * period,
                CoordinateKind::Plain | CoordinateKind::Idle { .. } => x,
            })
            .collect()
    }
}

/// Distance of two phases.
pub(in crate::analysis::diagram) fn between_phases(a: f64, b: f64, period: f64) -> f64 {
    let turns = (a - b) / period;
    (turns - turns.round()).abs() * period
}
