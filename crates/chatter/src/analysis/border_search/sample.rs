//! What the impact sequence at one parameter value does.

use super::unfollowed::end_of_motion;
use crate::analysis::border::{
    BorderError, Here, Impact, Problem, ReleasePoint, Sequence, Verdict,
};
use crate::flow::FlowError;

/// Newton's method starts once the sequence comes this near to u*, relative to u*.
const NEAR: f64 = 0.1;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    /// None where there is none.
    pub release: Option<ReleasePoint<f64>>,
    /// What follows it, or why that is not known.
    pub sequence: Option<Result<Sequence<f64>, BorderError>>,
    pub verdict: Verdict,
    /// |X|, roughly: the distance from the border in the sequence's own coordinate.
    pub distance: f64,
    /// The impact from which on the sequence is near u*, and whether it comes near enough for Newton's method.
    pub settles: usize,
    pub is_near: bool,
}

impl Sample {
    /// Where nothing is known.
    pub fn unknown(value: f64) -> Self {
        Self {
            value,
            release: None,
            sequence: None,
            verdict: Verdict::NoChatter,
            distance: f64::INFINITY,
            settles: 0,
            is_near: false,
        }
    }

    /// What follows the release point, if that is known.
    pub fn sequence(&self) -> Option<&Sequence<f64>> {
        self.sequence.as_ref()?.as_ref().ok()
    }

    /// Why the motion after the release point cannot be followed, if it cannot.
    pub fn failure(&self) -> Option<&FlowError> {
        end_of_motion(self.sequence.as_ref()?.as_ref().err()?)
    }

    /// Whether there is a release point, and no chatter within what was followed.
    pub fn is_without_chatter(&self) -> bool {
        self.sequence().is_some() && self.verdict == Verdict::NoChatter
    }

    /// Whether chatter is complete at one of two samples only.
    pub fn ends_chatter_of(&self, other: &Self) -> bool {
        (self.verdict == Verdict::Complete) != (other.verdict == Verdict::Complete)
    }
}

impl Here<'_, f64> {
    /// What follows a release point.
    pub(crate) fn sample(&self, release: ReleasePoint<f64>) -> Sample {
        let mut sample = Sample::unknown(self.value);
        let limits = self.limits(&release);
        let followed = limits.and_then(|limits| {
            Ok((
                limits,
                self.sequence(&release, self.problem.spec.excursions)?,
            ))
        });
        if let Ok((limits, sequence)) = &followed {
            sample.verdict = sequence.verdict;
            sample.settles = limits.settles(sequence);
            if sequence.verdict != Verdict::Elsewhere {
                let nearest = limits.nearest(sequence);
                let near = |impact: &Impact<f64>| limits.distance(impact.local.u()) <= NEAR;
                sample.distance = limits.rough_distance(sequence);
                sample.is_near =
                    nearest > sequence.begins && sequence.impacts.get(nearest).is_some_and(near);
            }
        }
        sample.release = Some(release);
        sample.sequence = Some(followed.map(|(_, sequence)| sequence));
        sample
    }
}

impl Problem {
    /// The verdict at a value near one of these samples.
    pub(super) fn sample_near(&self, value: f64, near: &[&Sample]) -> Sample {
        let sampled = near.iter().find_map(|near| {
            let here = self.at(value).ok()?;
            let sample = here.sample(here.followed(near)?.0);
            sample.sequence().is_some().then_some(sample)
        });
        sampled.unwrap_or_else(|| Sample::unknown(value))
    }
}
