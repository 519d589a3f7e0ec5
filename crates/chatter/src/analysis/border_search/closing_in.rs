//! From samples of different verdict to the root of X between them, or to what else ends chatter there.

use super::borders::Search;
use super::breaks::break_between;
use super::sample::Sample;
use crate::analysis::border::{BorderError, Root};
use crate::numerics::Real;

/// A bracket is halved so often at most: to rounding, whatever its ends.
const HALVINGS: usize = 80;

/// A smallest distance from u* between samples is looked for in so many steps of the golden section, which leave a
/// millionth of the bracket: X is quadratic there.
const SECTIONS: usize = 29;
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Where chatter is complete at neither end, only this often: a piece with complete chatter in between would be narrower
/// than a thousandth.
pub(super) const HALVINGS_WITHOUT: usize = 10;

impl<'a, R: Real> Search<'a, R> {
    /// Neighbouring samples of different verdict, those around every smallest distance from the border included.
    pub(super) fn pairs(&self, samples: &[Sample]) -> Vec<[Sample; 2]> {
        let mut all = samples.to_vec();
        for around in samples.windows(3) {
            let [left, middle, right] = around else {
                continue;
            };
            if [left.verdict, right.verdict] == [middle.verdict; 2]
                && middle.distance < left.distance
                && middle.distance <= right.distance
            {
                all.extend(self.nearest_miss(left, middle, right));
            }
        }
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        (all.windows(2))
            .filter(|pair| pair[0].verdict != pair[1].verdict)
            .map(|pair| [pair[0].clone(), pair[1].clone()])
            .collect()
    }

    /// Between three samples of one verdict the middle of which is the nearest to the border: a sample of another verdict,
    /// by golden section on the distance; `None` if there is none, or the sequence jumps.
    fn nearest_miss(&self, left: &Sample, middle: &Sample, right: &Sample) -> Option<Sample> {
        let (mut low, mut high) = (left.value, right.value);
        let mut best = middle.clone();
        for _ in 0..SECTIONS {
            let (below, above) = (best.value - low, high - best.value);
            let value = if below > above {
                best.value - GOLDEN * below
            } else {
                best.value + GOLDEN * above
            };
            let mut other = self.problem.sample_near(value, &[&best]);
            other.sequence()?;
            if other.verdict != middle.verdict {
                return Some(other);
            }
            if other.distance < best.distance {
                core::mem::swap(&mut other, &mut best);
            }
            if other.value < best.value {
                low = other.value;
            } else {
                high = other.value;
            }
        }
        None
    }

    /// Halves a bracket until Newton's method finds a root in it, or nothing is left to halve: where it is no end of complete
    /// chatter so often. A third verdict in between makes two brackets of it.
    pub(super) fn close_in(
        &mut self,
        left: &Sample,
        right: &Sample,
        without: usize,
    ) -> Result<(), BorderError> {
        let (mut left, mut right) = (left.clone(), right.clone());
        let halvings = if left.ends_chatter_of(&right) {
            HALVINGS
        } else {
            without
        };
        for left_over in (0..halvings).rev() {
            let width = right.value - left.value;
            let within = (left.value - width, right.value + width);
            let root = (self.root_from(&left, within)).or_else(|| self.root_from(&right, within));
            // One beyond the bracket is another one than makes the verdict change here.
            if let Some(root) = root
                && self.take(&root, (left.value, right.value))?
            {
                return Ok(());
            }
            let middle = left.value + width * 0.5;
            if middle <= left.value || middle >= right.value {
                break;
            }
            if self.left == 0 {
                self.found.unresolved += 1;
                return Ok(());
            }
            self.left -= 1;
            let sample = self.problem.sample_near(middle, &[&left, &right]);
            if sample.verdict == left.verdict {
                left = sample;
            } else if sample.verdict == right.verdict {
                right = sample;
            } else {
                self.close_in(&left, &sample, left_over)?;
                return self.close_in(&sample, &right, left_over);
            }
        }
        if left.ends_chatter_of(&right) {
            self.found.breaks.push(break_between(&left, &right));
        }
        Ok(())
    }

    /// A root reached from a sample whose sequence comes near u*; `None` if there is none.
    fn root_from(&self, sample: &Sample, within: (f64, f64)) -> Option<Root<'a, f64>> {
        let release = sample.release.as_ref().filter(|_| sample.is_near)?;
        (self.problem).root(sample.value, &release.place(), sample.settles, within)
    }
}
