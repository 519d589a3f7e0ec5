//! Small dense linear systems.

use super::Real;

/// Solves A x = b by elimination with row exchanges; `None` where A is singular or not finite.
///
/// `rows` holds A, row after row; the sizes of `rows` and `right` must agree.
pub fn solve<R: Real>(rows: &[Vec<R>], right: &[R]) -> Option<Vec<R>> {
    let size = right.len();
    let mut work: Vec<Vec<R>> = rows
        .iter()
        .zip(right)
        .map(|(row, &b)| row.iter().copied().chain([b]).collect())
        .collect();
    for column in 0..size {
        let pivot = (column..size).max_by(|&a, &b| {
            let (a, b) = (work[a][column].abs(), work[b][column].abs());
            a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
        })?;
        work.swap(column, pivot);
        let leading = work[column][column];
        if leading == R::ZERO || !leading.is_finite() {
            return None;
        }
        let (above, below) = work.split_at_mut(column + 1);
        for row in below {
            let factor = row[column] / above[column][column];
            for (entry, &over) in row.iter_mut().zip(&above[column]).skip(column) {
                *entry -= factor * over;
            }
        }
    }
    let mut solution = vec![R::ZERO; size];
    for i in (0..size).rev() {
        let known = (i + 1..size).fold(work[i][size], |rest, k| rest - work[i][k] * solution[k]);
        solution[i] = known / work[i][i];
    }
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_their_system() {
        let rows = vec![
            vec![0.0, 2.0, 1.0],
            vec![4.0, -1.0, 0.5],
            vec![1.0, 1.0, 1.0],
        ];
        let x = solve(&rows, &[1.0, 2.0, 3.0]).unwrap();
        for (row, b) in rows.iter().zip([1.0, 2.0, 3.0]) {
            let sum: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((sum - b).abs() < 1e-14);
        }
        assert_eq!(solve(&[vec![1.0, 2.0], vec![2.0, 4.0]], &[1.0, 1.0]), None);
    }
}
