//! Finding borders: classify over a range, close in on each change of the verdict and on each near miss, and ask whether
//! it is a root of X.

use super::coordinate::{Extrapolation, Limits};
use super::error::{BorderError, Break, BreakCause};
use super::problem::{Problem, exactly};
use super::release::ReleasePoint;
use super::root::{Point, Root};
use super::sequence::{SHORTEST, Sequence, Verdict};
use crate::numerics::Real;

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

/// At a break an impact counts as a graze if its rate is this small against the largest rate of the sequence: rates go
/// with the root of the distance, which is halved to rounding.
const GRAZE: f64 = 1e-4;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    pub verdict: Verdict,
    /// |X|, roughly: the distance from the border in the sequence's own coordinate.
    distance: f64,
    found: Option<(ReleasePoint<f64>, Sequence<f64>)>,
}

impl Sample {
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

impl Problem {
    /// The verdict at one parameter value.
    fn sample(
        &self,
        value: f64,
        hint: &mut Option<ReleasePoint<f64>>,
    ) -> Result<Sample, BorderError> {
        let near = hint.as_ref().map(|release| exactly(&release.state));
        let release = self.release_point(value, near.as_deref())?;
        let constants = Self::constants(value, &release)?;
        let sequence = self.sequence(value, &release)?;
        *hint = Some(release.clone());
        let limits = Limits::new(constants, &release, Extrapolation::default());
        Ok(Sample {
            value,
            verdict: sequence.verdict,
            distance: limits.rough_distance(&sequence),
            found: Some((release, sequence)),
        })
    }

