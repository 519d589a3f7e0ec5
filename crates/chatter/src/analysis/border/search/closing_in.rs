//! From samples of different verdict to the root of X between them, or to what else ends chatter there.

use super::super::coordinate::limits::Limits;
use super::super::coordinate::root::Root;
use super::super::coordinate::sequence::Verdict;
use super::super::error::Break;
use super::super::problem::Problem;
use super::breaks::break_between;
use super::samples::{Sample, Search};

/// Newton's method starts once the sequence comes this near to u*, relative to u*.
const NEAR: f64 = 0.1;

/// A bracket is halved so often at most: to rounding, whatever its ends.
const HALVINGS: usize = 80;

/// A smallest distance from u* between samples is looked for in so many steps of the golden section, which leave a
/// millionth of the bracket: X is quadratic there.
const SECTIONS: usize = 29;

/// Where chatter is complete at neither end, only this often: a piece with complete chatter in between would be narrower
/// than a thousandth.
const HALVINGS_WITHOUT: usize = 10;

/// Breaks this near to each other, relative to the parameter, are told as one.
const SAME_BREAK: f64 = 1e-6;

/// Borders and other changes of the verdict, both in the order of the parameter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    pub roots: Vec<Root<f64>>,
    pub breaks: Vec<Break>,
    /// Changes of the verdict that were not looked into.
    pub unresolved: usize,
    /// Sequences that may still be followed.
    pub left: usize,
}

impl Found {
    /// In order, each root and each break once.
    pub(crate) fn sort(&mut self) {
        (self.roots).sort_by(|a, b| a.point.value.total_cmp(&b.point.value));
        self.roots.dedup_by(|a, b| a.is_same(b));
        self.breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        (self.breaks).dedup_by(|a, b| a.value - b.value <= SAME_BREAK * a.value.abs());
    }
}

impl Search<'_> {
    /// Neighbouring samples of different verdict, those around every smallest distance from the border included.
    pub(crate) fn pairs(&self, samples: &[Sample]) -> Vec<[Sample; 2]> {
        let mut samples = samples.to_vec();
        let mut i = 1;
        while i + 1 < samples.len() {
            if let [left, middle, right] = &samples[i - 1..=i + 1]
                && [left.verdict, right.verdict] == [middle.verdict; 2]
                && middle.distance < left.distance
                && middle.distance <= right.distance
                && let Some(between) = self.nearest_miss(left, middle, right)
            {
                let place = if between.value < middle.value {
                    i
                } else {
                    i + 1
                };
                samples.insert(place, between);
                i += 1;
            }
            i += 1;
        }
        (samples.windows(2))
            .filter(|pair| pair[0].verdict != pair[1].verdict)
            .map(|pair| [pair[0].clone(), pair[1].clone()])
            .collect()
    }

    /// Between three samples of one verdict the middle of which is the nearest to the border: a sample of another verdict,
    /// by golden section on the distance; `None` if there is none, or the sequence jumps.
    fn nearest_miss(&self, left: &Sample, middle: &Sample, right: &Sample) -> Option<Sample> {
        const GOLDEN: f64 = 0.381_966_011_250_105_1;
        let (mut low, mut high) = (left.value, right.value);
        let mut best = middle.clone();
        for _ in 0..SECTIONS {
            let (below, above) = (best.value - low, high - best.value);
            let value = if below > above {
                best.value - GOLDEN * below
            } else {
                best.value + GOLDEN * above
            };
            let sample = self.sample_near(value, &[&best]);
            if !sample.is_known() {
                return None;
            }
            if sample.verdict != middle.verdict {
                return Some(sample);
            }
            let nearer = sample.distance < best.distance;
            let (inner, outer) = if nearer {
                (sample.value, best.value)
            } else {
                (best.value, sample.value)
            };
            if outer < inner {
                low = outer;
            } else {
                high = outer;
            }
            if nearer {
                best = sample;
            }
        }
        None
    }

    /// Looks into a change of the verdict.
    pub(crate) fn look_into(&self, [left, right]: &[Sample; 2], found: &mut Found) {
        let halvings = if left.ends_chatter_of(right) {
            HALVINGS
        } else {
            HALVINGS_WITHOUT
        };
        self.close_in(left, right, halvings, found);
    }

    /// Halves a bracket until Newton's method finds a root in it, or nothing is left to halve. A third verdict in between
    /// makes two brackets of it.
    fn close_in(&self, left: &Sample, right: &Sample, halvings: usize, found: &mut Found) {
        let (mut left, mut right) = (left.clone(), right.clone());
        for left_over in (0..halvings).rev() {
            let width = right.value - left.value;
            for sample in [&left, &right] {
                let within = (left.value - width, right.value + width);
                if let Some(root) = self.root_from(sample, within) {
                    found.roots.push(root);
                    return;
                }
            }
            let middle = left.value + width * 0.5;
            if middle <= left.value || middle >= right.value {
                break;
            }
            if found.left == 0 {
                found.unresolved += 1;
                return;
            }
            found.left -= 1;
            let sample = self.sample_near(middle, &[&left, &right]);
            if sample.verdict == left.verdict {
                left = sample;
            } else if sample.verdict == right.verdict {
                right = sample;
            } else {
                let enough = |other: &Sample| {
                    if sample.ends_chatter_of(other) {
                        HALVINGS
                    } else {
                        left_over
                    }
                };
                self.close_in(&left, &sample, enough(&left), found);
                self.close_in(&sample, &right, enough(&right), found);
                return;
            }
        }
        if left.ends_chatter_of(&right) {
            found.breaks.push(break_between(&left, &right));
        }
    }

    /// A root reached from a sample whose sequence comes near u*; `None` if there is none.
    fn root_from(&self, sample: &Sample, within: (f64, f64)) -> Option<Root<f64>> {
        if sample.verdict == Verdict::Elsewhere {
            return None;
        }
        let (release, sequence) = sample.found.as_ref()?;
        let constants = Problem::constants(sample.value, release).ok()?;
        let limits = Limits::new(constants, release, self.extrapolation);
        let nearest = limits.nearest(sequence);
        let impact = sequence.impacts.get(nearest)?;
        if nearest == sequence.begins || limits.distance(impact.local.u()) > NEAR {
            return None;
        }
        let near = release.place();
        let settles = limits.settles(sequence);
        (self.problem)
            .root(sample.value, &near, settles, self.extrapolation, within)
            .ok()
    }
}
