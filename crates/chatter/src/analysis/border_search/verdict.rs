//! The impacts after a release point, up to the verdict complete or incomplete.

use crate::analysis::border::{
    BorderError, Here, Impact, ReleasePoint, Sequence, Until, Verdict, until_release,
};
use crate::numerics::moved;

/// Contact ends at a release point if it ends this near to it, relative to the size of the states: event location and
/// Newton's method agree to rounding.
const SAME_RELEASE: f64 = 1e-6;

impl Here<'_, f64> {
    /// The impacts after release up to the end of the first chatter sequence, before which there are so many long flights at most. One
    /// that belongs to another release point and ends in flight is a part of the way, complete chatter there the end of it.
    pub(super) fn sequence(
        &self,
        release: &ReleasePoint<f64>,
        excursions: usize,
    ) -> Result<Sequence<f64>, BorderError> {
        let mut after = 0;
        loop {
            let until = Until {
                excursions,
                after,
                ..Until::NEVER
            };
            let mut sequence = self.follow((release.contact, &release.state), until)?;
            // To a release point belongs the chatter that ends there, in contact or in flight.
            let leads_back = || {
                (self.released(&sequence, release.contact))
                    .is_none_or(|state| self.is_of_surface(release, &state))
            };
            if leads_back() {
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

    /// Whether a state in which contact ends is on the piece of the surface of release points that one of them is on: where that has its
    /// coordinates, phases up to whole turns. Without coordinates it is the same point.
    fn is_of_surface(&self, release: &ReleasePoint<f64>, state: &[f64]) -> bool {
        let (off, _) = self.apart(&release.state, state);
        let by: Vec<f64> = release.free.iter().map(|&i| off[i]).collect();
        let expected = moved(&release.state, &release.along(&by), 1.0);
        let equations = &self.problem.releases[release.contact];
        let found = equations.converge(&self.parameters, &expected, &release.free);
        found.is_some_and(|found| self.apart(&found.at, state).1 <= SAME_RELEASE)
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
        let system = &self.problem.plain.system;
        let (mut work, mut trajectory) = system.trajectory_from(&self.parameters, &rest).ok()?;
        until_release(system, &mut work, &mut trajectory, contact)
    }
}
