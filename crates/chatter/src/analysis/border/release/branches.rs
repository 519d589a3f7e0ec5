//! Release points over the parameter: each follows its own branch as far as it exists.

use super::super::error::BorderError;
use super::super::problem::Problem;
use super::equations::ReleasePoint;
use crate::numerics::Real;

/// All release points are looked for at every so manieth value; in between they are followed.
const LOOK_EVERY: usize = 8;

/// A release point at each of the values where it exists.
pub(crate) type Branch = Vec<Option<ReleasePoint<f64>>>;

impl Problem {
    /// The branches over parameter values in order, at least one; the error is that of the first value where none can be
    /// looked for.
    pub(crate) fn branches(&self, values: &[f64]) -> Result<Vec<Branch>, BorderError> {
        let mut branches: Vec<Branch> = Vec::new();
        let mut failure = None;
        for k in 0..values.len() {
            // Where a branch ends, Newton's method may come to another: the point belongs to the branch that expected it nearest.
            let mut reached: Vec<_> = (branches.iter().enumerate())
                .filter_map(|(i, branch)| {
                    Some((i, self.followed(branch, values, (k.checked_sub(1)?, k))?))
                })
                .collect();
            reached.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
            for (i, (point, _)) in reached {
                self.give(&mut branches, i, (k, values[k]), point);
            }
            if k % LOOK_EVERY != 0 && k + 1 != values.len() {
                continue;
            }
            let found = self.release_points(values[k]).unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Vec::new()
            });
            for point in found {
                let new = branches.len();
                branches.push(vec![None; values.len()]);
                if !self.give(&mut branches, new, (k, values[k]), point) {
                    branches.pop();
                    continue;
                }
                for earlier in (0..k).rev() {
                    let followed = self.followed(&branches[new], values, (earlier + 1, earlier));
                    let at = (earlier, values[earlier]);
                    if !followed.is_some_and(|(point, _)| self.give(&mut branches, new, at, point))
                    {
                        break;
                    }
                }
            }
        }
        match failure {
            Some(error) if branches.is_empty() => Err(error),
            _ => Ok(branches),
        }
    }

    /// A branch's release point at another of the values, and how far it is from where the branch was heading.
    fn followed(
        &self,
        branch: &Branch,
        values: &[f64],
        (here, there): (usize, usize),
    ) -> Option<(ReleasePoint<f64>, f64)> {
        let from = branch[here].as_ref()?;
        let parameters = self.parameters(values[there]);
        let expected = from.expected(values[there] - values[here]);
        let point = self.returning(values[there], &expected).ok()?;
        let state: Vec<f64> = expected.state.iter().map(|x| x.to_f64()).collect();
        let (_, off) = self.releases[from.contact].apart(&point.state, &state, &parameters);
        Some((point, off))
    }

    /// Gives a branch a point at one of the values, unless another branch has it.
    fn give(
        &self,
        branches: &mut [Branch],
        branch: usize,
        (k, value): (usize, f64),
        point: ReleasePoint<f64>,
    ) -> bool {
        let parameters = self.parameters(value);
        let is_new = (branches.iter().filter_map(|branch| branch[k].as_ref())).all(|known| {
            known.contact != point.contact
                || !self.releases[point.contact].is_same(known, &point, &parameters)
        });
        if is_new {
            branches[branch][k] = Some(point);
        }
        is_new
    }
}
