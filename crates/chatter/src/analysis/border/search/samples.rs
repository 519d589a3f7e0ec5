//! What the impact sequences over a parameter do.

use super::super::coordinate::limits::{Extrapolation, Limits};
use super::super::coordinate::sequence::{Sequence, Verdict};
use super::super::error::BorderError;
use super::super::problem::Problem;
use super::super::release::equations::ReleasePoint;
use core::ops::ControlFlow;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    pub verdict: Verdict,
    /// |X|, roughly: the distance from the border in the sequence's own coordinate.
    pub distance: f64,
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
    pub(crate) fn ends_chatter_of(&self, other: &Self) -> bool {
        (self.verdict == Verdict::Complete) != (other.verdict == Verdict::Complete)
    }

    /// Whether there is a release point, and what follows it is known.
    pub(crate) fn is_known(&self) -> bool {
        self.found.is_some()
    }
}

/// The search along the branches of release points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search<'a> {
    pub problem: &'a Problem,
    pub extrapolation: Extrapolation,
    /// Whether there is more than one branch.
    pub several: bool,
}

/// Goes on, and looks at nothing.
pub(crate) fn unwatched(_: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

impl Problem {
    /// Classifies parameter values in order, along each branch of release points; values at which that fails have no
    /// verdict. The error is the first failure, if nothing is known at any value.
    /// None if `watch`, which hears what part is done, breaks off.
    pub(crate) fn scan(
        &self,
        values: &[f64],
        watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Option<Vec<Vec<Sample>>>, BorderError> {
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
        let total = (branches.len() * values.len()) as f64;
        let mut samples: Vec<Vec<Sample>> = Vec::new();
        for branch in branches {
            let mut along = Vec::with_capacity(values.len());
            for (&value, point) in values.iter().zip(branch.points) {
                let done = samples.len() * values.len() + along.len();
                if watch(done as f64 / total).is_break() {
                    return Ok(None);
                }
                along.push(sampled(value, point));
            }
            samples.push(along);
        }
        match failure {
            Some(error) if !samples.iter().flatten().any(Sample::is_known) => Err(error),
            _ => Ok(Some(samples)),
        }
    }
}

impl Search<'_> {
    /// The verdict at one parameter value.
    fn sample(&self, value: f64, release: ReleasePoint<f64>) -> Result<Sample, BorderError> {
        let constants = Problem::constants(value, &release)?;
        let sequence = (self.problem.sequence(value, &release, self.several))
            .map_err(|error| error.with_parameter(value))?;
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
    pub(crate) fn sample_near(&self, value: f64, near: &[&Sample]) -> Sample {
        let known = near.iter().filter_map(|near| {
            let (release, _) = near.found.as_ref()?;
            let expected = release.expected(value - near.value);
            self.problem.returning(value, &expected).ok()
        });
        let mut sampled = known.filter_map(|release| self.sample(value, release).ok());
        sampled.next().unwrap_or_else(|| Sample::unknown(value))
    }
}
