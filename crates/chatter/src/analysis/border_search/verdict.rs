//! The impacts after a release point, up to the verdict complete or incomplete.

use crate::analysis::border::{BorderError, Here, Impact, ReleasePoint, Sequence, Until, Verdict};

/// Contact ends at a release point if it ends this near to it, relative to the size of the states: event location and
/// Newton's method agree to rounding.
const SAME_RELEASE: f64 = 1e-6;

impl Here<'_, f64> {
    /// The impacts after release up to the end of the first chatter sequence. One that belongs to another release point and ends
    /// in flight is a part of the way, complete chatter there the end of it.
    pub(super) fn sequence(
        &self,
        release: &ReleasePoint<f64>,
    ) -> Result<Sequence<f64>, BorderError> {
        let mut after = 0;
        loop {
            let until = Until {
                excursions: self.problem.spec.excursions,
                after,
                ..Until::NEVER
            };
            let mut sequence = self.follow((release.contact, &release.state), until)?;
            // To a release point belongs the chatter that ends there, in contact or in flight.
            let leads_back = || {
                (self.released(&sequence, release.contact))
                    .is_none_or(|state| self.apart(&state, &release.state).1 <= SAME_RELEASE)
            };
            if self.problem.dimensions() > 0 || leads_back() {
                return Ok(sequence);
            }
            match sequence.verdict {
                Verdict::Incomplete => after = sequence.impacts.len(),
                Verdict::Complete => {
                    sequence.verdict = Verdict::Elsewhere;
                    return Ok(sequence);
                }
                _ => return Ok(sequence),
            }
        }
    }

    /// Where the contact is released that chatter ends in, or would if it lasted from the last impact on that presses; `None`
    /// if there is none.
    pub(super) fn released(&self, sequence: &Sequence<f64>, contact: usize) -> Option<Vec<f64>> {
        if sequence.verdict == Verdict::Complete {
            return sequence.released.clone();
        }
        let presses = |impact: &&Impact<f64>| impact.local.acceleration < 0.0;
        let last = sequence.impacts.iter().rev().find(presses)?;
        let rest = self.problem.releases[contact].brought_to_rest(&last.state, &self.parameters);
        (self.problem.plain).contact_until_release(&self.parameters, (contact, &rest))
    }
}
