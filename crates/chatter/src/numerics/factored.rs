//! Systems of linear equations, solved by elimination that passes over zeros: block-cyclic systems cost what their blocks cost.

use super::{Matrix, Real, unit};

/// A square matrix as the product of triangular factors, its rows scaled to their largest entry and exchanged.
#[derive(Clone, Debug)]
pub struct Factored<R> {
    /// Ones on its diagonal.
    lower: Triangle<R>,
    upper: Triangle<R>,
    /// The diagonal of the upper one.
    pivots: Vec<R>,
    /// Which row of the matrix stands in each row.
    order: Vec<usize>,
    /// What each row of the matrix was multiplied by.
    scales: Vec<R>,
    /// Sign of the exchanges.
    sign: f64,
}

/// Rows of a triangular matrix: what is not zero beside the diagonal, with its column.
#[derive(Clone, Debug)]
struct Triangle<R> {
    entries: Vec<(usize, R)>,
    /// Where each row ends among them.
    ends: Vec<usize>,
}

impl<R: Real> Triangle<R> {
    fn with_rows(rows: usize) -> Self {
        Self {
            entries: Vec::new(),
            ends: Vec::with_capacity(rows),
        }
    }

    fn push(&mut self, row: impl IntoIterator<Item = (usize, R)>) {
        self.entries.extend(row);
        self.ends.push(self.entries.len());
    }

    fn row(&self, index: usize) -> &[(usize, R)] {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.entries[start..self.ends[index]]
    }

    /// The product of a row with a vector.
    fn dot(&self, row: usize, vector: &[R]) -> R {
        let entries = self.row(row).iter();
        entries.fold(R::ZERO, |sum, &(k, entry)| sum + entry * vector[k])
    }
}

/// What is not zero of the columns from one on.
fn present<R: Real>(row: &[R], from: usize) -> impl Iterator<Item = (usize, R)> {
    let entries = row.iter().copied().enumerate().skip(from);
    entries.filter(|(_, entry)| *entry != R::ZERO)
}

impl<R: Real> Factored<R> {
    /// The factors; `None` where it is singular to the last bit, or not finite.
    pub(super) fn of(mut matrix: Matrix<R>) -> Option<Self> {
        let size = matrix.rows();
        let mut scales = Vec::with_capacity(size);
        // Before these columns rows have no entries.
        let mut starts = Vec::with_capacity(size);
        for i in 0..size {
            let row = matrix.row_mut(i);
            let (mut largest, mut start) = (R::ZERO, size);
            for (k, entry) in present(row, 0) {
                largest = largest.max(entry.abs());
                start = start.min(k);
            }
            if largest == R::ZERO || !largest.is_finite() {
                return None;
            }
            starts.push(start);
            // A power of two: scaling is exact.
            let scale = R::splat(libm::exp2(-libm::log2(largest.to_f64()).round()));
            row.iter_mut().for_each(|x| *x *= scale);
            scales.push(scale);
        }
        let mut order: Vec<usize> = (0..size).collect();
        let mut sign = 1.0;
        let mut upper = Triangle::with_rows(size);
        let mut pivots = Vec::with_capacity(size);
        for column in 0..size {
            let mut pivot = column;
            for row in column + 1..size {
                if starts[row] <= column
                    && matrix[(row, column)].abs() > matrix[(pivot, column)].abs()
                {
                    pivot = row;
                }
            }
            let leading = matrix[(pivot, column)];
            if leading == R::ZERO || !leading.is_finite() {
                return None;
            }
            pivots.push(leading);
            if pivot != column {
                matrix.exchange(pivot, column);
                order.swap(pivot, column);
                starts.swap(pivot, column);
                sign = -sign;
            }
            upper.push(present(matrix.row(column), column + 1));
            let leader = upper.row(column);
            for row in column + 1..size {
                if starts[row] > column || matrix[(row, column)] == R::ZERO {
                    continue;
                }
                let row = matrix.row_mut(row);
                let factor = row[column] / leading;
                row[column] = factor;
                for &(k, above) in leader {
                    row[k] -= factor * above;
                }
            }
        }
        let mut lower = Triangle::with_rows(size);
        for (i, &start) in starts.iter().enumerate() {
            lower.push(present(&matrix.row(i)[..i], start));
        }
        Some(Self {
            lower,
            upper,
            pivots,
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
            let known = self.lower.dot(i, &x);
            x[i] -= known;
        }
        for i in (0..size).rev() {
            let known = self.upper.dot(i, &x);
            x[i] = (x[i] - known) / self.pivots[i];
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
            y[i] = y[i] / self.pivots[i];
            let known = y[i];
            for &(k, factor) in self.upper.row(i) {
                y[k] -= factor * known;
            }
        }
        for i in (0..size).rev() {
            let known = y[i];
            for &(k, factor) in self.lower.row(i) {
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
        let parts = self.pivots.iter().zip(&self.scales);
        parts.fold(R::splat(self.sign), |product, (&pivot, &scale)| {
            product * pivot / scale
        })
    }

    /// Sign of the determinant.
    pub fn determinant_sign(&self) -> f64 {
        let negative = self.pivots.iter().filter(|pivot| **pivot < R::ZERO);
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
            // Zeros anywhere, diagonals in two places of a row so that rows are exchanged, and rows of different sizes.
            for i in 0..6 {
                let row = matrix.row_mut(i).iter_mut();
                row.filter(|x| x.abs() < 0.6).for_each(|x| *x = 0.0);
                matrix[(i, i)] += 6.0;
                matrix[(i, (i + 1) % 6)] -= 13.0;
                matrix.row_mut(i).iter_mut().for_each(|x| *x *= libm::exp2(i as f64 * 5.0));
            }
            let largest = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let factored = matrix.factored().unwrap();
            // Elimination solves a system that differs from this one, of rows of one size, by rounding, which exchanged rows enlarge.
            let x = factored.solve(&right);
            for (i, (a, b)) in matrix.apply(&x).iter().zip(&right).enumerate() {
                let size = largest(matrix.row(i)) * largest(&x);
                prop_assert!((a - b).abs() < 1e-13 * size, "{} {} {}", a, b, size);
            }
            let y = factored.solve_transposed(&right);
            let terms: Vec<f64> = (0..6).map(|i| largest(matrix.row(i)) * y[i]).collect();
            for (a, b) in matrix.apply_transposed(&y).iter().zip(&right) {
                prop_assert!((a - b).abs() < 1e-13 * largest(&terms), "{} {}", a, b);
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
