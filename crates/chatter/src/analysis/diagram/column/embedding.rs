//! Points as vectors whose distances mean something, whatever the units of their coordinates.

use super::tail::Tail;
use crate::analysis::map::CoordinateKind;
use crate::numerics::dispatch::{Kernel, dispatch};
use core::ops::Range;

/// A coordinate that varies by less than this, relative to its size, does so by rounding errors.
const ROUNDING: f64 = 1e-12;

/// Points whose coordinates vary by one: numbers in units of their extent, phases as points of a circle. Coordinates that
/// do not vary, as across a section, or on which nothing depends are left out.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Embedding {
    vectors: Vec<f64>,
    /// The same numbers, component by component: distances of many vectors are computed side by side.
    columns: Vec<Vec<f64>>,
}

/// So many distances are looked at together.
const ABREAST: usize = 16;

impl Embedding {
    /// Of the latest points, so many at most, of coordinates of these kinds and sizes.
    pub fn new(tail: &Tail, most: usize, (kinds, sizes): (&[CoordinateKind], &[f64])) -> Self {
        let skipped = tail.len().saturating_sub(most);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (index, (kind, size)) in kinds.iter().zip(sizes).enumerate() {
            let values = tail.coordinate(index).skip(skipped);
            match *kind {
                CoordinateKind::Idle { .. } => {}
                CoordinateKind::Plain => {
                    if let Some(column) = within_its_extent(values.collect(), ROUNDING * size) {
                        columns.push(column);
                    }
                }
                CoordinateKind::Phase { period } => {
                    let turn = core::f64::consts::TAU / period;
                    let angles = values.map(|x| (x - (x / period).floor() * period) * turn);
                    let of_circle = [
                        angles.clone().map(libm::cos).collect(),
                        angles.map(libm::sin).collect(),
                    ];
                    let vary = of_circle.into_iter();
                    columns.extend(vary.filter_map(|x| within_its_extent(x, ROUNDING)));
                }
            }
        }
        let count = columns.first().map_or(0, Vec::len);
        Self {
            vectors: (0..count)
                .flat_map(|row| columns.iter().map(move |column| column[row]))
                .collect(),
            columns,
        }
    }

    /// How many vectors there are.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// How many components each has.
    pub fn dimension(&self) -> usize {
        self.columns.len()
    }

    /// One of them.
    pub fn vector(&self, index: usize) -> &[f64] {
        let dimension = self.columns.len();
        &self.vectors[index * dimension..(index + 1) * dimension]
    }

    /// Distance of two of them.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        squared_distance(self.vector(a), self.vector(b)).sqrt()
    }

    /// The other vector among these that is nearest to one, the first if there are several, and its distance.
    pub fn nearest(&self, to: usize, among: Range<usize>) -> Option<(f64, usize)> {
        dispatch(Nearest {
            points: self,
            to,
            among,
        })
    }

    #[inline(always)]
    fn find_nearest(&self, to: usize, among: Range<usize>) -> Option<(f64, usize)> {
        let mut nearest: Option<(f64, usize)> = None;
        let mut least = f64::INFINITY;
        for first in among.clone().step_by(ABREAST) {
            let others = first..among.end.min(first + ABREAST);
            let squares = self.squared_distances(to, others.clone());
            let mut any = false;
            for square in squares {
                any |= square <= least;
            }
            if !any {
                continue;
            }
            for (other, square) in others.zip(squares) {
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
        }
        nearest
    }

    /// The squares of the distances of a vector from a few that follow each other. What is beyond these is as far as can be.
    #[inline(always)]
    fn squared_distances(&self, to: usize, others: Range<usize>) -> [f64; ABREAST] {
        let mut squares = [0.0; ABREAST];
        for column in &self.columns {
            let here = column[to];
            match column[others.clone()].first_chunk::<ABREAST>() {
                Some(there) => {
                    for (square, x) in squares.iter_mut().zip(there) {
                        *square += (here - x) * (here - x);
                    }
                }
                None => {
                    for (square, x) in squares.iter_mut().zip(&column[others.clone()]) {
                        *square += (here - x) * (here - x);
                    }
                }
            }
        }
        squares[others.len()..].fill(f64::INFINITY);
        squares
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

/// Numbers in units of their extent, about the middle of it; none where they vary by no more than this.
fn within_its_extent(mut column: Vec<f64>, rounding: f64) -> Option<Vec<f64>> {
    let low = column.iter().copied().fold(f64::INFINITY, f64::min);
    let high = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let extent = high - low;
    for x in &mut column {
        *x = (*x - low) / extent - 0.5;
    }
    (extent > rounding && extent.is_finite()).then_some(column)
}

struct Nearest<'a> {
    points: &'a Embedding,
    to: usize,
    among: Range<usize>,
}

impl Kernel for Nearest<'_> {
    type Output = Option<(f64, usize)>;
    #[inline(always)]
    fn run(self) -> Option<(f64, usize)> {
        self.points.find_nearest(self.to, self.among)
    }
}

#[inline]
fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>()
}
