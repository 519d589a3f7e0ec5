//! Dense matrices, solved by elimination that passes over zeros: block-cyclic systems cost what their blocks cost.

use super::Real;
use core::ops::{Index, IndexMut};

/// A matrix, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix<R> {
    rows: usize,
    columns: usize,
    entries: Vec<R>,
}

impl<R: Real> Matrix<R> {
    /// All zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            entries: vec![R::ZERO; rows * columns],
        }
    }

    /// Of rows of one length.
    pub fn from_rows(rows: &[Vec<R>]) -> Self {
        Self {
            rows: rows.len(),
            columns: rows.first().map_or(0, Vec::len),
            entries: rows.concat(),
        }
    }

    /// Ones on the diagonal.
    pub fn identity(size: usize) -> Self {
        let mut matrix = Self::zeros(size, size);
        for i in 0..size {
            matrix[(i, i)] = R::ONE;
        }
        matrix
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// One row.
    pub fn row(&self, index: usize) -> &[R] {
        &self.entries[index * self.columns..(index + 1) * self.columns]
    }

    /// One row, to be written.
    pub fn row_mut(&mut self, index: usize) -> &mut [R] {
        &mut self.entries[index * self.columns..(index + 1) * self.columns]
    }

    /// One more row at the end: as long as the others.
    pub fn push(&mut self, row: &[R]) {
        debug_assert_eq!(row.len(), self.columns);
        self.entries.extend_from_slice(row);
        self.rows += 1;
    }

    /// The product with another matrix.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for (k, &factor) in self.row(i).iter().enumerate() {
                if factor == R::ZERO {
                    continue;
                }
                let target = &mut product.entries[i * other.columns..(i + 1) * other.columns];
                for (entry, &by) in target.iter_mut().zip(other.row(k)) {
                    *entry += factor * by;
                }
            }
        }
        product
    }

    /// The product with a vector.
    pub fn apply(&self, vector: &[R]) -> Vec<R> {
        (0..self.rows).map(|i| dot(self.row(i), vector)).collect()
    }

    /// The product of its transpose with a vector.
    pub fn apply_transposed(&self, vector: &[R]) -> Vec<R> {
        let mut product = vec![R::ZERO; self.columns];
        for (i, &factor) in vector.iter().enumerate() {
            if factor == R::ZERO {
                continue;
            }
            for (entry, &by) in product.iter_mut().zip(self.row(i)) {
                *entry += factor * by;
            }
        }
        product
    }

    /// The second compound: all minors of two rows and two columns, pairs in lexical order. That of a product is the product of
    /// those of its factors, in which large and small parts do not mix as in minors of the product.
    pub fn minors(&self) -> Self {
        let rows: Vec<Vec<R>> = pairs(self.rows())
            .map(|(i, k)| {
                pairs(self.columns())
                    .map(|(j, l)| self[(i, j)] * self[(k, l)] - self[(i, l)] * self[(k, j)])
                    .collect()
            })
            .collect();
        Self::from_rows(&rows)
    }

    /// All columns but those, as many as there are rows, that complete pivoting eliminates with: unknowns that may be chosen where the
    /// rows are equations for the others.
    pub fn free_columns(&self) -> Vec<usize> {
        let mut work = self.clone();
        let mut free: Vec<usize> = (0..self.columns()).collect();
        let mut left: Vec<usize> = (0..self.rows()).collect();
        loop {
            // Of equals the first.
            let places = left
                .iter()
                .flat_map(|&row| free.iter().map(move |&i| (row, i)));
            let larger = |a, b| if work[b].abs() > work[a].abs() { b } else { a };
            let Some((row, pivot)) = places.reduce(larger) else {
                return free;
            };
            free.retain(|&i| i != pivot);
            left.retain(|&other| other != row);
            let above = work.row(row).to_vec();
            for &other in &left {
                let factor = work[(other, pivot)] / above[pivot];
                let entries = work.row_mut(other).iter_mut().zip(&above);
                entries.for_each(|(entry, &above)| *entry -= factor * above);
            }
        }
    }

    /// Each number to double precision.
    pub fn to_f64(&self) -> Matrix<f64> {
        Matrix {
            rows: self.rows,
            columns: self.columns,
            entries: self.entries.iter().map(|x| x.to_f64()).collect(),
        }
    }

    /// The factors of a square matrix; `None` where it is singular to the last bit, or not finite.
    pub fn factored(&self) -> Option<Factored<R>> {
        Factored::new(self.clone())
    }
}

