//! Release points over the parameter: each follows its own branch as far as it exists.

use super::super::error::BorderError;
use super::super::problem::Problem;
use super::equations::ReleasePoint;
use crate::numerics::Real;

/// All release points are looked for at every so manieth value; in between they are followed.
const LOOK_EVERY: usize = 8;

/// A release point at each of the values where it exists.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    pub points: Vec<Option<ReleasePoint<f64>>>,
}

impl Problem {
    /// The branches over parameter values in order, at least one; the error is that of the first value where none can be
    /// looked for.
    pub(crate) fn branches(&self, values: &[f64]) -> Result<Vec<Branch>, BorderError> {
        let mut branches: Vec<Branch> = Vec::new();
        let mut failure = None;
        for (k, &value) in values.iter().enumerate() {
            if k > 0 {
                self.follow_branches(&mut branches, values, k);
            }
            if k % LOOK_EVERY != 0 && k + 1 != values.len() {
                continue;
            }
            let found = self.release_points(value).unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Vec::new()
            });
            for point in found {
                if self.is_known(&branches, k, &self.parameters(value), &point) {
                    continue;
                }
                let mut branch = Branch {
                    points: vec![None; values.len()],
                };
                branch.points[k] = Some(point);
                for earlier in (0..k).rev() {
                    let from = branch.points[earlier + 1].as_ref();
                    let there = values[earlier];
                    let followed =
                        from.and_then(|from| self.followed(from, values[earlier + 1], there));
                    let Some((point, _)) = followed else {
                        break;
                    };
                    if self.is_known(&branches, earlier, &self.parameters(there), &point) {
                        break;
                    }
                    branch.points[earlier] = Some(point);
                }
                branches.push(branch);
            }
        }
        match failure {
            Some(error) if branches.is_empty() => Err(error),
            _ => Ok(branches),
        }
    }

    /// Follows each branch from value `k` - 1 to `k`. Where one ends, Newton's method may come to another: the point
    /// belongs to the branch that expected it nearest.
    fn follow_branches(&self, branches: &mut [Branch], values: &[f64], k: usize) {
        let parameters = self.parameters(values[k]);
        let mut reached: Vec<(usize, ReleasePoint<f64>, f64)> = (branches.iter().enumerate())
            .filter_map(|(i, branch)| {
                let from = branch.points[k - 1].as_ref()?;
                let (point, off) = self.followed(from, values[k - 1], values[k])?;
                Some((i, point, off))
            })
            .collect();
        reached.sort_by(|a, b| a.2.total_cmp(&b.2));
        for (i, point, _) in reached {
            if !self.is_known(branches, k, &parameters, &point) {
                branches[i].points[k] = Some(point);
            }
        }
    }

    /// The release point at another value of the parameter, and how far it is from where the one at `value` was heading.
    fn followed(
        &self,
        from: &ReleasePoint<f64>,
        value: f64,
        there: f64,
    ) -> Option<(ReleasePoint<f64>, f64)> {
        let parameters = self.parameters(there);
        let expected = from.expected(there - value);
        let point = self.returning(there, &expected).ok()?;
        let state: Vec<f64> = expected.state.iter().map(|x| x.to_f64()).collect();
        let off = self.releases[from.contact].apart(&point.state, &state, &parameters);
        Some((point, off))
    }

    fn is_known(
        &self,
        branches: &[Branch],
        k: usize,
        parameters: &[f64],
        point: &ReleasePoint<f64>,
    ) -> bool {
        (branches
            .iter()
            .filter_map(|branch| branch.points[k].as_ref()))
        .any(|known| {
            known.contact == point.contact
                && self.releases[point.contact].is_same(known, point, parameters)
        })
    }
}
