//! Cycles of a map as a problem.

use super::problem::{Left, Linearised, Problem, Wrap};
use crate::numerics::{Matrix, Real};

/// A map that tells its derivatives too.
pub type MapWithSlopes<'m, R = f64> = dyn Fn(&[R], &[R]) -> ImageWithSlopes<R> + 'm;

/// Image of a point and its derivatives by point and parameters, a row for each coordinate.
pub type ImageWithSlopes<R = f64> = Result<(Vec<R>, Matrix<R>), Left>;

/// The points of a cycle of a map, one after the other, then the free parameters.
pub struct MapOrbit<'m, R = f64> {
    map: &'m MapWithSlopes<'m, R>,
    dimension: usize,
    period: usize,
    parameters: usize,
    scales: Vec<f64>,
}

impl<'m, R: Real> MapOrbit<'m, R> {
    /// Of a map of so many coordinates and parameters; `sizes` are those of coordinates, then of parameters.
    pub fn new(map: &'m MapWithSlopes<'m, R>, period: usize, sizes: (&[f64], &[f64])) -> Self {
        Self::with_sizes(map, sizes.0.len(), sizes.0.repeat(period), sizes.1)
    }

    /// Of a map of so many coordinates, with a size for each coordinate of each point.
    pub fn with_sizes(
        map: &'m MapWithSlopes<'m, R>,
        dimension: usize,
        mut scales: Vec<f64>,
        parameters: &[f64],
    ) -> Self {
        let period = scales.len() / dimension;
        scales.extend(parameters);
        Self {
            map,
            dimension,
            period,
            parameters: parameters.len(),
            scales,
        }
    }

    /// The derivative of the map along the whole cycle.
    ///
    /// # Errors
    /// The map has no image of one of the points.
    pub fn monodromy(&self, at: &[R]) -> Result<Matrix<R>, Left> {
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

impl<R: Real> Problem<R> for MapOrbit<'_, R> {
    fn unknowns(&self) -> usize {
        self.dimension * self.period + self.parameters
    }

    fn parameters(&self) -> usize {
        self.parameters
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, Left> {
        let (n, equations) = (self.dimension, self.dimension * self.period);
        let (points, free) = at.split_at(equations);
        let mut residual = vec![R::ZERO; equations];
        let mut jacobian = Matrix::zeros(equations, self.unknowns());
        for (index, point) in points.chunks(n).enumerate() {
            let (image, slopes) = (self.map)(point, free)?;
            let next = (index + 1) % self.period;
            for i in 0..n {
                let row = n * index + i;
                residual[row] = points[n * next + i] - image[i];
                jacobian[(row, n * next + i)] += R::ONE;
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