    /// Classifies parameter values, each near the one before; values at which that fails have no verdict. The error is
    /// the first failure.
    pub(crate) fn scan(
        &self,
        values: &[f64],
        mut hint: Option<ReleasePoint<f64>>,
    ) -> (Vec<Sample>, Option<BorderError>) {
        let mut failure = None;
        let mut samples = Vec::with_capacity(values.len());
        for &value in values {
            samples.push(self.sample(value, &mut hint).unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Sample {
                    value,
                    verdict: Verdict::NoChatter,
                    distance: f64::INFINITY,
                    found: None,
                }
            }));
        }
        (samples, failure)
    }

    /// Looks into every change of the verdict between neighbouring samples, and into every smallest distance from the
    /// border between them.
    pub(crate) fn changes(
        &self,
        samples: &[Sample],
        extrapolation: Extrapolation,
    ) -> Result<Found, BorderError> {
        let mut found = Found::default();
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
        let changes: Vec<&[Sample]> = (samples.windows(2))
            .filter(|pair| pair[0].verdict != pair[1].verdict)
            .collect();
        // None may leave the others without.
        let share = (MOST_SAMPLES / changes.len().max(1)).max(LEAST_SHARE);
        for pair in changes {
            found.left = share;
            let complete = pair
                .iter()
                .any(|sample| sample.verdict == Verdict::Complete);
            let halvings = if complete { HALVINGS } else { HALVINGS_WITHOUT };
            self.close_in(&pair[0], &pair[1], halvings, extrapolation, &mut found)?;
        }
        found
            .roots
            .sort_by(|a, b| a.point.value.total_cmp(&b.point.value));
        found.roots.dedup_by(|a, b| a.is_same(b));
        found.breaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        (found.breaks).dedup_by(|a, b| a.value - b.value <= SAME_BREAK * a.value.abs());
        Ok(found)
    }

    /// Between three samples of one verdict the middle of which is the nearest to the border: a sample of another verdict,
    /// by golden section on the distance; `None` if there is none, or the sequence jumps.
    fn nearest_miss(&self, left: &Sample, middle: &Sample, right: &Sample) -> Option<Sample> {
        const GOLDEN: f64 = 0.381_966_011_250_105_1;
        let mut hint = middle.found.as_ref().map(|(release, _)| release.clone());
        let (mut low, mut high) = (left.value, right.value);
        let mut best = middle.clone();
        for _ in 0..SECTIONS {
            let (below, above) = (best.value - low, high - best.value);
            let value = if below > above {
                best.value - GOLDEN * below
            } else {
                best.value + GOLDEN * above
            };
            let sample = self.sample(value, &mut hint).ok()?;
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
        extrapolation: Extrapolation,
        found: &mut Found,
    ) -> Result<(), BorderError> {
        let (mut left, mut right) = (left.clone(), right.clone());
        let mut hint = left.found.as_ref().map(|(release, _)| release.clone());
        for left_over in (0..halvings).rev() {
            let width = right.value - left.value;
            for sample in [&left, &right] {
                let within = (left.value - width, right.value + width);
                if let Some(root) = self.root_from(sample, extrapolation, within) {
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
            let sample = match self.sample(middle, &mut hint) {
                Ok(sample) => sample,
                Err(_) => Sample {
                    value: middle,
                    verdict: Verdict::NoChatter,
                    distance: f64::INFINITY,
                    found: None,
                },
            };
            if sample.verdict == left.verdict {
                left = sample;
            } else if sample.verdict == right.verdict {
                right = sample;
            } else {
                let left_over = if sample.verdict == Verdict::Complete {
                    HALVINGS
                } else {
                    left_over
                };
                self.close_in(&left, &sample, left_over, extrapolation, found)?;
                return self.close_in(&sample, &right, left_over, extrapolation, found);
            }
        }
        if [left.verdict, right.verdict].contains(&Verdict::Complete) {
            found.breaks.push(break_between(&left, &right));
        }
        Ok(())
    }

    /// A root reached from a sample whose sequence comes near u*; `None` if there is none.
    fn root_from(
        &self,
        sample: &Sample,
        extrapolation: Extrapolation,
        within: (f64, f64),
    ) -> Option<Root<f64>> {
        let (release, sequence) = sample.found.as_ref()?;
        let constants = Self::constants(sample.value, release).ok()?;
        let limits = Limits::new(constants, release, extrapolation);
        let nearest = limits.nearest(sequence);
        let impact = sequence.impacts.get(nearest)?;
        if nearest == sequence.begins || limits.distance(impact.local.u()) > NEAR {
            return None;
        }
        let near = exactly(&release.state);
        let settles = limits.settles(sequence);
        self.root(sample.value, &near, settles, extrapolation, within)
            .ok()
    }
}

/// The rate of the first impact of a border orbit if it is a graze: then the normal form has no finite slope.
pub(crate) fn grazing_start<R: Real>(point: &Point<R>) -> Option<f64> {
    let rates = (point.sequence.impacts.iter()).map(|impact| impact.rate_before.to_f64());
    let largest = rates
        .clone()
        .fold(0.0_f64, |most, rate| most.max(rate.abs()));
    rates.take(1).find(|rate| rate.abs() <= GRAZE * largest)
}

/// What makes the verdict change where no root is.
fn break_between(left: &Sample, right: &Sample) -> Break {
    let slowest = [left, right]
        .into_iter()
        .filter_map(|sample| sample.found.as_ref())
        .filter_map(|(_, sequence)| {
            let rates: Vec<f64> = sequence.impacts.iter().map(|i| i.rate_before).collect();
            let largest = rates
                .iter()
                .fold(0.0_f64, |most, rate| most.max(rate.abs()));
            // Within the sequence rates shrink as they should: a graze stands before it or at its beginning.
            let until = (sequence.begins + 1).min(rates.len());
            (rates[..until].iter().enumerate())
                .map(|(impact, &rate)| (impact, rate, rate.abs() / largest))
                .min_by(|a, b| a.2.total_cmp(&b.2))
        })
        .min_by(|a, b| a.2.total_cmp(&b.2));
    let incomplete = [left, right]
        .into_iter()
        .filter(|sample| sample.verdict == Verdict::Incomplete)
        .find_map(|sample| sample.found.as_ref());
    let shortest = |(_, sequence): &(ReleasePoint<f64>, Sequence<f64>)| {
        sequence.impacts.len() <= sequence.begins + SHORTEST
    };
    let cause = match slowest {
        Some((impact, rate, relative)) if relative <= GRAZE => BreakCause::Graze { impact, rate },
        _ if incomplete.is_some_and(shortest) => BreakCause::Short { impacts: SHORTEST },
        _ if incomplete.is_none() => BreakCause::NoChatter,
        _ => BreakCause::Jump,
    };
    Break {
        value: left.value + (right.value - left.value) * 0.5,
        cause,
    }
}
