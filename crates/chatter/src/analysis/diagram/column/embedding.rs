//! Points as vectors whose distances mean something, whatever the units of their coordinates.

use super::tail::Tail;
use crate::analysis::map::CoordinateKind;
use core::ops::Range;

/// A coordinate that varies by less than this, relative to the largest of the point, does so by rounding errors.
const ROUNDING: f64 = 1e-12;

/// Points whose coordinates vary by one: numbers in units of their extent, phases as points of a circle. Coordinates that
/// do not vary, as across a section, or on which nothing depends are left out.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Embedding {
    vectors: Vec<f64>,
    dimension: usize,
}

impl Embedding {
    /// Of the latest points, so many at most.
    pub fn new(tail: &Tail, most: usize, kinds: &[CoordinateKind]) -> Self {
        let skipped = tail.len().saturating_sub(most);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (index, kind) in kinds.iter().enumerate() {
            let values = tail.coordinate(index).skip(skipped);
            match *kind {
                CoordinateKind::Idle { .. } => {}
                CoordinateKind::Plain => columns.push(values.collect()),
                CoordinateKind::Phase { period } => {
                    let turn = core::f64::consts::TAU / period;
                    let angles = values.map(|x| (x - (x / period).floor() * period) * turn);
                    columns.push(angles.clone().map(libm::cos).collect());
                    columns.push(angles.map(libm::sin).collect());
                }
            }
        }
        let size = |column: &Vec<f64>| column.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let largest = columns.iter().map(size).fold(0.0, f64::max);
        columns.retain_mut(|column| {
            let low = column.iter().copied().fold(f64::INFINITY, f64::min);
            let high = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let extent = high - low;
            column
                .iter_mut()
                .for_each(|x| *x = (*x - low) / extent - 0.5);
            extent > ROUNDING * largest && extent.is_finite()
        });
        let count = columns.first().map_or(0, Vec::len);
        Self {
            dimension: columns.len(),
            vectors: (0..count)
                .flat_map(|row| columns.iter().map(move |column| column[row]))
                .collect(),
        }
    }

    /// How many vectors there are.
    pub fn len(&self) -> usize {
        self.vectors.len() / self.dimension.max(1)
    }

    /// How many components each has.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// One of them.
    pub fn vector(&self, index: usize) -> &[f64] {
        &self.vectors[index * self.dimension..(index + 1) * self.dimension]
    }

    /// Distance of two of them.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        squared_distance(self.vector(a), self.vector(b)).sqrt()
    }

    /// The other vector among these that is nearest to one, the first if there are several, and its distance.
    pub fn nearest(&self, to: usize, among: Range<usize>) -> Option<(f64, usize)> {
        let mut nearest: Option<(f64, usize)> = None;
        let mut least = f64::INFINITY;
        let vector = self.vector(to);
        let places = among.start * self.dimension..among.end * self.dimension;
        let others = self.vectors[places].chunks_exact(self.dimension);
        for (other, square) in among.zip(others.map(|other| squared_distance(vector, other))) {
            if square > least || other == to {
                continue;
            }
            // Squares that differ may have one root.
            let distance = square.sqrt();
            if nearest.is_none_or(|(nearest, _)| distance.total_cmp(&nearest).is_lt()) {
                nearest = Some((distance, other));
                least = square;
            }
        }
        nearest
    }

    /// Mean distance of vectors so many places apart, from one on; none as soon as it is certain to exceed `least`.
    pub fn mean_step(&self, first: usize, apart: usize, least: f64) -> Option<f64> {
        let places = first + apart..self.len();
        let count = places.len() as f64;
        // The product may be rounded downwards.
        let enough = least * count * (1.0 + 4.0 * f64::EPSILON);
        let mut sum = 0.0;
        for place in places {
            sum += self.distance(place, place - apart);
            if sum > enough {
                return None;
            }
        }
        Some(sum / count)
    }
}

#[inline]
fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>()
}
