//! Finding borders: classify over a range, close in on each change of the verdict and on each near miss, and ask whether
//! it is a root of X.

use super::breaks::break_between;
use super::coordinate::{Extrapolation, Limits};
use super::error::{BorderError, Break};
use super::problem::{Problem, exactly};
use super::release::ReleasePoint;
use super::root::Root;
use super::sequence::{Sequence, Verdict};

/// Newton's method starts once the sequence comes this near to u*, relative to u*.
const NEAR: f64 = 0.1;

/// A bracket is halved so often at most: to rounding, whatever its ends.
const HALVINGS: usize = 80;

/// Where chatter is complete at neither end, only this often: a piece with complete chatter in between would be narrower
/// than a thousandth.
const HALVINGS_WITHOUT: usize = 10;

/// A smallest distance from u* between samples is looked for in so many steps of the golden section, which leave a
/// millionth of the bracket: X is quadratic there.
const SECTIONS: usize = 29;

/// Where the verdict changes from sample to sample, as it may where passages before the sequence are chaotic, no more than
/// so many further sequences are followed, or so many in each part if that is more.
const MOST_SAMPLES: usize = 10_000;
const LEAST_SHARE: usize = 200;

/// Breaks this near to each other, relative to the parameter, are told as one.
const SAME_BREAK: f64 = 1e-6;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    pub verdict: Verdict,
    /// |X|, roughly: the distance from the border in the sequence's own coordinate.
    distance: f64,
    pub found: Option<(ReleasePoint<f64>, Sequence<f64>)>,
}

impl Sample {
    /// Where there is no release point, or what follows it is not known.
    fn unknown(value: f64) -> Self {
        Self {
            value,
            verdict: Verdict::NoChatter,
            distance: f64::INFINITY,
            found: None,
        }
    }

    /// Whether there is a release point, and no chatter within what was followed.
    pub(crate) fn is_without_chatter(&self) -> bool {
        self.is_known() && self.verdict == Verdict::NoChatter
    }

    /// Whether chatter is complete at one of two samples only.
    fn ends_chatter_of(&self, other: &Self) -> bool {
        (self.verdict == Verdict::Complete) != (other.verdict == Verdict::Complete)
    }

    /// Whether there is a release point, and what follows it is known.
    pub(crate) fn is_known(&self) -> bool {
        self.found.is_some()
    }
}

/// Borders and other changes of the verdict, both in the order of the parameter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    pub roots: Vec<Root<f64>>,
    pub breaks: Vec<Break>,
    /// Changes of the verdict that were not looked into.
    pub unresolved: usize,
    /// Sequences that may still be followed.
    left: usize,
}

impl Found {
    /// In order, each root and each break once.
    fn sort(&mut self) {
        (self.roots).sort_by(|a, b| a.point.value.total_cmp(&b.point.value));
        self.roots.dedup_by(|a, b| a.is_same(b));
        self.breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        (self.breaks).dedup_by(|a, b| a.value - b.value <= SAME_BREAK * a.value.abs());
    }
}

/// The search along the branches of release points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search<'a> {
    problem: &'a Problem,
    extrapolation: Extrapolation,
    /// Whether there is more than one branch.
    several: bool,
}

impl Problem {
    /// Classifies parameter values in order, along each branch of release points; values at which that fails have no
    /// verdict. The error is the first failure, if nothing is known at any value.
    pub(crate) fn scan(&self, values: &[f64]) -> Result<Vec<Vec<Sample>>, BorderError> {
        let branches = self.branches(values)?;
        let search = Search {
            problem: self,
            extrapolation: Extrapolation::default(),
            several: branches.len() > 1,
        };
        let mut failure = None;
        let mut sampled = |value: f64, point: Option<ReleasePoint<f64>>| match point {
            None => Sample::unknown(value),
            Some(point) => search.sample(value, point).unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Sample::unknown(value)
            }),
        };
        let samples: Vec<Vec<Sample>> = branches
            .into_iter()
            .map(|branch| {
                (values.iter().zip(branch.points))
                    .map(|(&value, point)| sampled(value, point))
                    .collect()
            })
            .collect();
        match failure {
            Some(error) if !samples.iter().flatten().any(Sample::is_known) => Err(error),
            _ => Ok(samples),
        }
    }

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
    /// Looks into all of them.
    pub(crate) fn all(&self) -> Result<Found, BorderError> {
        let mut found = Found::default();
        for pair in &self.pairs {
            self.look_into(pair, &mut found)?;
        }
        found.sort();
        Ok(found)
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
            self.look_into(pair, &mut found)?;
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

    fn look_into(&self, [left, right]: &[Sample; 2], found: &mut Found) -> Result<(), BorderError> {
        // None may leave the others without.
        found.left = (MOST_SAMPLES / self.pairs.len().max(1)).max(LEAST_SHARE);
        let halvings = if left.ends_chatter_of(right) {
            HALVINGS
        } else {
            HALVINGS_WITHOUT
        };
        self.search.close_in(left, right, halvings, found)
    }
}

impl Search<'_> {
    /// The verdict at one parameter value.
    fn sample(&self, value: f64, release: ReleasePoint<f64>) -> Result<Sample, BorderError> {
        let constants = Problem::constants(value, &release)?;
        let sequence = self.problem.sequence(value, &release, self.several)?;
        let limits = Limits::new(constants, &release, Extrapolation::default());
        Ok(Sample {
            value,
            verdict: sequence.verdict,
            distance: match sequence.verdict {
                Verdict::Elsewhere => f64::INFINITY,
                _ => limits.rough_distance(&sequence),
            },
            found: Some((release, sequence)),
        })
    }

    /// The verdict at a value near one of these samples.
    fn sample_near(&self, value: f64, near: &[&Sample]) -> Sample {
        let known = near.iter().filter_map(|near| {
            let (release, _) = near.found.as_ref()?;
            let expected = exactly(&release.expected(value - near.value));
            self.problem.release_point(value, &expected).ok()
        });
        let mut sampled = known.filter_map(|release| self.sample(value, release).ok());
        sampled.next().unwrap_or_else(|| Sample::unknown(value))
    }

    /// Neighbouring samples of different verdict, those around every smallest distance from the border included.
    fn pairs(&self, samples: &[Sample]) -> Vec<[Sample; 2]> {
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

    /// Halves a bracket until Newton's method finds a root in it, or nothing is left to halve. A third verdict in between
    /// makes two brackets of it.
    fn close_in(
        &self,
        left: &Sample,
        right: &Sample,
        halvings: usize,
        found: &mut Found,
    ) -> Result<(), BorderError> {
        let (mut left, mut right) = (left.clone(), right.clone());
        for left_over in (0..halvings).rev() {
            let width = right.value - left.value;
            for sample in [&left, &right] {
                let within = (left.value - width, right.value + width);
                if let Some(root) = self.root_from(sample, within) {
                    found.roots.push(root);
                    return Ok(());
                }
            }
            let middle = left.value + width * 0.5;
            if middle <= left.value || middle >= right.value {
                break;
            }
            if found.left == 0 {
                found.unresolved += 1;
                return Ok(());
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
                self.close_in(&left, &sample, enough(&left), found)?;
                return self.close_in(&sample, &right, enough(&right), found);
            }
        }
        if left.ends_chatter_of(&right) {
            found.breaks.push(break_between(&left, &right));
        }
        Ok(())
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
        let near = exactly(&release.state);
        let settles = limits.settles(sequence);
        (self.problem)
            .root(sample.value, &near, settles, self.extrapolation, within)
            .ok()
    }
}
