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

    /// The product with another; that of conjugate numbers is real.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let conjugate = self.re == other.re && self.im == -other.im;
        Self {
            re: self.re * other.re - self.im * other.im,
            im: if conjugate {
                0.0
            } else {
                self.re * other.im + self.im * other.re
            },
        }
    }
}

/// Steps of the QR iteration for each eigenvalue: a few are usual.
const STEPS: usize = 200;
/// Where they do not end, all diagonal entries may be small against rounding of the largest beside them, by which these are never small enough:
/// eigenvalues are found once more of the matrix with so much of its largest entry added to its diagonal.
const SHIFTS: [f64; 3] = [0.0, 1.0, -1.0];

/// Units d of the coordinates, powers of two, in which rows and columns of a map are of like size, x = D y and D^-1 M D (Parlett
/// and Reinsch): what is small against the largest entry says something only there. Ones if the matrix holds what is not
/// finite, or has no finite square.
pub fn balance(matrix: &mut Matrix<f64>) -> Vec<f64> {
    let size = matrix.rows();
    let square: f64 = (0..size)
        .flat_map(|i| matrix.row(i))
        .map(|entry| entry * entry)
        .sum();
    if !square.is_finite() {
        return vec![1.0; size];
    }
    let mut dense = dense(matrix);
    let units = nalgebra::linalg::balancing::balance_parlett_reinsch(&mut dense);
    for i in 0..size {
        for k in 0..size {
            matrix[(i, k)] = dense[(i, k)];
        }
    }
    units.iter().copied().collect()
}

fn dense(matrix: &Matrix<f64>) -> nalgebra::DMatrix<f64> {
    nalgebra::DMatrix::from_fn(matrix.rows(), matrix.rows(), |i, k| matrix[(i, k)])
}

/// All eigenvalues, the largest first, of a complex pair the one above the real axis first. Empty if the matrix is, or
/// holds what is not finite, or where the iteration does not end. The smallest are known if the matrix is [balanced](balance).
pub fn eigenvalues(matrix: &Matrix<f64>) -> Vec<Complex> {
    let size = matrix.rows();
    if size == 0 || !(0..size).all(|i| matrix.row(i).iter().all(|x| x.is_finite())) {
        return Vec::new();
    }
    let dense = dense(matrix);
    let Some(mut found) = (SHIFTS.into_iter()).find_map(|shift| shifted(dense.clone(), shift))
    else {
        return Vec::new();
    };
    found.sort_by(|a, b| {
        (b.modulus().total_cmp(&a.modulus()))
            .then(b.re.total_cmp(&a.re))
            .then(b.im.total_cmp(&a.im))
    });
    pair_up(&mut found);
    found
}

/// The same, in the order of the decomposition, found with so much of the largest entry added to the diagonal. None where the iteration does not end.
fn shifted(mut matrix: nalgebra::DMatrix<f64>, shift: f64) -> Option<Vec<Complex>> {
    let (size, by) = (matrix.nrows(), shift * matrix.amax());
    (0..size).for_each(|i| matrix[(i, i)] += by);
    let schur = nalgebra::Schur::try_new(matrix, f64::EPSILON, STEPS * size)?;
    let back = |value: &nalgebra::Complex<f64>| Complex {
        re: value.re - by,
        im: value.im,
    };
    Some(schur.complex_eigenvalues().iter().map(back).collect())
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

    #[test]
    fn a_shift_does_not_matter() {
        let entries = [4e3, -7.0, 0.3, 11.0, 2.0, -5.0, 0.01, 6.0, 1.0];
        let matrix = nalgebra::DMatrix::from_row_slice(3, 3, &entries);
        let [plain, up, down] = SHIFTS.map(|shift| {
            let mut all = shifted(matrix.clone(), shift).unwrap();
            all.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
            all
        });
        for other in [up, down] {
            for (a, b) in plain.iter().zip(&other) {
                let off = libm::hypot(a.re - b.re, a.im - b.im);
                assert!(off < 16.0 * f64::EPSILON * 4e3, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn units_do_not_matter() {
        // A rotation by one radian, of nanometres and metres a second.
        let unit = 1e9;
        let mut matrix = Matrix::zeros(2, 2);
        (matrix[(0, 0)], matrix[(1, 1)]) = (libm::cos(1.0), libm::cos(1.0));
        (matrix[(0, 1)], matrix[(1, 0)]) = (libm::sin(1.0) / unit, -libm::sin(1.0) * unit);
        let units = balance(&mut matrix);
        assert!((units[1] / units[0] / unit).log2().abs() < 2.0, "{units:?}");
        for (value, im) in eigenvalues(&matrix).iter().zip([1.0, -1.0]) {
            let off = (value.re - libm::cos(1.0)).abs() + (value.im - im * libm::sin(1.0)).abs();
            assert!(off < 1e-14, "{value:?}");
        }
    }
}
