//! Points as vectors whose distances mean something, whatever the units of their coordinates.

use super::tail::Tail;
use crate::analysis::map::CoordinateKind;
use crate::numerics::dispatch::{Kernel, dispatch};
use core::ops::Range;

/// A coordinate that varies by less than this, relative to its size, does so by rounding errors.
const ROUNDING: f64 = 1e-12;

/// What is left of a coordinate without what it has in common with others, where it is less than this part of it, is rounding
/// error: tolerances of periods are that much larger.
const IN_COMMON: f64 = 1e-5;

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
                    // Rounding errors are those of the number, whole periods and all.
                    let rounding = ROUNDING * (size * turn).max(1.0);
                    columns.extend(vary.filter_map(|x| within_its_extent(x, rounding)));
                }
            }
        }
        Self::of(columns)
    }

    /// Those from one on, as vectors of which the differences of those so many places apart vary equally and independently by
    /// component: their lengths are those by the inverse of their second moments, whatever linear combinations the coordinates
    /// are.
    pub fn evened(&self, first: usize, apart: usize) -> Self {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut differences: Vec<Vec<f64>> = Vec::new();
        for column in &self.columns {
            let mut column = column[first..].to_vec();
            let pairs = column.iter().zip(&column[apart..]);
            let mut difference: Vec<f64> = pairs.map(|(x, y)| x - y).collect();
            let before = dot(&difference, &difference).sqrt();
            for (other, its) in columns.iter().zip(&differences) {
                let common = dot(&difference, its);
                (difference.iter_mut().zip(its)).for_each(|(x, y)| *x -= common * y);
                (column.iter_mut().zip(other)).for_each(|(x, y)| *x -= common * y);
            }
            let left = dot(&difference, &difference).sqrt();
            if left > IN_COMMON * before {
                difference.iter_mut().for_each(|x| *x /= left);
                column.iter_mut().for_each(|x| *x /= left);
                differences.push(difference);
                columns.push(column);
            }
        }
        Self::of(columns)
    }

    /// The extent of a component from a vector on.
    pub fn extent(&self, component: usize, first: usize) -> f64 {
        let values = self.columns[component][first..].iter().copied();
        let high = values.clone().fold(f64::NEG_INFINITY, f64::max);
        high - values.fold(f64::INFINITY, f64::min)
    }

    fn of(columns: Vec<Vec<f64>>) -> Self {
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
        let blocks = || among.clone().step_by(ABREAST);
        let others = |first: usize| first..among.end.min(first + ABREAST);
        let mut least = [f64::INFINITY; ABREAST];
        for first in blocks() {
            let mut squares = self.squared_distances(to, others(first));
            if others(first).contains(&to) {
                squares[to - first] = f64::INFINITY;
            }
            for (least, square) in least.iter_mut().zip(squares) {
                *least = if square < *least { square } else { *least };
            }
        }
        let least = least.into_iter().fold(f64::INFINITY, f64::min);
        let distance = least.sqrt();
        // Squares that differ may have one root.
        let bound = least * (1.0 + 8.0 * f64::EPSILON);
        for first in blocks() {
            let squares = self.squared_distances(to, others(first));
            let mut any = false;
            for square in squares {
                any |= square <= bound;
            }
            if !any {
                continue;
            }
            let mut pairs = others(first).zip(squares);
            let found = pairs.find(|&(other, square)| other != to && square.sqrt() == distance);
            if let Some((other, _)) = found {
                return Some((distance, other));
            }
        }
        None
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

    /// Mean of the logarithms of distances of vectors so many places apart, but for those that are the same.
    pub fn mean_logarithm(&self, apart: usize) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        // Logarithms of products of squares, as many as no product of which underflows.
        let mut product = 1.0;
        for place in apart..self.len() {
            let square = squared_distance(self.vector(place), self.vector(place - apart));
            if square > SAME {
                product *= square;
                count += 1.0;
            }
            if product < SAME {
                sum += libm::log(product);
                product = 1.0;
            }
        }
        (sum + libm::log(product)) / (2.0 * count)
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

/// The square of a distance far below rounding errors. It has itself a square.
const SAME: f64 = 1e-100;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_the_first_of_those_at_the_least_distance() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005);
            seed = seed.wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        // On a coarse lattice most points have several others at one distance; places that are no numbers are near to none.
        for (count, lattice) in [(1, 1e9), (2, 1e9), (70, 1e9), (70, 4.0), (300, 9.0)] {
            let mut column = || {
                let values = (0..count).map(|_| (lattice * random()).floor() / lattice);
                values.collect::<Vec<f64>>()
            };
            let mut columns = vec![column(), column()];
            columns[0].extend([f64::NAN, 0.5, 0.5]);
            columns[1].extend([0.5, f64::NAN, f64::INFINITY]);
            let points = Embedding::of(columns);
            for to in 0..count {
                for among in [0..points.len(), count / 3..count, to..to + 1, 5..5] {
                    let others = among.clone().filter(|&other| other != to);
                    let distances = others.map(|other| (points.distance(to, other), other));
                    let told = distances.filter(|(distance, _)| !distance.is_nan());
                    let nearest = told.min_by(|a, b| a.0.total_cmp(&b.0));
                    assert_eq!(points.nearest(to, among), nearest);
                }
            }
        }
    }
}
