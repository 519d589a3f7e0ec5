//! The tangent map of a map in closed form.

use super::{Map, NoReturn, Passage};

/// A map whose derivative is known at each point.
pub trait Differentiable: Map {
    /// The derivative of the next point with respect to the point, row by row.
    fn jacobian(&self, parameters: &[f64], point: &[f64]) -> Vec<f64>;
}

/// Names of the coordinates of a tangent map's points, from those of the map.
pub(crate) fn displaced_names(mut names: Vec<String>) -> Vec<String> {
    let displaced: Vec<String> = names.iter().map(|name| format!("d{name}")).collect();
    names.extend(displaced);
    names
}

/// Where a tangent map's orbit starts unless told otherwise: at the map's point, displaced by one in every direction.
pub(crate) fn displaced_point(mut point: Vec<f64>) -> Vec<f64> {
    point.resize(2 * point.len(), 1.0);
    point
}

/// The tangent map of a map: (x, y) -> (f(x), f'(x) y).
#[derive(Clone, Copy, Debug)]
pub struct Tangent<'m, M>(pub &'m M);

impl<M: Differentiable> Map for Tangent<'_, M> {
    fn coordinates(&self) -> Vec<String> {
        displaced_names(self.0.coordinates())
    }

    fn parameters(&self) -> Vec<String> {
        self.0.parameters()
    }

    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        self.0.parameter_values(swept)
    }

    fn initial_point(&self, parameters: &[f64]) -> Vec<f64> {
        displaced_point(self.0.initial_point(parameters))
    }

    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        let n = point.len() / 2;
        let (point, displacement) = point.split_at_mut(n);
        let jacobian = self.0.jacobian(parameters, point);
        let image: Vec<f64> = (jacobian.chunks(n))
            .map(|row| row.iter().zip(&*displacement).map(|(a, b)| a * b).sum())
            .collect();
        displacement.copy_from_slice(&image);
        self.0.next(parameters, point)
    }
}