impl<R> Index<(usize, usize)> for Matrix<R> {
    type Output = R;
    fn index(&self, (row, column): (usize, usize)) -> &R {
        &self.entries[row * self.columns + column]
    }
}

impl<R> IndexMut<(usize, usize)> for Matrix<R> {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut R {
        &mut self.entries[row * self.columns + column]
    }
}

/// Pairs of different numbers below `size` in lexical order, each once.
pub fn pairs(size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size).flat_map(move |first| (first + 1..size).map(move |second| (first, second)))
}

/// The vector whose only entry is a one.
pub fn unit<R: Real>(size: usize, index: usize) -> Vec<R> {
    let mut unit = vec![R::ZERO; size];
    unit[index] = R::ONE;
    unit
}

/// A point moved by a part of a vector.
pub fn moved<R: Real>(from: &[R], by: &[R], part: R) -> Vec<R> {
    from.iter().zip(by).map(|(&x, &v)| x + v * part).collect()
}

/// The scalar product of two vectors.
pub fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    a.iter().zip(b).fold(R::ZERO, |sum, (&a, &b)| sum + a * b)
}

/// A square matrix as the product of triangular factors, its rows scaled to their largest entry and exchanged.
#[derive(Clone, Debug)]
pub struct Factored<R> {
    factors: Matrix<R>,
    /// Which row of the matrix stands in each row.
    order: Vec<usize>,
    /// What each row of the matrix was multiplied by.
    scales: Vec<R>,
    /// Sign of the exchanges.
    sign: f64,
}

impl<R: Real> Factored<R> {
    fn new(mut matrix: Matrix<R>) -> Option<Self> {
        let size = matrix.rows;
        let mut scales = Vec::with_capacity(size);
        for i in 0..size {
            let row = matrix.row_mut(i);
            let largest = row.iter().fold(R::ZERO, |most, x| most.max(x.abs()));
            if largest == R::ZERO || !largest.is_finite() {
                return None;
            }
            // A power of two: scaling is exact.
            let scale = R::splat(libm::exp2(-libm::log2(largest.to_f64()).round()));
            row.iter_mut().for_each(|x| *x *= scale);
            scales.push(scale);
        }
        let mut order: Vec<usize> = (0..size).collect();
        let mut sign = 1.0;
        for column in 0..size {
            let mut pivot = column;
            for row in column + 1..size {
                if matrix[(row, column)].abs() > matrix[(pivot, column)].abs() {
                    pivot = row;
                }
            }
            let leading = matrix[(pivot, column)];
            if leading == R::ZERO || !leading.is_finite() {
                return None;
            }
            if pivot != column {
                let (above, below) = matrix.entries.split_at_mut(pivot * size);
                above[column * size..(column + 1) * size].swap_with_slice(&mut below[..size]);
                order.swap(pivot, column);
                sign = -sign;
            }
            let (above, below) = matrix.entries.split_at_mut((column + 1) * size);
            let leader = &above[column * size..];
            // Beyond the last entry of the pivot's row nothing changes.
            let end = (column..size)
                .rev()
                .find(|&k| leader[k] != R::ZERO)
                .map_or(column, |k| k + 1);
            for row in below.chunks_exact_mut(size) {
                if row[column] == R::ZERO {
                    continue;
                }
                let factor = row[column] / leading;
                row[column] = factor;
                for k in column + 1..end {
                    row[k] -= factor * leader[k];
                }
            }
        }
        Some(Self {
            factors: matrix,
            order,
            scales,
            sign,
        })
    }

    /// x of A x = b.
    pub fn solve(&self, right: &[R]) -> Vec<R> {
        let size = self.order.len();
        let mut x: Vec<R> = (self.order.iter())
            .map(|&row| right[row] * self.scales[row])
            .collect();
        for i in 0..size {
            let known = dot(&self.factors.row(i)[..i], &x[..i]);
            x[i] -= known;
        }
        for i in (0..size).rev() {
            let known = dot(&self.factors.row(i)[i + 1..], &x[i + 1..]);
            x[i] = (x[i] - known) / self.factors[(i, i)];
        }
        x
    }

    /// The columns of the inverse.
    pub fn inverse(&self) -> impl Iterator<Item = Vec<R>> {
        let size = self.order.len();
        (0..size).map(move |index| self.solve(&unit(size, index)))
    }

