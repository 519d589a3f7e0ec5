//! Where a curve in two parameters comes back to where it began.

use super::follower::Follower;
use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::branch::{Began, End, returned};
use crate::analysis::periodic::condition::Bordered;

impl Follower {
    /// The end where the curve comes back, between two stations, to where it began: the gap to there is looked at as any other.
    pub(super) fn closes(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        bordered: &Bordered,
    ) -> Option<End> {
        let (origin, passages) = &self.began;
        let began = Began {
            origin: &origin.at,
            passages,
        };
        let reader = self.shooting.clone();
        let mut held = bordered.of(&mut self.shooting);
        let (last, ahead) = returned(&mut held, &reader, ((from, to), step), began)?;
        // Told from another event both have other tangents, but in the parameters.
        let scales = reader.scales();
        let free = last.at.len() - reader.parameters()..last.at.len();
        let headed = free.fold(0.0, |sum, place| {
            let scale = scales[place] * scales[place];
            sum + last.tangent[place] * origin.tangent[place] / scale
        });
        let end = self.between(from, (&last, ahead), bordered);
        if end.is_some() {
            return end;
        }
        if headed < 0.0 {
            return Some(End::Back);
        }
        if self.shooting.evaluate(&last.at).is_ok() {
            let told = self.told(&last);
            self.points.push(told);
        }
        Some(End::Closed)
    }
}
