//! Whether two orbits are one, and how far apart they are if not.

use super::tail::between_phases;
use crate::analysis::map::CoordinateKind;

/// What an orbit settled to: the whole points of its period in order, or points of it where it has none.
#[derive(Clone, Debug)]
pub(super) struct Cycle {
    /// Samples after which it repeats; zero for none.
    pub period: u64,
    /// The points, one after the other.
    pub points: Vec<f64>,
}

/// Two orbits that are one differ by what is left of their approach: more than from one period to the next by as much as
/// the approach is slow.
const SLOWNESS: f64 = 1e4;

/// But never by more than this, relative to the largest value of a coordinate.
const LARGEST_DIFFERENCE: f64 = 1e-3;

/// A coordinate that is zero but for rounding errors, relative to the largest.
const ROUNDING: f64 = 1e-11;

/// Points of one attractor are as near to those of another orbit on it as to each other, up to this factor.
const NEARNESS: f64 = 4.0;

impl Cycle {
    fn point(&self, index: usize, dimension: usize) -> &[f64] {
        &self.points[index * dimension..(index + 1) * dimension]
    }

    fn len(&self, dimension: usize) -> usize {
        self.points.len() / dimension.max(1)
    }

    /// Whether this is the same orbit as another at the same parameters, wherever either starts. `tolerance` is that of
    /// periods.
    pub fn is(&self, other: &Self, kinds: &[CoordinateKind], tolerance: f64) -> bool {
        if self.period != other.period {
            return false;
        }
        if self.period == 0 {
            return self.overlaps(other, kinds);
        }
        let n = kinds.len();
        let count = self.len(n);
        if count == 0 || count != other.len(n) {
            return false;
        }
        let allowed = self.allowed(other, kinds, tolerance);
        (0..count).any(|shift| {
            (0..count).all(|index| {
                let a = self.point(index, n).iter();
                let b = other.point((index + shift) % count, n);
                a.zip(b)
                    .zip(kinds)
                    .zip(&allowed)
                    .all(|(((&x, &y), kind), &allowed)| match *kind {
                        CoordinateKind::Phase { period } => between_phases(x, y, period) <= allowed,
                        CoordinateKind::Plain => x == y || (x - y).abs() <= allowed,
                        CoordinateKind::Idle => true,
                    })
            })
        })
    }

    fn allowed(&self, other: &Self, kinds: &[CoordinateKind], tolerance: f64) -> Vec<f64> {
        let share = (tolerance * SLOWNESS).min(LARGEST_DIFFERENCE);
        let sizes: Vec<f64> = (0..kinds.len())
            .map(|k| {
                let values = self.points.iter().skip(k).step_by(kinds.len());
                let others = other.points.iter().skip(k).step_by(kinds.len());
                values
                    .chain(others)
                    .fold(0.0_f64, |most, x| most.max(x.abs()))
            })
            .collect();
        let plain = sizes
            .iter()
            .zip(kinds)
            .filter(|(_, kind)| **kind == CoordinateKind::Plain);
        let largest = plain.fold(0.0_f64, |most, (size, _)| most.max(*size));
        sizes
            .iter()
            .zip(kinds)
            .map(|(size, kind)| match *kind {
                CoordinateKind::Phase { period } => period * share,
                CoordinateKind::Plain | CoordinateKind::Idle => size * share + largest * ROUNDING,
            })
            .collect()
    }

    /// Whether the points of two orbits lie among each other.
    fn overlaps(&self, other: &Self, kinds: &[CoordinateKind]) -> bool {
        let (a, b) = vectors(self, other, kinds);
        let middle = |mut distances: Vec<f64>| {
            distances.sort_unstable_by(f64::total_cmp);
            distances
                .get(distances.len() / 2)
                .copied()
                .unwrap_or(f64::INFINITY)
        };
        let among = |points: &[Vec<f64>]| {
            let others = |skip: usize| points.iter().enumerate().filter(move |(k, _)| *k != skip);
            let nearest = |k: usize| nearest(&points[k], others(k).map(|(_, point)| point));
            middle((0..points.len()).map(nearest).collect())
        };
        let across = |from: &[Vec<f64>], to: &[Vec<f64>]| {
            middle(from.iter().map(|point| nearest(point, to.iter())).collect())
        };
        across(&a, &b) <= NEARNESS * among(&b) && across(&b, &a) <= NEARNESS * among(&a)
    }

    /// How far the points of two orbits are from each other, in the mean, in parts of their extent.
    pub fn distance(&self, other: &Self, kinds: &[CoordinateKind]) -> f64 {
        let (a, b) = vectors(self, other, kinds);
        let mean = |from: &[Vec<f64>], to: &[Vec<f64>]| {
            let distances = from.iter().map(|point| nearest(point, to.iter()));
            distances.sum::<f64>() / from.len() as f64
        };
        mean(&a, &b).max(mean(&b, &a))
    }
}

fn nearest<'a>(point: &[f64], others: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    let distance = |other: &Vec<f64>| {
        let pairs = point.iter().zip(other);
        pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
    };
    others.map(distance).fold(f64::INFINITY, f64::min)
}

/// The points of both in common units: parts of their common extent; phases as points of a circle.
fn vectors(a: &Cycle, b: &Cycle, kinds: &[CoordinateKind]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let n = kinds.len();
    let extents: Vec<(f64, f64)> = (0..n)
        .map(|k| {
            let values = a.points.iter().skip(k).step_by(n);
            let values = values.chain(b.points.iter().skip(k).step_by(n));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
                (low.min(x), high.max(x))
            })
        })
        .collect();
    let largest = (extents.iter()).fold(0.0_f64, |most, (low, high)| {
        most.max(low.abs()).max(high.abs())
    });
    let of = |cycle: &Cycle| -> Vec<Vec<f64>> {
        let points = (0..cycle.len(n)).map(|index| cycle.point(index, n));
        let vector = |point: &[f64]| {
            let mut vector = Vec::new();
            for ((&x, kind), (low, high)) in point.iter().zip(kinds).zip(&extents) {
                match *kind {
                    CoordinateKind::Plain if high - low > ROUNDING * largest => {
                        vector.push(x / (high - low));
                    }
                    CoordinateKind::Phase { period } => {
                        let angle = core::f64::consts::TAU * x / period;
                        vector.extend([libm::cos(angle) / 2.0, libm::sin(angle) / 2.0]);
                    }
                    CoordinateKind::Plain | CoordinateKind::Idle => {}
                }
            }
            vector
        };
        points.map(vector).collect()
    };
    (of(a), of(b))
}
