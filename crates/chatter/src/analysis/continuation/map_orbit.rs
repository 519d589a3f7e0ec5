//! Cycles of a map as a problem.

use super::problem::{Left, Linearised, Problem, Wrap};
use crate::numerics::Matrix;

/// Image of a point and its derivatives by point and parameters, a row for each coordinate.
pub type MapWithSlopes<'m> = dyn Fn(&[f64], &[f64]) -> Result<(Vec<f64>, Matrix<f64>), Left> + 'm;

/// The points of a cycle of a map, one after the other, then the free parameters.
pub struct MapOrbit<'m> {
    map: &'m MapWithSlopes<'m>,
    dimension: usize,
    period: usize,
    parameters: usize,
    scales: Vec<f64>,
}

impl<'m> MapOrbit<'m> {
    /// Of a map of so many coordinates and parameters; `sizes` are those of coordinates, then of parameters.
    pub fn new(map: &'m MapWithSlopes<'m>, period: usize, sizes: (&[f64], &[f64])) -> Self {
        let dimension = sizes.0.len();
        let mut scales = sizes.0.repeat(period);
        scales.extend(sizes.1);
        Self {
            map,
            dimension,
            period,
            parameters: sizes.1.len(),
            scales,
        }
    }

    /// The derivative of the map along the whole cycle.
    ///
    /// # Errors
    /// The map has no image of one of the points.
    pub fn monodromy(&self, at: &[f64]) -> Result<Matrix<f64>, Left> {
        let n = self.dimension;
        let free = &at[n * self.period..];
        let mut product = Matrix::identity(n);
        for point in at[..n * self.period].chunks(n) {
            let (_, slopes) = (self.map)(point, free)?;
            let mut step = Matrix::zeros(n, n);
            for i in 0..n {
                step.row_mut(i).copy_from_slice(&slopes.row(i)[..n]);
            }
            product = step.times(&product);
        }
        Ok(product)
    }
}

impl Problem<f64> for MapOrbit<'_> {
    fn unknowns(&self) -> usize {
        self.dimension * self.period + self.parameters
    }

    fn parameters(&self) -> usize {
        self.parameters
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, Left> {
        let (n, equations) = (self.dimension, self.dimension * self.period);
        let (points, free) = at.split_at(equations);
        let mut residual = vec![0.0; equations];
        let mut jacobian = Matrix::zeros(equations, self.unknowns());
        for (index, point) in points.chunks(n).enumerate() {
            let (image, slopes) = (self.map)(point, free)?;
            let next = (index + 1) % self.period;
            for i in 0..n {
                let row = n * index + i;
                residual[row] = points[n * next + i] - image[i];
                jacobian[(row, n * next + i)] += 1.0;
                for k in 0..n {
                    jacobian[(row, n * index + k)] -= slopes[(i, k)];
                }
                for k in 0..self.parameters {
                    jacobian[(row, equations + k)] -= slopes[(i, n + k)];
                }
            }
        }
        Ok(Linearised { residual, jacobian })
    }

    fn wrap(&self) -> Wrap {
        let (n, last) = (self.dimension, self.dimension * (self.period - 1));
        Wrap {
            entries: (0..n).map(|i| (last + i, i, 1.0)).collect(),
        }
    }
}
