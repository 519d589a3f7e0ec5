//! Eigenvalues of real matrices.

use super::Matrix;
use serde::{Deserialize, Serialize};

/// A complex number.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// Absolute value.
    pub fn modulus(self) -> f64 {
        libm::hypot(self.re, self.im)
    }
}

/// Steps of the QR iteration for each eigenvalue: a few are usual.
const STEPS: usize = 200;

/// All eigenvalues, the largest first, of a complex pair the one above the real axis first. Empty if the matrix is, or
/// holds what is not finite.
pub fn eigenvalues(matrix: &Matrix<f64>) -> Vec<Complex> {
    let size = matrix.rows();
    if size == 0 || !(0..size).all(|i| matrix.row(i).iter().all(|x| x.is_finite())) {
        return Vec::new();
    }
    let dense = nalgebra::DMatrix::from_fn(size, size, |i, k| matrix[(i, k)]);
    let Some(schur) = nalgebra::Schur::try_new(dense, f64::EPSILON, STEPS * size) else {
        return Vec::new();
    };
    let mut found: Vec<Complex> = (schur.complex_eigenvalues().iter())
        .map(|value| Complex {
            re: value.re,
            im: value.im,
        })
        .collect();
    found.sort_by(|a, b| {
        (b.modulus().total_cmp(&a.modulus()))
            .then(b.re.total_cmp(&a.re))
            .then(b.im.total_cmp(&a.im))
    });
    pair_up(&mut found);
    found
}

/// Rounding may tear the two of a pair apart in the order.
fn pair_up(values: &mut [Complex]) {
    let mut i = 0;
    while i < values.len() {
        if values[i].im == 0.0 {
            i += 1;
            continue;
        }
        let mate = (i + 1..values.len()).min_by(|&a, &b| {
            let apart =
                |k: usize| libm::hypot(values[k].re - values[i].re, values[k].im + values[i].im);
            apart(a).total_cmp(&apart(b))
        });
        if let Some(mate) = mate {
            values[i + 1..=mate].rotate_right(1);
            if values[i].im < 0.0 {
                values.swap(i, i + 1);
            }
        }
        i += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_a_characteristic_polynomial() {
        // Companion matrix of (x - 3) (x^2 - 2 x + 5).
        let mut matrix = Matrix::zeros(3, 3);
        for (k, &entry) in [5.0, -11.0, 15.0].iter().enumerate() {
            matrix[(0, k)] = entry;
        }
        matrix[(1, 0)] = 1.0;
        matrix[(2, 1)] = 1.0;
        let found = eigenvalues(&matrix);
        let expected = [(3.0, 0.0), (1.0, 2.0), (1.0, -2.0)];
        for (value, (re, im)) in found.iter().zip(expected) {
            assert!(
                (value.re - re).abs() + (value.im - im).abs() < 1e-13,
                "{found:?}"
            );
        }
        matrix[(0, 0)] = f64::NAN;
        assert_eq!(eigenvalues(&matrix), []);
    }
}
