//! Finding borders: classify over a range, close in on each change of the verdict, and ask whether it is a root of X.

use super::coordinate::{Extrapolation, Limits};
use super::error::{BorderError, Break, BreakCause};
use super::problem::{Problem, exactly};
use super::release::ReleasePoint;
use super::root::Root;
use super::sequence::{Sequence, Verdict};

/// Newton's method starts once the sequence comes this near to u*, relative to u*.
const NEAR: f64 = 0.1;

/// A bracket is halved so often at most: to rounding, whatever its ends.
const HALVINGS: usize = 80;

/// At a break an impact counts as a graze if its rate is this small against the largest rate of the sequence: rates go
/// with the root of the distance, which is halved to rounding.
const GRAZE: f64 = 1e-4;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    pub verdict: Verdict,
    found: Option<(ReleasePoint<f64>, Sequence<f64>)>,
}

/// Borders and other changes of the verdict, both in the order of the parameter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    pub roots: Vec<Root<f64>>,
    pub breaks: Vec<Break>,
}

impl Problem {
    /// The verdict at one parameter value.
    pub(crate) fn sample(
        &self,
        value: f64,
        hint: &mut Option<ReleasePoint<f64>>,
    ) -> Result<Sample, BorderError> {
        let near = hint.as_ref().map(|release| exactly(&release.state));
        let release = self.release_point(value, near.as_deref())?;
        Self::constants(value, &release)?;
        let sequence = self.sequence(value, &release)?;
        *hint = Some(release.clone());
        Ok(Sample {
            value,
            verdict: sequence.verdict,
            found: Some((release, sequence)),
        })
    }

    /// Classifies `count` + 1 values from `low` to `high`; values at which that fails have no verdict. Fails if all do.
    pub(crate) fn scan(
        &self,
        low: f64,
        high: f64,
        count: usize,
    ) -> Result<Vec<Sample>, BorderError> {
        let mut hint = None;
        let mut failure = None;
        let mut samples = Vec::with_capacity(count + 1);
        for i in 0..=count {
            let part = i as f64 / count as f64;
            let value = low + (high - low) * part;
            samples.push(self.sample(value, &mut hint).unwrap_or_else(|error| {
                failure.get_or_insert(error);
                Sample {
                    value,
                    verdict: Verdict::NoChatter,
                    found: None,
                }
            }));
        }
        match failure {
            Some(error) if samples.iter().all(|sample| sample.found.is_none()) => Err(error),
            _ => Ok(samples),
        }
    }

    /// Looks into every change of the verdict between neighbouring samples.
    pub(crate) fn changes(
        &self,
        samples: &[Sample],
        extrapolation: Extrapolation,
    ) -> Result<Found, BorderError> {
        let mut found = Found::default();
        let decided: Vec<&Sample> = samples
            .iter()
            .filter(|s| matches!(s.verdict, Verdict::Complete | Verdict::Incomplete))
            .collect();
        for pair in decided.windows(2) {
            if pair[0].verdict != pair[1].verdict {
                self.close_in(pair[0].clone(), pair[1].clone(), extrapolation, &mut found)?;
            }
        }
        Ok(found)
    }

    /// Halves a bracket until Newton's method finds a root in it, or nothing is left to halve.
    fn close_in(
        &self,
        mut left: Sample,
        mut right: Sample,
        extrapolation: Extrapolation,
        found: &mut Found,
    ) -> Result<(), BorderError> {
        let mut hint = left.found.as_ref().map(|(release, _)| release.clone());
        for _ in 0..HALVINGS {
            let width = right.value - left.value;
            for sample in [&left, &right] {
                let within = (left.value - width, right.value + width);
                if let Some(root) = self.root_from(sample, extrapolation, within) {
                    match grazing_start(&root) {
                        Some(rate) => found.breaks.push(Break {
                            value: root.point.value,
                            cause: BreakCause::Graze { impact: 0, rate },
                        }),
                        None => found.roots.push(root),
                    }
                    return Ok(());
                }
            }
            let middle = left.value + width * 0.5;
            if middle <= left.value || middle >= right.value {
                break;
            }
            let sample = self.sample(middle, &mut hint)?;
            if sample.verdict == left.verdict {
                left = sample;
            } else {
                right = sample;
            }
        }
        found.breaks.push(break_between(&left, &right));
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
        self.root(sample.value, &near, sequence.begins, extrapolation, within)
            .ok()
    }
}

/// The rate of the first impact of a border orbit if it is a graze: then the normal form has no finite slope.
fn grazing_start(root: &Root<f64>) -> Option<f64> {
    let rates = root.point.sequence.impacts.iter().map(|i| i.rate_before);
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
    let cause = match slowest {
        Some((impact, rate, relative)) if relative <= GRAZE => BreakCause::Graze { impact, rate },
        _ => BreakCause::Jump,
    };
    Break {
        value: left.value + (right.value - left.value) * 0.5,
        cause,
    }
}
