//! Whether two orbits are one, and how far apart they are if not.

use super::tail::between_phases;
use crate::analysis::map::CoordinateKind;

/// What an orbit settled to: the whole points of its period in order, or points of it where it has none.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Cycle {
    /// Samples after which it repeats; zero for none.
    pub period: u64,
    /// The points, one after the other.
    pub points: Vec<f64>,
    /// What sizes their coordinates have, between them, too.
    pub sizes: Vec<f64>,
}

/// Two orbits that are one differ by what is left of their approach: more than from one period to the next by as much as
/// the approach is slow.
const SLOWNESS: f64 = 1e4;

/// But never by more than this, relative to the largest value of a coordinate.
const LARGEST_DIFFERENCE: f64 = 1e-3;

/// A coordinate that is zero but for rounding errors, relative to its size elsewhere.
const ROUNDING: f64 = 1e-11;

/// Some points of an orbit, this part of them, …
const SOME: usize = 4;

/// … lie as near to those of another orbit on the same attractor as these to each other, up to this factor: samples are few
/// and not even. Between attractors that do not overlap it is tens to hundreds.
const NEARNESS: f64 = 15.0;

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
                        CoordinateKind::Idle { .. } => true,
                    })
            })
        })
    }

    fn allowed(&self, other: &Self, kinds: &[CoordinateKind], tolerance: f64) -> Vec<f64> {
        let share = (tolerance * SLOWNESS).min(LARGEST_DIFFERENCE);
        let at_points = |k: usize| {
            let values = self.points.iter().skip(k).step_by(kinds.len());
            let others = other.points.iter().skip(k).step_by(kinds.len());
            values
                .chain(others)
                .fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        (kinds.iter().enumerate())
            .map(|(k, kind)| match *kind {
                CoordinateKind::Phase { period } => period * share,
                CoordinateKind::Plain | CoordinateKind::Idle { .. } => {
                    at_points(k) * share + self.sizes[k].max(other.sizes[k]) * ROUNDING
                }
            })
            .collect()
    }

    /// Whether the points of two orbits lie among each other.
    fn overlaps(&self, other: &Self, kinds: &[CoordinateKind]) -> bool {
        let units = Units::of([self, other], kinds);
        let (a, b) = (units.vectors(self), units.vectors(other));
        let among = |points: &[Vec<f64>]| {
            let others = |skip: usize| points.iter().enumerate().filter(move |(k, _)| *k != skip);
            let nearest = |k: usize| nearest(&points[k], others(k).map(|(_, point)| point));
            quantile((0..points.len()).map(nearest).collect(), 2)
        };
        let across = |from: &[Vec<f64>], to: &[Vec<f64>]| {
            let distances = from.iter().map(|point| nearest(point, to.iter()));
            quantile(distances.collect(), SOME)
        };
        across(&a, &b) <= NEARNESS * among(&b) && across(&b, &a) <= NEARNESS * among(&a)
    }

    /// How far the points of two orbits are from each other, in the mean.
    pub fn distance(&self, other: &Self, units: &Units<'_>) -> f64 {
        let (a, b) = (units.vectors(self), units.vectors(other));
        let mean = |from: &[Vec<f64>], to: &[Vec<f64>]| {
            let distances = from.iter().map(|point| nearest(point, to.iter()));
            distances.sum::<f64>() / from.len() as f64
        };
        mean(&a, &b).max(mean(&b, &a))
    }
}

/// The number below which the first of so many equal parts of these are.
fn quantile(mut numbers: Vec<f64>, parts: usize) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    let place = numbers.len() / parts;
    numbers.get(place).copied().unwrap_or(f64::INFINITY)
}

fn nearest<'a>(point: &[f64], others: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    let distance = |other: &Vec<f64>| {
        let pairs = point.iter().zip(other);
        pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
    };
    others.map(distance).fold(f64::INFINITY, f64::min)
}

/// Common units of orbits: the extent of each coordinate over all of them; phases as points of a circle.
pub(in crate::analysis::diagram) struct Units<'a> {
    kinds: &'a [CoordinateKind],
    /// Zero for coordinates that do not vary.
    extents: Vec<f64>,
}

impl<'a> Units<'a> {
    /// Of these orbits.
    pub fn of<'c>(
        cycles: impl IntoIterator<Item = &'c Cycle>,
        kinds: &'a [CoordinateKind],
    ) -> Self {
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); kinds.len()];
        let mut sizes = vec![0.0_f64; kinds.len()];
        for cycle in cycles {
            for (size, &other) in sizes.iter_mut().zip(&cycle.sizes) {
                *size = size.max(other);
            }
            for point in cycle.points.chunks_exact(kinds.len()) {
                for ((low, high), &x) in ranges.iter_mut().zip(point) {
                    (*low, *high) = (low.min(x), high.max(x));
                }
            }
        }
        let extent = |((low, high), size): (&(f64, f64), &f64)| match high - low {
            extent if extent > ROUNDING * size && extent.is_finite() => extent,
            _ => 0.0,
        };
        let extents = ranges.iter().zip(&sizes).map(extent).collect();
        Self { kinds, extents }
    }

    fn vectors(&self, cycle: &Cycle) -> Vec<Vec<f64>> {
        let vector = |point: &[f64]| {
            let mut vector = Vec::new();
            for ((&x, kind), &extent) in point.iter().zip(self.kinds).zip(&self.extents) {
                match *kind {
                    CoordinateKind::Plain if extent > 0.0 => vector.push(x / extent),
                    CoordinateKind::Phase { period } => {
                        let angle = core::f64::consts::TAU * x / period;
                        vector.extend([libm::cos(angle) / 2.0, libm::sin(angle) / 2.0]);
                    }
                    CoordinateKind::Plain | CoordinateKind::Idle { .. } => {}
                }
            }
            vector
        };
        cycle
            .points
            .chunks_exact(self.kinds.len())
            .map(vector)
            .collect()
    }
}
