//! Linear complementarity: 0 <= p, w = q + M p >= 0, p . w = 0.
//!
//! Contact forces and impacts of several contacts obey it: each either pushes or lets go. Principal pivoting by the least
//! index (Murty) finds the solution of every matrix whose principal minors are positive, as mechanics makes them, in
//! finitely many exchanges.

use super::Real;
use super::linear::solve;

/// A solution: p, and w = q + M p.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Complementary<R> {
    pub p: Vec<R>,
    pub w: Vec<R>,
}

/// Exchanges allowed for each unknown: mechanics rarely needs two, and a matrix without solution none that help.
const EXCHANGES: usize = 64;

/// Solves the problem; entries of p and w count as zero within `levels`. None where no solution is found: the matrix has
/// a principal minor that is not positive.
pub(crate) fn complementary<R: Real>(
    matrix: &[Vec<R>],
    q: &[R],
    levels: &[R],
) -> Option<Complementary<R>> {
    let size = q.len();
    let mut pushing = vec![false; size];
    for _ in 0..=EXCHANGES * (size + 1) {
        let active: Vec<usize> = (0..size).filter(|&i| pushing[i]).collect();
        let block: Vec<Vec<R>> = (active.iter())
            .map(|&i| active.iter().map(|&j| matrix[i][j]).collect())
            .collect();
        let right: Vec<R> = active.iter().map(|&i| -q[i]).collect();
        let mut p = vec![R::ZERO; size];
        for (&i, value) in active.iter().zip(solve(&block, &right)?) {
            p[i] = value;
        }
        let w: Vec<R> = (0..size)
            .map(|i| {
                let pushed = (active.iter()).fold(q[i], |sum, &j| matrix[i][j].mul_add(p[j], sum));
                if pushing[i] { R::ZERO } else { pushed }
            })
            .collect();
        let wrong = (0..size).find(|&i| p[i] < -levels[i] || w[i] < -levels[i]);
        match wrong {
            None => return Some(Complementary { p, w }),
            Some(i) => pushing[i] = !pushing[i],
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_pushes_does_not_move_and_what_moves_is_not_pushed() {
        let matrix = vec![vec![2.0, -1.0], vec![-1.0, 2.0]];
        let found = complementary(&matrix, &[-1.0, 3.0], &[0.0; 2]).unwrap();
        assert_eq!(found.p, [0.5, 0.0]);
        assert_eq!(found.w, [0.0, 2.5]);
        let none = complementary(&[vec![-1.0]], &[-1.0], &[0.0]);
        assert_eq!(none, None);
    }

    proptest! {
        #[test]
        fn solutions_satisfy_the_conditions(
            entries in proptest::collection::vec(-1.0_f64..1.0, 36),
            q in proptest::collection::vec(-1.0_f64..1.0, 6),
            size in 1_usize..=6,
        ) {
            // A A^T + small: positive definite.
            let matrix: Vec<Vec<f64>> = (0..size).map(|i| (0..size).map(|j| {
                let dot: f64 = (0..size).map(|k| entries[6 * i + k] * entries[6 * j + k]).sum();
                dot + if i == j { 1e-2 } else { 0.0 }
            }).collect()).collect();
            let q = &q[..size];
            let found = complementary(&matrix, q, &vec![1e-12; size]).expect("a solution");
            for i in 0..size {
                let w: f64 = q[i] + (0..size).map(|j| matrix[i][j] * found.p[j]).sum::<f64>();
                prop_assert!((w - found.w[i]).abs() < 1e-9, "{w} {}", found.w[i]);
                prop_assert!(found.p[i] >= -1e-12 && found.w[i] >= -1e-12);
                prop_assert!((found.p[i] * found.w[i]).abs() < 1e-9);
            }
        }
    }
}
