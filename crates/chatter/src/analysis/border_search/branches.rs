//! Samples over the parameter: each release point follows its own branch as far as it exists.

use super::sample::Sample;
use crate::analysis::border::{BorderError, Here, Problem, ReleasePoint};
use crate::numerics::Rounded;

/// All release points are looked for at every so manieth value, in between they are followed: those that orbits have to return to, which
/// may be for a short piece, at each.
const LOOK_EVERY: usize = 8;

/// A sample at each of the values, known where its release point exists.
pub(super) type Branch = Vec<Sample>;

impl Problem {
    /// Extends branches to the next value, number k, and looks there for others now and then: these are followed back as well.
    pub(super) fn extend(
        &self,
        branches: &mut Vec<Branch>,
        (values, k): (&[f64], usize),
    ) -> Result<(), BorderError> {
        let here = self.at(values[k])?;
        // Where a branch ends, Newton's method may come to another: the point belongs to the branch that expected it nearest.
        let followed = |(i, branch): (usize, &Branch)| {
            let before = k.checked_sub(1)?;
            Some((i, here.followed(&branch[before])?))
        };
        let mut reached: Vec<_> = branches.iter().enumerate().filter_map(followed).collect();
        reached.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
        for (i, (point, _)) in reached {
            here.give(branches, (i, k), point);
        }
        let every = if self.dimensions() == 0 {
            LOOK_EVERY
        } else {
            1
        };
        if !k.is_multiple_of(every) && k + 1 != values.len() {
            return Ok(());
        }
        for point in here.release_points()? {
            let new = branches.len();
            branches.push(values.iter().copied().map(Sample::unknown).collect());
            if !here.give(branches, (new, k), point) {
                branches.pop();
                continue;
            }
            for before in (0..k).rev() {
                let is_given = self.at(values[before]).is_ok_and(|there| {
                    let point = there.followed(&branches[new][before + 1]);
                    point.is_some_and(|(point, _)| there.give(branches, (new, before), point))
                });
                if !is_given {
                    break;
                }
            }
        }
        Ok(())
    }
}

impl Here<'_, f64> {
    /// The release point here of a branch that is known at another value, and how far it is from where the branch was heading.
    pub(super) fn followed(&self, from: &Sample) -> Option<(ReleasePoint<f64>, f64)> {
        let release = from.release.as_ref()?;
        let expected = release.moved(&release.slope, self.value - from.value);
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
        let known = branches
            .iter()
            .filter_map(|branch| branch[k].release.as_ref());
        let is_new = self.is_new(&point, known);
        if is_new {
            branches[branch][k] = self.sample(point);
        }
        is_new
    }
}
