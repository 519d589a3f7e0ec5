//! Linear complementarity: 0 <= p, w = q + M p >= 0, p . w = 0.
//!
//! Contact forces and impacts of several contacts obey it: each either pushes or lets go. Principal pivoting by the least
//! index (Murty) finds the solution of every matrix whose principal minors are positive, as mechanics makes them, in
//! finitely many exchanges. Where contacts depend on each other some are zero; then Lemke's path, followed by the lexicographic
//! rule, finds one of the solutions: forces differ between them, w does not.

use super::Real;
use super::linear::{independent, solve};

/// A solution: p, and w = q + M p.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Complementary<R> {
    pub p: Vec<R>,
    pub w: Vec<R>,
}

/// Exchanges allowed for each unknown: mechanics rarely needs two, and a matrix without solution none that help.
const EXCHANGES: usize = 64;

/// Solves the problem; entries of p and w count as zero within `levels`. None where no solution is found: the matrix has
/// a principal minor that is negative.
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
        if independent(&block).len() < active.len() {
            return lemke(matrix, q, levels);
        }
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

/// Entries of a tableau no larger than this many roundoffs of its largest are rounding.
const PIVOT_ROUNDOFFS: f64 = 4096.0;

/// Lemke's method: w = q + M p + z with one z for all rows, from a z that is large enough along a path to z = 0. Ties are broken by
/// the columns of w (the lexicographic rule), so that it ends.
fn lemke<R: Real>(matrix: &[Vec<R>], q: &[R], levels: &[R]) -> Option<Complementary<R>> {
    let size = q.len();
    let tiny = R::splat(PIVOT_ROUNDOFFS * R::ROUNDOFF);
    let q: Vec<R> = (q.iter().zip(levels))
        .map(|(&q, &level)| if q.abs() <= level { R::ZERO } else { q })
        .collect();
    // Columns: w, p, z, right side. Variables are numbered alike.
    let z = 2 * size;
    let mut rows: Vec<Vec<R>> = (0..size)
        .map(|i| {
            let unit = (0..size).map(|j| if i == j { R::ONE } else { R::ZERO });
            let pushes = matrix[i].iter().map(|&entry| -entry);
            unit.chain(pushes).chain([-R::ONE, q[i]]).collect()
        })
        .collect();
    let mut basis: Vec<usize> = (0..size).collect();
    let lexical = |rows: &[Vec<R>], a: usize, b: usize, column: usize| {
        for k in core::iter::once(z + 1).chain(0..size) {
            let (x, y) = (rows[a][k] / rows[a][column], rows[b][k] / rows[b][column]);
            if (x - y).abs() > tiny * x.abs().max(y.abs()) {
                return x < y;
            }
        }
        a < b
    };
    let pivot = |rows: &mut Vec<Vec<R>>, row: usize, column: usize| {
        let lead = rows[row][column];
        for entry in &mut rows[row] {
            *entry = *entry / lead;
        }
        let own = rows[row].clone();
        for (other, entries) in rows.iter_mut().enumerate() {
            let factor = entries[column];
            if other != row && factor != R::ZERO {
                for (entry, &by) in entries.iter_mut().zip(&own) {
                    *entry -= factor * by;
                }
            }
        }
    };
    // The first row to leave: the one that needs the largest z.
    let first = (0..size).reduce(|a, b| if lexical(&rows, a, b, z) { b } else { a })?;
    if q[first] < R::ZERO {
        let mut leaving = basis[first];
        pivot(&mut rows, first, z);
        basis[first] = z;
        for turn in 0.. {
            // What is left of z after large forces have cancelled is rounding: the path is at its end.
            let right = |row: usize| rows[row][z + 1].abs();
            let largest = (0..size).fold(R::ZERO, |most, row| most.max(right(row)));
            if (0..size).any(|row| basis[row] == z && right(row) <= tiny * largest) {
                break;
            }
            let entering = if leaving < size {
                leaving + size
            } else {
                leaving - size
            };
            let scale = rows
                .iter()
                .fold(R::ONE, |most, row| most.max(row[entering].abs()));
            let candidates = (0..size).filter(|&row| rows[row][entering] > tiny * scale);
            // Where z may leave as well as others, it does.
            let row = candidates.reduce(|a, b| {
                let ratio = |row: usize| rows[row][z + 1] / rows[row][entering];
                let tie = (ratio(a) - ratio(b)).abs() <= tiny * ratio(a).abs().max(ratio(b).abs());
                match (basis[a] == z, basis[b] == z) {
                    (true, _) if tie => a,
                    (_, true) if tie => b,
                    _ if lexical(&rows, a, b, entering) => a,
                    _ => b,
                }
            })?;
            leaving = basis[row];
            pivot(&mut rows, row, entering);
            basis[row] = entering;
            if leaving == z {
                break;
            }
            if turn > EXCHANGES * (size + 1) {
                return None;
            }
        }
    }
    let mut p = vec![R::ZERO; size];
    for (row, &variable) in basis.iter().enumerate() {
        if (size..z).contains(&variable) {
            p[variable - size] = rows[row][z + 1];
        }
    }
    let w: Vec<R> = (0..size)
        .map(|i| {
            let pushed = (0..size).fold(q[i], |sum, j| matrix[i][j].mul_add(p[j], sum));
            if basis.contains(&i) { pushed } else { R::ZERO }
        })
        .collect();
    let is_finite = p.iter().chain(&w).all(|value| value.is_finite());
    is_finite.then_some(Complementary { p, w })
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

    /// Two of them nearly opposite, so that their forces are a thousand times what they balance; all come to rest.
    #[test]
    fn nearly_opposite_contacts_hold_what_lies_between_them() {
        let rows = [
            (0.0, -0.75997),
            (0.0, -0.55796),
            (0.91057, -0.50596),
            (-0.88798, 0.49567),
        ];
        let dot = |a: (f64, f64), b: (f64, f64)| a.0 * b.0 + a.1 * b.1;
        for order in [[0, 1, 2, 3], [3, 2, 1, 0], [1, 0, 3, 2], [2, 3, 0, 1]] {
            let matrix: Vec<Vec<f64>> = (order.iter())
                .map(|&i| {
                    order
                        .map(|j| dot(rows[i], rows[j]) / dot(rows[j], rows[j]))
                        .to_vec()
                })
                .collect();
            let q = order.map(|i| dot(rows[i], (0.0, -0.32199)));
            let found = complementary(&matrix, &q, &[1e-12; 4]).expect("a solution");
            assert!(found.w.iter().all(|w| w.abs() < 1e-10), "{found:?}");
            assert!(found.p.iter().all(|&p| p >= 0.0), "{found:?}");
        }
    }

    proptest! {
        /// More contacts than coordinates: A D A^T of low rank. Forces are not unique; what moves is.
        #[test]
        fn dependent_contacts_have_solutions_and_one_motion(
            entries in proptest::collection::vec(-1.0_f64..1.0, 18),
            free in proptest::collection::vec(-1.0_f64..1.0, 3),
            size in 2_usize..=6,
            rank in 1_usize..=2,
        ) {
            let row = |i: usize| &entries[3 * i..3 * i + rank];
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            // Neither rows of rounding errors nor contacts that are opposite but for a hundredth of a degree: such forces are
            // known to fewer digits than are asked for here.
            let square = |i: usize, j: usize| dot(row(i), row(j)) * dot(row(i), row(j));
            prop_assume!((0..size).all(|i| dot(row(i), row(i)) > 1e-4));
            prop_assume!(rank == 1 || (0..size).all(|i| (0..i).all(|j| {
                square(i, j) < (1.0 - 3e-8) * dot(row(i), row(i)) * dot(row(j), row(j))
            })));
            let matrix: Vec<Vec<f64>> = (0..size)
                .map(|i| (0..size).map(|j| dot(row(i), row(j)) / dot(row(j), row(j))).collect())
                .collect();
            let q: Vec<f64> = (0..size).map(|i| dot(row(i), &free[..rank])).collect();
            let found = complementary(&matrix, &q, &vec![1e-12; size]).expect("a solution");
            let backwards: Vec<usize> = (0..size).rev().collect();
            let turned: Vec<Vec<f64>> = (backwards.iter())
                .map(|&i| backwards.iter().map(|&j| matrix[i][j]).collect())
                .collect();
            let q_turned: Vec<f64> = backwards.iter().map(|&i| q[i]).collect();
            let other = complementary(&turned, &q_turned, &vec![1e-12; size]).expect("a solution");
            let size_of_p = found.p.iter().fold(1.0_f64, |most, p| most.max(p.abs()));
            for i in 0..size {
                let w: f64 = q[i] + (0..size).map(|j| matrix[i][j] * found.p[j]).sum::<f64>();
                prop_assert!((w - found.w[i]).abs() < 1e-10 * size_of_p, "{w} {}", found.w[i]);
                prop_assert!(found.p[i] >= -1e-12 && found.w[i] >= -1e-10 * size_of_p);
                prop_assert!((found.p[i] * found.w[i]).abs() < 1e-9 * size_of_p);
                prop_assert!((found.w[i] - other.w[size - 1 - i]).abs() < 1e-9 * size_of_p);
            }
        }

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
