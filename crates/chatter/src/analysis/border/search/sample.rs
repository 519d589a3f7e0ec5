//! What the impact sequence at one parameter value does.

use super::super::coordinate::sequence::{Impact, Sequence, Verdict};
use super::super::error::BorderError;
use super::super::problem::{Here, Problem};
use super::super::release::equations::ReleasePoint;

/// Newton's method starts once the sequence comes this near to u*, relative to u*.
const NEAR: f64 = 0.1;

/// What the sequence at one parameter value does.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub value: f64,
    pub verdict: Verdict,
    /// |X|, roughly: the distance from the border in the sequence's own coordinate.
    pub distance: f64,
    /// The impact from which on the sequence is near u*, and whether it comes near enough for Newton's method.
    pub settles: usize,
    pub is_near: bool,
    /// None where there is no release point, or what follows it is not known.
    pub found: Option<(ReleasePoint<f64>, Sequence<f64>)>,
}

impl Sample {
    /// Where nothing is known.
    pub fn unknown(value: f64) -> Self {
        Self {
            value,
            verdict: Verdict::NoChatter,
            distance: f64::INFINITY,
            settles: 0,
            is_near: false,
            found: None,
        }
    }

    /// Whether there is a release point, and no chatter within what was followed.
    pub fn is_without_chatter(&self) -> bool {
        self.found.is_some() && self.verdict == Verdict::NoChatter
    }

    /// Whether chatter is complete at one of two samples only.
    pub fn ends_chatter_of(&self, other: &Self) -> bool {
        (self.verdict == Verdict::Complete) != (other.verdict == Verdict::Complete)
    }
}

impl Here<'_, f64> {
    /// What follows a release point.
    pub(crate) fn sample(&self, release: ReleasePoint<f64>) -> Result<Sample, BorderError> {
        let limits = self.limits(&release)?;
        let sequence = self.sequence(&release)?;
        let is_elsewhere = sequence.verdict == Verdict::Elsewhere;
        let nearest = limits.nearest(&sequence);
        let near = |impact: &Impact<f64>| limits.distance(impact.local.u()) <= NEAR;
        Ok(Sample {
            value: self.value,
            verdict: sequence.verdict,
            distance: if is_elsewhere {
                f64::INFINITY
            } else {
                limits.rough_distance(&sequence)
            },
            settles: limits.settles(&sequence),
            is_near: !is_elsewhere
                && nearest > sequence.begins
                && sequence.impacts.get(nearest).is_some_and(near),
            found: Some((release, sequence)),
        })
    }
}

impl Problem {
    /// The verdict at a value near one of these samples.
    pub(super) fn sample_near(&self, value: f64, near: &[&Sample]) -> Sample {
        let sampled = near.iter().find_map(|near| {
            let (release, _) = near.found.as_ref()?;
            let here = self.at(value).ok()?;
            let (release, _) = here.followed(near.value, release)?;
            here.sample(release).ok()
        });
        sampled.unwrap_or_else(|| Sample::unknown(value))
    }
}
