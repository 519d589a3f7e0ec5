//! Release points over the parameter: each follows its own branch as far as it exists.

use super::super::error::BorderError;
use super::super::problem::{Here, Problem};
use super::equations::ReleasePoint;
use crate::numerics::Rounded;

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
        for (k, &value) in values.iter().enumerate() {
            let found = self.at(value).and_then(|here| {
                // Where a branch ends, Newton's method may come to another: the point belongs to the branch that expected it nearest.
                let followed = |(i, branch): (usize, &Branch)| {
                    let before = k.checked_sub(1)?;
                    Some((i, here.followed(values[before], branch[before].as_ref()?)?))
                };
                let mut reached: Vec<_> =
                    branches.iter().enumerate().filter_map(followed).collect();
                reached.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
                for (i, (point, _)) in reached {
                    here.give(&mut branches, (i, k), point);
                }
                match k % LOOK_EVERY == 0 || k + 1 == values.len() {
                    true => here.release_points(),
                    false => Ok(Vec::new()),
                }
            });
            let found = found.unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Vec::new()
            });
            for point in found {
                let new = branches.len();
                branches.push(vec![None; values.len()]);
                let mut latest = Some((k, point));
                while let Some((k, point)) = latest {
                    let here = self.at(values[k]).ok();
                    let is_given =
                        here.is_some_and(|here| here.give(&mut branches, (new, k), point.clone()));
                    let before = k.checked_sub(1).filter(|_| is_given);
                    latest = before.and_then(|before| {
                        let there = self.at(values[before]).ok()?;
                        Some((before, there.followed(values[k], &point)?.0))
                    });
                }
                if branches[new][k].is_none() {
                    branches.pop();
                }
            }
        }
        match failure {
            Some(error) if branches.is_empty() => Err(error),
            _ => Ok(branches),
        }
    }
}

impl Here<'_, f64> {
    /// The release point here of a branch that is known at another value, and how far it is from where the branch was heading.
    pub(crate) fn followed(
        &self,
        value: f64,
        from: &ReleasePoint<f64>,
    ) -> Option<(ReleasePoint<f64>, f64)> {
        let expected = from.moved(&from.slope, self.value - value);
        let point = self.returning(&expected).ok()?;
        let (_, off) = self.apart(&point.state, &expected.state.rounded());
        Some((point, off))
    }

    /// Gives a branch a point at one of the values, unless another branch has it.
    fn give(
        &self,
        branches: &mut [Branch],
        (branch, k): (usize, usize),
        point: ReleasePoint<f64>,
    ) -> bool {
        let known = branches.iter().filter_map(|branch| branch[k].as_ref());
        let is_new = self.is_new(&point, known);
        if is_new {
            branches[branch][k] = Some(point);
        }
        is_new
    }
}
