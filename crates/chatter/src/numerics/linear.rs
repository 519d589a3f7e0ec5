//! Small dense linear systems.

use super::{Matrix, Real};

/// Solves A x = b by elimination with row exchanges; `None` where A is singular or not finite.
///
/// `rows` holds A, row after row; the sizes of `rows` and `right` must agree.
pub fn solve<R: Real>(rows: &[Vec<R>], right: &[R]) -> Option<Vec<R>> {
    let solution = Matrix::from_rows(rows).factored()?.solve(right);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// Rows whose entries are no more than this many roundoffs of what they were, once those before are taken from them, depend on
/// those.
const DEPENDENT_ROUNDOFFS: f64 = 4096.0;

/// Rows and columns of a square matrix that are independent, as many as possible, ascending: by elimination with the largest
/// pivots of the diagonal, as the matrices of mechanics have them. All of them where what is left has none on its diagonal.
pub fn independent<R: Real>(rows: &[Vec<R>]) -> Vec<usize> {
    let size = rows.len();
    let mut work = rows.to_vec();
    let mut left: Vec<usize> = (0..size).collect();
    let largest =
        |work: &[Vec<R>], row: usize| work[row].iter().fold(R::ZERO, |most, x| most.max(x.abs()));
    let scales: Vec<R> = (0..size).map(|row| largest(rows, row)).collect();
    let tiny = R::splat(DEPENDENT_ROUNDOFFS * R::ROUNDOFF);
    while !left.is_empty() {
        let share = |i: usize| work[i][i].abs() / scales[i].max(R::splat(f64::MIN_POSITIVE));
        let Some(place) = (0..left.len()).max_by(|&a, &b| {
            let order = share(left[a]).partial_cmp(&share(left[b]));
            // Of equals the first.
            order.unwrap_or(core::cmp::Ordering::Equal).then(b.cmp(&a))
        }) else {
            break;
        };
        let pivot = left[place];
        if share(pivot) <= tiny {
            let is_dependent =
                |&i: &usize| left.iter().all(|&j| work[i][j].abs() <= tiny * scales[i]);
            if left.iter().all(is_dependent) {
                return (0..size).filter(|row| !left.contains(row)).collect();
            }
            break;
        }
        left.remove(place);
        let above = work[pivot].clone();
        for &row in &left {
            let factor = work[row][pivot] / above[pivot];
            for &column in &left {
                work[row][column] -= factor * above[column];
            }
        }
    }
    (0..size).collect()
}

/// Solves A x = b where rows that depend on others agree with them: their unknowns are zero. None where A is singular in another
/// way, or not finite.
pub fn solve_consistent<R: Real>(rows: &[Vec<R>], right: &[R]) -> Option<Vec<R>> {
    let chosen = independent(rows);
    if chosen.len() == right.len() {
        return solve(rows, right);
    }
    let block: Vec<Vec<R>> = (chosen.iter())
        .map(|&i| chosen.iter().map(|&j| rows[i][j]).collect())
        .collect();
    let own: Vec<R> = chosen.iter().map(|&i| right[i]).collect();
    let mut solution = vec![R::ZERO; right.len()];
    for (&i, value) in chosen.iter().zip(solve(&block, &own)?) {
        solution[i] = value;
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_rows_are_left_out() {
        let beam = |arms: &[f64]| -> Vec<Vec<f64>> {
            let coupling = |a: f64, b: f64| (1.0 + 3.0 * a * b) / (1.0 + 3.0 * b * b);
            let row = |&a: &f64| arms.iter().map(|&b| coupling(a, b)).collect();
            arms.iter().map(row).collect()
        };
        assert_eq!(independent(&beam(&[-1.0, 0.1, 1.0])).len(), 2);
        assert_eq!(independent(&beam(&[-1.0, 1.0])), [0, 1]);
        assert_eq!(independent(&[vec![1.0, 1.0], vec![1.0, 1.0]]), [0]);
        assert_eq!(independent(&[vec![0.0, 1.0], vec![1.0, 0.0]]), [0, 1]);
        let x = solve_consistent(&beam(&[-0.7, 0.3, 1.1]), &[1.7, 0.7, -0.1]).unwrap();
        for (row, b) in beam(&[-0.7, 0.3, 1.1]).iter().zip([1.7, 0.7, -0.1]) {
            let sum: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((sum - b).abs() < 1e-13, "{x:?}");
        }
    }

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
