//! Finding borders: close in on each change of the verdict and on each near miss, all of them or the nearest first, and
//! ask whether it is a root of X.

use super::super::coordinate::limits::Extrapolation;
use super::super::coordinate::root::Root;
use super::super::error::{BorderError, Break};
use super::super::problem::Problem;
use super::closing_in::Found;
use super::samples::{Sample, Search};

/// Where the verdict changes from sample to sample, as it may where passages before the sequence are chaotic, no more than
/// so many further sequences are followed, or so many in each part if that is more.
const MOST_SAMPLES: usize = 10_000;
const LEAST_SHARE: usize = 200;

impl Problem {
    /// The changes of the verdict along each branch, and around every smallest distance from the border between samples.
    pub(crate) fn changes<'a>(
        &'a self,
        branches: &[Vec<Sample>],
        extrapolation: Extrapolation,
    ) -> Changes<'a> {
        let search = Search {
            problem: self,
            extrapolation,
            several: branches.len() > 1,
        };
        Changes {
            search,
            pairs: (branches.iter())
                .flat_map(|samples| search.pairs(samples))
                .collect(),
        }
    }
}

/// Neighbouring samples between which the verdict changes.
#[derive(Clone, Debug)]
pub(crate) struct Changes<'a> {
    search: Search<'a>,
    pairs: Vec<[Sample; 2]>,
}

impl Changes<'_> {
    /// Those between two values.
    pub(crate) fn within(mut self, (low, high): (f64, f64)) -> Self {
        (self.pairs).retain(|[left, right]| low <= left.value && right.value <= high);
        self
    }

    /// The neighbouring samples.
    pub(crate) fn pairs(&self) -> &[[Sample; 2]] {
        &self.pairs
    }

    /// The nearest to a parameter value first, and no further than where a root that `accept` takes is nearer than what is
    /// left: its answer, or what was found on the way.
    pub(crate) fn nearest<T>(
        mut self,
        value: f64,
        mut accept: impl FnMut(&Root<f64>, &mut Vec<Break>) -> Result<Option<T>, BorderError>,
    ) -> Result<Result<T, Found>, BorderError> {
        let off = |[left, right]: &[Sample; 2]| (left.value - value).max(value - right.value);
        self.pairs.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let mut found = Found::default();
        let mut nearest: Option<(f64, T)> = None;
        for pair in &self.pairs {
            if nearest
                .as_ref()
                .is_some_and(|(least, _)| *least <= off(pair))
            {
                break;
            }
            self.look_into(pair, &mut found);
            for root in core::mem::take(&mut found.roots) {
                let off = (root.point.value - value).abs();
                if nearest.as_ref().is_some_and(|(least, _)| *least <= off) {
                    continue;
                }
                if let Some(answer) = accept(&root, &mut found.breaks)? {
                    nearest = Some((off, answer));
                }
            }
        }
        found.sort();
        Ok(nearest.map(|(_, answer)| answer).ok_or(found))
    }

    /// Looks into one of them.
    pub(crate) fn look_into(&self, pair: &[Sample; 2], found: &mut Found) {
        // None may leave the others without.
        found.left = (MOST_SAMPLES / self.pairs.len().max(1)).max(LEAST_SHARE);
        self.search.look_into(pair, found);
    }
}
