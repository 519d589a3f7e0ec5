//! Dense matrices.

use super::{Factored, Real};
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

    /// Two rows change places.
    pub(super) fn exchange(&mut self, one: usize, other: usize) {
        let (first, last) = (one.min(other), one.max(other));
        if first < last {
            let (above, below) = self.entries.split_at_mut(last * self.columns);
            above[first * self.columns..(first + 1) * self.columns]
                .swap_with_slice(&mut below[..self.columns]);
        }
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
        Factored::of(self.clone())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_columns_are_those_without_pivots() {
        let rows = [vec![1.0, 0.0, -5.0, 2.0], vec![0.5, 3.0, -2.5, 1.0]];
        assert_eq!(Matrix::from_rows(&rows).free_columns(), [0, 3]);
        // After the first row nothing is left of the third column.
        let rows = [vec![1.0, 0.0, 4.0], vec![0.5, 0.1, 2.0]];
        assert_eq!(Matrix::from_rows(&rows).free_columns(), [0]);
    }
}