    /// x of A^T x = b.
    pub fn solve_transposed(&self, right: &[R]) -> Vec<R> {
        let size = self.order.len();
        let mut y = right.to_vec();
        for i in 0..size {
            y[i] = y[i] / self.factors[(i, i)];
            let known = y[i];
            for (k, &factor) in self.factors.row(i).iter().enumerate().skip(i + 1) {
                y[k] -= factor * known;
            }
        }
        for i in (0..size).rev() {
            let known = y[i];
            for (k, &factor) in self.factors.row(i)[..i].iter().enumerate() {
                y[k] -= factor * known;
            }
        }
        let mut x = vec![R::ZERO; size];
        for (place, &row) in self.order.iter().enumerate() {
            x[row] = y[place] * self.scales[row];
        }
        x
    }

    /// The determinant.
    pub fn determinant(&self) -> R {
        (0..self.order.len()).fold(R::splat(self.sign), |product, i| {
            product * self.factors[(i, i)] / self.scales[i]
        })
    }

    /// Sign of the determinant.
    pub fn determinant_sign(&self) -> f64 {
        let negative = (0..self.order.len()).filter(|&i| self.factors[(i, i)] < R::ZERO);
        if negative.count() % 2 == 0 {
            self.sign
        } else {
            -self.sign
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};
    use proptest::prelude::*;

    #[test]
    fn free_columns_are_those_without_pivots() {
        let rows = [vec![1.0, 0.0, -5.0, 2.0], vec![0.5, 3.0, -2.5, 1.0]];
        assert_eq!(Matrix::from_rows(&rows).free_columns(), [0, 3]);
        // After the first row nothing is left of the third column.
        let rows = [vec![1.0, 0.0, 4.0], vec![0.5, 0.1, 2.0]];
        assert_eq!(Matrix::from_rows(&rows).free_columns(), [0]);
    }

    fn of(entries: &[f64], size: usize) -> Matrix<f64> {
        let mut matrix = Matrix::zeros(size, size);
        for i in 0..size {
            matrix
                .row_mut(i)
                .copy_from_slice(&entries[i * size..(i + 1) * size]);
        }
        matrix
    }

    proptest! {
        #[test]
        fn solutions_satisfy_both_systems(
            entries in proptest::collection::vec(-1.0_f64..1.0, 36),
            right in proptest::collection::vec(-1.0_f64..1.0, 6),
        ) {
            let mut matrix = of(&entries, 6);
            // Zeros as in block systems, and rows of different sizes.
            for i in 0..6 {
                matrix[(i, (i + 3) % 6)] = 0.0;
                matrix[(i, i)] += 6.0;
                matrix.row_mut(i).iter_mut().for_each(|x| *x *= libm::exp2(i as f64 * 5.0));
            }
            let factored = matrix.factored().unwrap();
            let x = factored.solve(&right);
            for (i, b) in right.iter().enumerate() {
                let terms: Vec<f64> = matrix.row(i).iter().zip(&x).map(|(a, x)| a * x).collect();
                let size: f64 = terms.iter().map(|term| term.abs()).sum();
                let off = terms.iter().sum::<f64>() - b;
                prop_assert!(off.abs() < 1e-14 * (1.0 + size), "{} {}", off, size);
            }
            let y = factored.solve_transposed(&right);
            for (a, b) in matrix.apply_transposed(&y).iter().zip(&right) {
                prop_assert!((a - b).abs() < 1e-13, "{} {}", a, b);
            }
        }
    }

    #[test]
    fn the_sign_of_a_determinant_counts_exchanges() {
        let sign = |entries: &[f64]| of(entries, 2).factored().map(|f| f.determinant_sign());
        assert_eq!(sign(&[0.0, 1.0, 1.0, 0.0]), Some(-1.0));
        assert_eq!(sign(&[2.0, 1.0, 1.0, 3.0]), Some(1.0));
        assert_eq!(sign(&[1.0, 2.0, 2.0, 1.0]), Some(-1.0));
        assert_eq!(sign(&[1.0, 2.0, 2.0, 4.0]), None);
    }

    #[test]
    fn longer_numbers_keep_their_digits() {
        let third = DoubleDouble::ONE / DoubleDouble::from(3.0);
        let mut matrix = Matrix::identity(2);
        matrix[(0, 1)] = third;
        let x = matrix
            .factored()
            .unwrap()
            .solve(&[DoubleDouble::ONE, third]);
        let off = x[0] - (DoubleDouble::ONE - third * third);
        assert!(off.abs().to_f64() < 1e-31);
    }
}
